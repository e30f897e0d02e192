"""The groups of a scene file on hardware between law and crane: sensors, drives, brakes, faults."""

import re
from math import inf
from typing import Annotated, Any, Literal, NamedTuple, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field

from crane_sim.files.errors import shorten
from crane_sim.files.types import NonNegative, Positive, Real, reject_bool
from crane_sim.scenes.schema.groups import BY_SPEED, Group, tagged_union_validator

ALL = "all"
"""Key for every joint in place of a joint's name."""
_NAME = re.compile("[a-z][a-z0-9]*(_[a-z0-9]+)*")
MAX_PERIODS = 100_000  # of a delay, or between two samples
JointGroup = TypeVar("JointGroup", bound=Group)


def _as_pair(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else (value, value)


def _range(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return value
    if isinstance(reject_bool(value), int | float) and value > 0:
        return -value, value
    raise ValueError("must be a number greater than 0, or [low, high]")


def _check_order(value: tuple[float, float]) -> tuple[float, float]:
    if not value[0] < value[1]:
        raise ValueError("must be [low, high] with low < high")
    return value


def _check_names(faults: dict[str, Any]) -> dict[str, Any]:
    for name in faults:
        if not _NAME.fullmatch(name):
            raise ValueError(
                f"{shorten(name)}: a fault's name is of small letters, digits and single _, a "
                "letter first"
            )
    return faults


PositiveOrInfinite = Annotated[
    float, Field(allow_inf_nan=True), Field(gt=0.0), BeforeValidator(reject_bool)
]
Sizes = Annotated[tuple[NonNegative, NonNegative], BeforeValidator(_as_pair)]
Reals = Annotated[tuple[Real, Real], BeforeValidator(_as_pair)]
Limits = Annotated[tuple[Real, Real], BeforeValidator(_range), AfterValidator(_check_order)]
Probability = Annotated[
    float, BeforeValidator(reject_bool), Field(ge=0.0, le=1.0, allow_inf_nan=False)
]


class SensorGroup(Group):
    """Errors of a joint's sensor; pairs are of position and velocity, one number stands for both.

    Keys of a joint go before those of `all`. Measurements are published as `joint_states`, the only
    input of a law. Random numbers depend on seed, signal and step: every run repeats to the last
    bit.
    """

    noise: Sizes = (0.0, 0.0)  # joint's unit, standard deviation, of position and velocity; drawn
    # for every sample
    bias: Reals = (0.0, 0.0)  # joint's unit, what is added to every sample
    quantisation: Sizes = (0.0, 0.0)  # joint's unit, step to which a sample is rounded; 0 for none
    delay: NonNegative = 0.0  # s, age of a sample when it is published; rounded to whole periods
    # (`rounded` of the summary)
    rate: Positive | None = None  # Hz, of samples, which hold until the next one; rounded to whole
    # periods; left out: every period
    dropout: Probability = 0.0  # -, chance that a sample is lost; the last one stays


class MotorGroup(Group):
    """A motor behind a gear: its inertia moves with the joint; speed limits its torque."""

    ratio: Positive  # rad/joint's unit, turns of the motor for the joint's motion; of a wheel or
    # drum of radius r: n/r
    inertia: NonNegative = 0.0  # kg m², of rotor and gear about the motor's shaft; adds ratio² × it
    # to the joint's
    torque: Positive = inf  # N m, the largest one up to the base speed; left out: no limit
    base_speed: NonNegative = 0.0  # rad/s, of the motor, from which on the largest torque falls
    no_load_speed: Positive = inf  # rad/s, of the motor, at which it has fallen to 0 in a line;
    # with `torque`


class ServoGroup(Group):
    """Reference generator and loops of a speed or position drive, as of a frequency converter.

    The command, held for a period, becomes a reference within the limits below, in closed form. The
    speed loop is effort = gain × (e + integral of e / integral_time), e: reference's speed less the
    joint's; the effort is limited by `limit` and `motor`, where the integral is clamped.
    """

    gain: PositiveOrInfinite  # effort's unit s/joint's unit, effort for a deviation of the speed;
    # `.inf`: the joint follows its reference exactly
    integral_time: Positive | None = None  # s, of the speed loop; left out: none, a static load
    # costs speed
    position_gain: Positive | None = None  # 1/s, with `drive: position`: speed for a deviation of
    # the position, sampled once a period
    max_speed: Positive | None = None  # joint's unit/s, largest speed of the reference; left out:
    # any
    max_acceleration: Positive | None = None  # joint's unit/s², largest acceleration of the
    # reference; left out: any
    max_jerk: Positive | None = None  # joint's unit/s³, largest rate of that acceleration; left
    # out: any


Command = Annotated[Literal["effort", "velocity", "position"], BY_SPEED]


class ActuatorGroup(Group):
    """Dynamics of a joint's drive, in the units of its effort.

    Within a period the effort solves u' = (demand - u) / lag within the rate limit exactly. Keys of
    a joint go before those of `all`. Laws, inputs and commands give what `drive` says, a speed or a
    position in the joint's unit. Commands are held for a period; `inputs` are continuous, delayed
    and limited as well, but by a drive with a lag, a rate limit or a servo they are taken once a
    period (`held_inputs` of the summary).
    """

    drive: Command = "effort"  # what the drive is commanded; the latter two are
    # followed as `servo` says
    servo: ServoGroup | None = None  # reference and loops with `drive: velocity` or `position`

    limit: Limits | None = None  # effort's unit, range of the effort; one number stands for
    # [-number, number]; left out: none
    rate_limit: Positive | None = None  # effort's unit/s, largest rate of the effort; left out:
    # none
    lag: NonNegative = 0.0  # s, time constant T of u' = (demand - u) / T, solved exactly within a
    # period
    limit_switches: Annotated[tuple[Real, Real], AfterValidator(_check_order)] | None = (
        None  # joint's unit, beyond
    )
    # either the drive is off and its brake (`brake`) engaged to the end of the run; read at the
    # ends of periods, the distance travelled beyond is in the summary; left out: none
    motor: MotorGroup | None = None  # of a drive by force or torque; left out: no inertia, no limit
    # by speed
    deadband: NonNegative = 0.0  # command's unit, demands up to this size count as zero
    delay: NonNegative = 0.0  # s, from the demand to its effect; rounded to whole periods
    initial_demand: Real | None = None  # command's unit, before t = 0, where a delay, lag or rate
    # limit begins; left out: a force or torque carries the weight on its joint, a position is the
    # initial one, everything else is 0


class BrakeGroup(Group):
    """Brakes of all actuated joints: of a stuck one, or without commands (`--on-silence brake`).

    An acceleration drive is decelerated and held, a winch with `drive: rate` gets zero, a servo its
    present position. The static load is that on a base at the mean of its motion. A payload that
    swings up to the angle A pulls its trolley with at most its weight × max sin a (3 cos a - 2 cos
    A), for any mass of the trolley: 0.6 × the weight up to 45 degrees, 1.5 × up to 90; give that as
    `capacity`. The default of a trolley whose payload hangs at first, 2 m/s² × (trolley + payload),
    holds 12 degrees under any trolley, and 45 where the trolley weighs twice its payload.
    """

    capacity: tuple[NonNegative, ...] | None = None  # effort's unit, largest effort of each
    # actuated joint's brake; left out: twice the static load of the initial posture and what
    # decelerates all that the joint carries by 2 rad/s² or m/s²
    frequency: Positive | None = None  # rad/s, of a free joint on its brake's spring; left out:
    # computed from the crane
    damping: NonNegative = 0.7  # -, ratio of that spring


def _find_times_error(begin: float | None, end: float | None) -> str:
    if end is None or (begin is not None and begin < end):
        return ""
    return (
        f"until = {end:g}: must be after at = {begin:g}"
        if begin is not None
        else f"until = {end:g}: needs an at"
    )


class SensorStuck(NamedTuple):
    """A sensor that repeats its sample from the beginning of the fault."""

    joint: str  # joint of the sensor or brake
    at: NonNegative | None = None  # s, when it begins; left out: by the service `~/faults/NAME` or
    # by `plant.set_fault`
    until: NonNegative | None = None  # s, when it ends; left out: never

    def find_error(self) -> str:
        """Return an error of the times, or an empty line."""
        return _find_times_error(self.at, self.until)


class SensorLoss(SensorStuck):
    """A sensor that measures zero."""


class Stuck(SensorStuck):
    """A joint that its brake holds, its drive off."""


class EffortLoss(NamedTuple):
    """A drive that delivers only a part of its effort."""

    joint: str  # joint of the drive
    factor: NonNegative = 0.0  # -, part of the effort that is left
    at: NonNegative | None = None  # s, when it begins; left out: by service
    until: NonNegative | None = None  # s, when it ends; left out: never

    def find_error(self) -> str:
        """Return an error of the times, or an empty line."""
        return _find_times_error(self.at, self.until)


class PayloadChange(NamedTuple):
    """Another mass of the payload."""

    mass: Positive  # kg, of the payload from then on
    at: NonNegative | None = None  # s, when it begins; left out: by service
    until: NonNegative | None = None  # s, when it ends; left out: never

    def find_error(self) -> str:
        """Return an error of the times, or an empty line."""
        return _find_times_error(self.at, self.until)


FAULTS: dict[str, Any] = {
    "sensor_stuck": SensorStuck,
    "sensor_loss": SensorLoss,
    "effort_loss": EffortLoss,
    "stuck": Stuck,
    "payload": PayloadChange,
}
"""Kinds of faults, in the order of `hardware.faults.KINDS`."""
Fault = Annotated[Any, tagged_union_validator("kind", FAULTS)]


class HardwareGroups(Group):
    """Groups that every crane may have."""

    brake: BrakeGroup | None = None  # brakes of all actuated joints, for silent controllers and
    # stuck joints
    sensors: dict[
        str, SensorGroup
    ] = {}  # by joint, or `all`: errors of the measurements in `joint_states`, which laws take
    actuators: dict[str, ActuatorGroup] = {}  # by actuated joint, or `all`: dynamics of the drives
    faults: Annotated[dict[str, Fault], AfterValidator(_check_names)] = {}  # by a name of your own,
    # in small letters; a fault is there in every period that begins at or after its time; a slack
    # cable is no fault


def group_name(groups: dict[str, JointGroup], joint: str, key: str) -> str:
    """Return the name under which a joint's key is given: its own, or `all`."""
    return joint if joint in groups and key in groups[joint].model_fields_set else ALL


def merge_groups(groups: dict[str, JointGroup], joint: str, kind: type[JointGroup]) -> JointGroup:
    """Return the group of a joint: its own keys, else those of `all`."""
    keys: dict[str, Any] = {}
    for name in (ALL, joint):
        group = groups.get(name)
        if group is not None:
            keys |= {key: getattr(group, key) for key in group.model_fields_set}
    return kind.model_construct(**keys)
