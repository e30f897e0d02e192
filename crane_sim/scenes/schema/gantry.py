"""The form of a scene file with a gantry or ship-to-shore crane, and the model that it describes."""

from functools import cached_property
from math import inf
from typing import Any, Literal

import numpy as np
from pydantic import field_validator

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, LengthRange, NonNegative, Positive, Real
from crane_sim.models.effects import PayloadDrag
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.stops import LEAD_TIME, MIN_LENGTH, Stops
from crane_sim.models.supports.bridge import Bridge, DrivenAxis
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import ForceHoist, RateHoist
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.actuated import actuated
from crane_sim.scenes.schema.backlash import (
    JointDrives,
    drive_names,
    drive_start,
    drive_units,
    geared,
    known_joints,
    shaft_frequency,
)
from crane_sim.scenes.schema.contact import ContactGroup
from crane_sim.scenes.schema.exchange import exchange_of, windages_of
from crane_sim.scenes.schema.falls import FallsGroup, check_ends, load_at_rest, stiffest_frequency
from crane_sim.scenes.schema.friction_checks import friction_rate
from crane_sim.scenes.schema.groups import Channel, Group, PayloadForceGroup
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.reference import ReferenceGroup, compile_path
from crane_sim.scenes.schema.rigging import (
    ATTITUDE,
    Payload,
    Quaternion,
    Vector,
    attitude_of,
    attitude_rate,
    check_equipment,
)
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.schema.spreader import SpreaderEvent, contact_of, ground_velocity
from crane_sim.trajectories.inputs import Constant, Inputs
from crane_sim.trajectories.trajectory import Trajectory

SUPPORT_JOINTS = ("trolley", "m", "N"), ("bridge", "m", "N")  # (name, unit of its position, unit of its effort)


class Hoist(Group):
    """The winch, which drives the length of all falls."""

    drive: Literal["force", "rate"] = "rate"  # what its input is: an effort on the falls' common length [N], positive
    # pays out; or the length's acceleration [m/s²]
    mass: Positive | None = None  # kg, of a `force` drive: inertia of drum and motor over the square of the drum's
    # radius, times the square of rope paid out per length of the falls
    time_constant: Positive | None = None  # s, of a `rate` drive, whose input is then a rate [m/s], followed with this
    # lag; left out: the input is an acceleration
    limits: LengthRange | None = None  # m, of the falls' unstretched length; a run ends where one is reached

    @property
    def effort_unit(self) -> str:
        """Unit of the winch's command."""
        if self.drive == "force":
            return "N"
        return "m/s²" if self.time_constant is None else "m/s"

    def model(self) -> ForceHoist | RateHoist:
        """Return the winch.

        Raises:
            SceneError: a key belongs to the other drive, or is missing.
        """
        if self.drive == "rate":
            if self.mass is not None:
                raise SceneError("hoist.mass: only a force drive has one, this drive is 'rate'")
            return RateHoist(self.time_constant)
        if self.time_constant is not None:
            raise SceneError("hoist.time_constant: only a rate drive has one, this drive is 'force'")
        if self.mass is None:
            raise SceneError("hoist.mass: is missing; a force drive needs it")
        return ForceHoist(self.mass)


class Initial(Group):
    """The state at t = 0; a load whose position is left out hangs at rest below the trolley."""

    trolley: Real = 0.0  # m, position of the trolley
    bridge: Real = 0.0  # m, position of bridge or portal
    length: Positive  # m, unstretched length of the falls
    v: tuple[Real, Real, Real] = (0.0, 0.0, 0.0)  # m/s, of trolley, bridge and length
    skew: Angle | None = None  # rad, angle about the vertical at which the load is held until t = 0
    position: Vector | None = None  # m, of the load's centre of mass, with `orientation`
    orientation: Quaternion | None = None  # -, unit quaternion (w, x, y, z) from the load's axes to the base's
    velocity: Vector = (0.0, 0.0, 0.0)  # m/s, of the load's centre of mass
    angular_velocity: Vector = (0.0, 0.0, 0.0)  # rad/s, of the load, in its own axes


class Reference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Real, Real, Positive] | None = None  # m, where trolley, bridge and hoist should end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    trolley: Channel = Constant(0.0)  # N, force along x
    bridge: Channel = Constant(0.0)  # N, force along y
    hoist: Channel = Constant(0.0)  # effort's unit, as `hoist.drive` says


class GantryFile(SceneFile):
    """A scene with a gantry or ship-to-shore crane: a trolley on a travelling portal, a spreader on elastic falls."""

    crane: Literal["gantry"]  # which form the file has
    gravity: NonNegative = 9.81  # m/s², acceleration of free fall
    trolley: DrivenAxis  # along x
    bridge: DrivenAxis  # the bridge or portal, along y
    hoist: Hoist = Hoist()  # the winch
    falls: FallsGroup  # the ropes
    payload: Payload  # spreader and container, one rigid body; its attachment is the spreader's origin
    initial: Initial  # the state at t = 0
    contact: ContactGroup | None = None  # what the load can be set down on; left out: nothing is below it
    payload_drag: PayloadDrag | None = None  # drag of still air on the payload
    payload_force: PayloadForceGroup | None = None  # a given force on the payload
    events: tuple[SpreaderEvent, ...] = ()  # exchanges of the payload at given times
    friction: dict[str, Friction] = {}  # by joint, trolley or bridge: its dry friction
    lugre: dict[str, LuGre] = {}  # the same by bristles, of joints without `friction`
    backlash: dict[str, JointDrives] = {}  # by joint, trolley or bridge: its drives, one or several side by side, which
    # have play; a joint that is left out has none
    reference: Reference | None = None  # where the crane should go
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    @field_validator("friction", "lugre", "backlash", mode="before")
    @classmethod
    def _check_names(cls, group: Any) -> Any:
        """Reject groups of joints that the support does not have, before their values are read."""
        return known_joints(group, [name for name, _, _ in SUPPORT_JOINTS])

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: trolley, bridge, the falls' length, the load's position and attitude, drives with play."""
        drives = drive_names(self.backlash, SUPPORT_JOINTS)
        return "trolley", "bridge", "hoist", "payload_x", "payload_y", "payload_z", *ATTITUDE, *drives

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions."""
        return (*("m",) * 6, *("1",) * 4, *drive_units(self.backlash, SUPPORT_JOINTS))

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands."""
        return "N", "N", self.hoist.effort_unit

    def _load(self) -> RigidLoad:
        load = self.payload.load()
        if not isinstance(load, RigidLoad):
            raise SceneError("payload.inertia: is missing; a load on falls is a rigid body")
        return load

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return (*self._start, *self._drives[0])

    @property
    def _drives(self) -> tuple[Any, Any]:
        """(q, v) of drives with play."""
        start = self.initial
        return drive_start(self.backlash, SUPPORT_JOINTS, (start.trolley, start.bridge), start.v)

    @property
    def _start(self) -> tuple[float, ...]:
        """Positions at t = 0 of all joints but drives with play."""
        start = self.initial
        if start.position is not None:
            if start.skew is not None:
                raise SceneError("initial.skew: not with initial.position; give initial.orientation instead")
            return (start.trolley, start.bridge, start.length, *start.position, *attitude_of(start.orientation))
        if start.orientation is not None:
            raise SceneError("initial.orientation: needs initial.position; initial.skew turns a load at rest")
        return self._start_at_rest

    @cached_property
    def _start_at_rest(self) -> tuple[float, ...]:
        """Joint positions (10,) at t = 0 with the load at rest, solved for once."""
        start = self.initial
        return self._hanging((start.trolley, start.bridge, start.length), start.skew)

    def _hanging(self, actuated: tuple[float, ...], skew: float | None) -> tuple[float, ...]:
        """Return the joint positions (10,) with the load at rest below these of the actuated joints (3,)."""
        (trolley, bridge, length), load = actuated, self._load()
        position, attitude = load_at_rest(self.falls.falls(length, load), load, self.gravity, skew)
        x, y, z = position.tolist()
        return trolley, bridge, length, trolley + x, bridge + y, z, *attitude.tolist()

    def rest_positions(self, target: tuple[float, ...]) -> tuple[float, ...]:
        """Return the joint positions (nq,) of the crane at rest at a target of the actuated joints (nu,)."""
        return self._hanging(target, None)

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        start = self.initial
        turning = attitude_rate(self._start[6:10], start.angular_velocity)
        return (*start.v, *start.velocity, *turning, *self._drives[1])

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints."""
        return self.reference.q if self.reference is not None else None

    @property
    def payload_mass(self) -> float:
        """Mass of the payload at t = 0 [kg]."""
        return self.payload.mass

    @property
    def rope_length(self) -> float:
        """Distance [m] of the load's centre of mass from the middle of the falls' upper ends at t = 0."""
        x, y, z = np.array(self.initial_q[3:6]) - (self.initial.trolley, self.initial.bridge, 0.0)
        return float(np.linalg.norm((x, y, z)))

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        return limits_of(
            ("trolley", "trolley.limits", self.trolley.limits),
            ("bridge", "bridge.limits", self.bridge.limits),
            ("hoist", "hoist.limits", self.hoist.limits),
        )

    @property
    def payload_height(self) -> float:
        """Height of the payload above the base's origin at t = 0 [m]."""
        return self.initial_q[5]

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        return windages_of(self.payload, self.events)

    def path(self) -> Trajectory | None:
        """Return the compiled path, None where the scene has none."""
        return compile_path(self.reference, self)

    def method_requirements(self, sampled: bool) -> MethodRequirements:
        """Return the scene's requirements on its method."""
        load, masses = self._load(), (self.trolley.mass, self.trolley.mass + self.bridge.mass, self.hoist.mass)
        q, contact = np.array(self.initial_q), self._contact(load)
        loads = [load, *(event.payload.load() for event in self.events)]
        frequency = max(self._frequency(each, masses, q, contact) for each in loads if isinstance(each, RigidLoad))
        if contact is not None:  # slip decays at this rate where it is slower than the slip velocity
            frequency = max(frequency, self.gravity * contact.surface.friction / contact.surface.slip_velocity)
        moved = dict(zip(("trolley", "bridge"), masses[:2], strict=True))
        rates = [friction_rate(group.get(name), moved[name]) for group in (self.friction, self.lugre) for name in moved]
        frequency = max(frequency, shaft_frequency(self.backlash), *rates)
        return MethodRequirements(frequency, 0.0, elastic=True, smooth=False, duration=self.duration)

    def _frequency(self, load: RigidLoad, masses: Any, q: Any, contact: Any) -> float:
        """Return the largest frequency [rad/s] of a load in place of the first one at joints q (10,)."""
        return stiffest_frequency(self.falls.falls(self.initial.length, load), load, masses, q, contact)

    def _contact(self, load: RigidLoad) -> Any:
        return contact_of(self.contact, self.events, load, self.initial_q[3:10])

    def model(self) -> FallsCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        load, base_motion, force = self._load(), self.base_motion, self.payload_force
        support = Bridge(self.trolley, self.bridge)
        _, exchange = exchange_of(self.payload, self.events, ground_velocity(self.contact))
        check_equipment(self, self.payload, ("trolley", "bridge"))
        check_ends(self.falls.falls(self.initial.length, load), np.array(self.initial_q))
        return FallsCrane(
            geared(actuated(support, self, SUPPORT_JOINTS), self.backlash, SUPPORT_JOINTS),
            self.falls.falls(self.initial.length, load),
            load,
            self.hoist.model(),
            self.gravity,
            self.payload_drag,
            base=base_motion.base(self.seed, self.duration) if base_motion is not None else None,
            force=force.force() if force is not None else None,
            stops=self._stops(),
            wind=self.airflow(),
            contact=self._contact(load),
            exchange=exchange,
        )

    def _stops(self) -> Stops:
        low, high = self.hoist.limits or (0.0, inf)
        least = MIN_LENGTH - min(self.falls.offsets or (0.0,))  # of the common length: no fall may lose its own
        return Stops(max(low, least), high, LEAD_TIME if low <= least else 0.0)

    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the open-loop inputs, zero where one is left out; constant zero efforts without `inputs`."""
        if self.inputs is None:
            return (0.0,) * len(self.actuated)
        return Inputs(self.inputs.trolley, Inputs(self.inputs.bridge, Inputs(self.inputs.hoist, None)))
