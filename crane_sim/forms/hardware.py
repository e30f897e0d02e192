"""The groups of a scene file on what stands between a law and the crane: sensors, actuators, brakes, faults."""

import re
from typing import Annotated, Any, NamedTuple, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field

from crane_sim.forms.groups import Group, picked
from crane_sim.quantities import NonNegative, Positive, Real, no_switch

ALL = "all"
"""Stands for every joint in place of a joint's name."""
_NAME = re.compile("[a-z][a-z0-9]*(_[a-z0-9]+)*")
MOST_PERIODS = 100_000  # of a delay, or between two samples
Fitted = TypeVar("Fitted", bound=Group)


def _pair(value: Any) -> Any:
    return value if isinstance(value, list | tuple) else (value, value)


def _range(value: Any) -> Any:
    if isinstance(value, list | tuple):
        return value
    if isinstance(no_switch(value), int | float) and value > 0:
        return -value, value
    raise ValueError("must be a number greater than 0, or [low, high]")


def _ordered(value: tuple[float, float]) -> tuple[float, float]:
    if not value[0] < value[1]:
        raise ValueError("must be [low, high] with low < high")
    return value


def _named(faults: dict[str, Any]) -> dict[str, Any]:
    for name in faults:
        if not _NAME.fullmatch(name):
            raise ValueError(f"{name!r}: a fault's name is of small letters, digits and single _, a letter first")
    return faults


Sizes = Annotated[tuple[NonNegative, NonNegative], BeforeValidator(_pair)]
Reals = Annotated[tuple[Real, Real], BeforeValidator(_pair)]
Limits = Annotated[tuple[Real, Real], BeforeValidator(_range), AfterValidator(_ordered)]
Chance = Annotated[float, BeforeValidator(no_switch), Field(ge=0.0, le=1.0, allow_inf_nan=False)]


class SensorGroup(Group):
    """A joint's sensor; pairs are of position and velocity, one number stands for both."""

    noise: Sizes = (0.0, 0.0)  # standard deviation
    bias: Reals = (0.0, 0.0)
    quantisation: Sizes = (0.0, 0.0)  # step of the digits
    delay: NonNegative = 0.0  # s, rounded to whole periods
    rate: Positive | None = None  # Hz, rounded to whole periods; None: every period
    dropout: Chance = 0.0  # chance that a sample is lost


class ActuatorGroup(Group):
    """A joint's drive, in the units of its effort."""

    limit: Limits | None = None
    rate_limit: Positive | None = None  # 1/s
    lag: NonNegative = 0.0  # s, time constant
    deadband: NonNegative = 0.0
    delay: NonNegative = 0.0  # s, rounded to whole periods


class BrakeGroup(Group):
    """The brakes of all actuated joints; what is left out is computed from the crane."""

    capacity: tuple[NonNegative, ...] | None = None  # (nu,)
    frequency: Positive | None = None  # rad/s
    damping: NonNegative = 0.7


def _times_complaint(begin: float | None, end: float | None) -> str:
    if end is None or (begin is not None and begin < end):
        return ""
    return f"until = {end:g}: must be after at = {begin:g}" if begin is not None else f"until = {end:g}: needs an at"


class SensorStuck(NamedTuple):
    """A sensor that shows what it showed when this began."""

    joint: str
    at: NonNegative | None = None  # s
    until: NonNegative | None = None

    def complaint(self) -> str:
        """Return what is wrong with the times, or an empty line."""
        return _times_complaint(self.at, self.until)


class SensorLoss(SensorStuck):
    """A sensor that shows zero."""


class Stuck(SensorStuck):
    """A joint that its brake holds, its drive off."""


class EffortLoss(NamedTuple):
    """A drive that delivers only a part of its effort."""

    joint: str
    factor: NonNegative = 0.0
    at: NonNegative | None = None
    until: NonNegative | None = None

    def complaint(self) -> str:
        """Return what is wrong with the times, or an empty line."""
        return _times_complaint(self.at, self.until)


class PayloadChange(NamedTuple):
    """Another mass of the payload."""

    mass: Positive  # kg
    at: NonNegative | None = None
    until: NonNegative | None = None

    def complaint(self) -> str:
        """Return what is wrong with the times, or an empty line."""
        return _times_complaint(self.at, self.until)


FAULTS: dict[str, Any] = {
    "sensor_stuck": SensorStuck,
    "sensor_loss": SensorLoss,
    "effort_loss": EffortLoss,
    "stuck": Stuck,
    "payload": PayloadChange,
}
"""Kinds of faults, in the order of `hardware.faults.KINDS`."""
Fault = Annotated[Any, picked("kind", FAULTS)]


class HardwareGroups(Group):
    """Groups that every crane may have."""

    brake: BrakeGroup | None = None
    sensors: dict[str, SensorGroup] = {}  # by joint, or `all`
    actuators: dict[str, ActuatorGroup] = {}  # by actuated joint, or `all`
    faults: Annotated[dict[str, Fault], AfterValidator(_named)] = {}


def source(groups: dict[str, Fitted], joint: str, key: str) -> str:
    """Return under which name a joint's key is given: its own, or `all`."""
    return joint if joint in groups and key in groups[joint].model_fields_set else ALL


def merged(groups: dict[str, Fitted], joint: str, kind: type[Fitted]) -> Fitted:
    """Return the group of a joint: its own keys, else those of `all`."""
    found: dict[str, Any] = {}
    for name in (ALL, joint):
        group = groups.get(name)
        if group is not None:
            found |= {key: getattr(group, key) for key in group.model_fields_set}
    return kind.model_construct(**found)
