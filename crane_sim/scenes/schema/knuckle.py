"""The form of a scene file with a knuckle-boom crane, and the model that it describes."""

from math import inf
from typing import Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, LengthRange, NonNegative, Positive, Real, Tilt
from crane_sim.models.cables.rope import ForceRope, LockedRope, RateRope
from crane_sim.models.effects import BoomSpring, JibSpring, PayloadDrag, RopeSpring
from crane_sim.models.loads import PointLoad
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.stops import LEAD_TIME, MIN_LENGTH, Stops
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.scenes.schema.groups import Channel, Friction, Group, PayloadForceGroup
from crane_sim.scenes.schema.integrator import Demands
from crane_sim.scenes.schema.knuckle_checks import check_rods
from crane_sim.scenes.schema.limits import Limit, limits_of
from crane_sim.scenes.schema.reference import ReferenceGroup, compile_path
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.trajectories.inputs import Constant, Inputs
from crane_sim.trajectories.trajectory import Trajectory


class Rope(Group):
    """Drive of the rope by the winch."""

    drive: Literal["force", "rate", "locked"] = "force"  # what the input of the winch is: an effort [N], positive pays
    # out; the rope's acceleration [m/s²]; or nothing, the length stays
    time_constant: Positive | None = None  # s, of a `rate` drive, whose input is then a rate [m/s], followed with this
    # lag; left out: the input is an acceleration
    limits: LengthRange | None = None  # m, of the length; a run ends where one is reached
    slack: Literal["allow", "stop"] = "allow"  # stop: a run ends where the rope would push


class Springs(Group):
    """Springs on joints."""

    boom: BoomSpring | None = None  # on the boom's elevation
    jib: JibSpring | None = None  # on the jib's elevation, or its angle from the boom
    rope: RopeSpring | None = None  # along the rope; it can push, too; with `rope.drive: force`


class Initial(Group):
    """Joint coordinates at t = 0, in joint order; boom and jib are elevations from the horizontal."""

    q: tuple[Angle, Angle, Angle, Positive, Tilt, Tilt]  # rad, slew, boom, jib, rope [m], swing_tangential,
    # swing_radial; angles may be text such as `30 deg`
    v: tuple[Real, Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # rad/s, of the same joints; of the
    # rope [m/s]


class Reference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Angle, Angle, Angle, Positive] | None = None  # rad, where slew, boom, jib and rope [m] should end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    slew: Channel = Constant(0.0)  # N m, torque about the vertical
    boom: Channel = Constant(0.0)  # N m, torque on the elevation
    jib: Channel = Constant(0.0)  # N m, torque on the elevation
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class KnuckleFile(SceneFile):
    """A scene with a knuckle-boom crane: a tower that slews, a boom and a jib that luff, a payload on a rope."""

    crane: Literal["knuckle"]  # which form the file has
    gravity: NonNegative = 9.81  # m/s², acceleration of free fall
    boom: Rod  # the rod at the tower
    jib: Rod  # the rod at the boom's end
    tower: Tower  # what slews besides boom and jib
    rope: Rope = Rope()  # the winch
    payload: PointLoad  # a point mass at the rope's end
    initial: Initial  # the state at t = 0
    springs: Springs = Springs()  # springs on joints
    swing_friction: Friction = None  # friction of the swing joints
    payload_drag: PayloadDrag | None = None  # drag of still air on the payload
    payload_force: PayloadForceGroup | None = None  # a given force on the payload
    reference: Reference | None = None  # where the crane should go
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: three of the boom, the rope's length, two angles of its swing."""
        return "slew", "boom", "jib", "rope", "swing_tangential", "swing_radial"

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions."""
        return "rad", "rad", "rad", "m", "rad", "rad"

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return self.initial.q

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return self.initial.v

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands, of the actuated joints only."""
        if self.rope.drive == "locked":
            return "N m", "N m", "N m"
        imposed = "m/s²" if self.rope.time_constant is None else "m/s"
        return "N m", "N m", "N m", imposed if self.rope.drive == "rate" else "N"

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints."""
        return self.reference.q[: len(self.effort_units)] if self.reference and self.reference.q else None

    @property
    def payload_mass(self) -> float:
        """Mass of the payload at t = 0 [kg]."""
        return self.payload.mass

    @property
    def rope_length(self) -> float:
        """Length of the rope at t = 0 [m]."""
        return self.initial.q[3]

    @property
    def limits(self) -> tuple[Limit, ...]:
        """Travel limits of the joints that have some."""
        return limits_of(
            ("slew", "tower.limits", self.tower.limits),
            ("boom", "boom.limits", self.boom.limits),
            ("jib", "jib.limits", self.jib.limits),
            ("rope", "rope.limits", self.rope.limits),
        )

    def path(self) -> Trajectory | None:
        """Return the compiled path, None where the scene has none."""
        return compile_path(self.reference, self)

    def demands(self, sampled: bool) -> Demands:
        """Return the scene's requirements on its method."""
        smooth = not sampled and self._stops() is None
        return Demands(None, 0.0, elastic=False, smooth=smooth, duration=self.duration)

    def model(self) -> Crane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        check_rods(self.boom, self.jib)
        support = Knuckle(self.boom, self.jib, self.tower, self.springs.boom, self.springs.jib)
        crane = Crane(support, self._cable(), self.payload, self.gravity, self.swing_friction, self.payload_drag)
        base_motion, force = self.base_motion, self.payload_force
        return crane._replace(
            base=base_motion.base(self.seed, self.duration) if base_motion is not None else None,
            force=force.force() if force is not None else None,
            stops=self._stops(),
        )

    def _stops(self) -> Stops | None:
        """Return the stops of the run, None where there are none."""
        rope, by_rate = self.rope, self.rope.drive == "rate"  # whose length can reach zero under any load
        if rope.limits is not None and rope.drive == "locked":
            raise SceneError("rope.limits: belong to a rope that a winch moves, this drive is 'locked'")
        if by_rate and not self.initial.q[3] >= MIN_LENGTH:
            raise SceneError(f"initial.q[3] = {self.initial.q[3]}: a rope by rate is at least {MIN_LENGTH:g} m long")
        if not (self.limits or by_rate or rope.slack == "stop"):
            return None
        taut, (low, high) = float(rope.slack == "stop"), rope.limits or (0.0, inf)
        if low > MIN_LENGTH or not (by_rate or rope.limits is not None):
            return Stops(low, high, taut=taut)
        return Stops(MIN_LENGTH, high, LEAD_TIME, taut)

    def _cable(self) -> ForceRope | RateRope | LockedRope:
        drive = self.rope.drive
        if self.rope.time_constant is not None and drive != "rate":
            raise SceneError(f"rope.time_constant: only a rate drive has one, this drive is {drive!r}")
        if self.springs.rope is not None and drive != "force":
            raise SceneError(f"springs.rope: only a force drive can have one, this drive is {drive!r}")
        if drive == "locked" and self.initial.v[3] != 0.0:
            raise SceneError(f"initial.v[3] = {self.initial.v[3]}: a locked rope starts at rest")
        if drive == "locked":
            return LockedRope(self.initial.q[3])
        return RateRope(self.rope.time_constant) if drive == "rate" else ForceRope(self.springs.rope)

    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the open-loop inputs, zero where one is left out; constant zero efforts without `inputs`."""
        inputs = self.inputs
        if inputs is None:
            return (0.0,) * len(self.actuated)
        winch = None if self.rope.drive == "locked" else Inputs(inputs.rope)
        return Inputs(inputs.slew, Inputs(inputs.boom, Inputs(inputs.jib, winch)))
