"""The form of a scene file with a knuckle-boom crane, and the model that it describes."""

from math import cos, sin
from typing import Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, NonNegative, Positive, Real, Tilt
from crane_sim.models.cables.rope import ForceRope, LockedRope, RateRope
from crane_sim.models.effects import BoomSpring, JibSpring, PayloadDrag, RopeSpring
from crane_sim.models.loads import PointLoad
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.single_rope.joint_friction import Contacts, JointFriction, JointLuGre
from crane_sim.models.stops import Stops
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.groups import Channel, Friction, Group, PayloadForceGroup
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.knuckle_checks import check_rods, checked_friction
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.motors import reflected_inertia
from crane_sim.scenes.schema.reference import ReferenceGroup, compile_path
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.schema.winch import Rope
from crane_sim.trajectories.inputs import Constant, Inputs
from crane_sim.trajectories.trajectory import Trajectory


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
    friction: JointFriction | None = None  # dry friction of the actuated joints
    lugre: JointLuGre | None = None  # the same by bristles, of joints without `friction`
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
        return "N m", "N m", "N m", *self.rope.effort_unit

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
    def payload_height(self) -> float:
        """Height of the payload above the tower's foot at t = 0 [m]."""
        _, beta, gamma, length, tangential, radial = self.initial.q
        return self.boom.length * sin(beta) + self.jib.length * sin(gamma) - length * cos(tangential) * cos(radial)

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        bodies = {"payload": self.payload, "boom": self.boom, "jib": self.jib}
        return {f"{name}.windage": body.windage for name, body in bodies.items()}

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
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

    def method_requirements(self, sampled: bool) -> MethodRequirements:
        """Return the scene's requirements on its method."""
        smooth = not sampled and self._stops() is None
        return MethodRequirements(None, 0.0, elastic=False, smooth=smooth, duration=self.duration)

    def model(self) -> Crane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        check_rods(self.boom, self.jib)
        support = Knuckle(self.boom, self.jib, self.tower, self.springs.boom, self.springs.jib, self._motors())
        crane = Crane(support, self._cable(), self.payload, self.gravity, self.swing_friction, self.payload_drag)
        base_motion, force = self.base_motion, self.payload_force
        return crane._replace(
            base=base_motion.base(self.seed, self.duration) if base_motion is not None else None,
            force=force.force() if force is not None else None,
            stops=self._stops(),
            wind=self.airflow(),
            friction=self._joint_friction(),
        )

    def _motors(self) -> tuple[float, float, float] | None:
        """Return the inertias of the motors of slew, boom and jib [kg m²], None without any."""
        if reflected_inertia(self, "rope") > 0.0:
            raise SceneError("actuators.rope.motor.inertia: the winch of rope.drive: force has no inertia; must be 0")
        slew, boom, jib = (reflected_inertia(self, name) for name in ("slew", "boom", "jib"))
        return (slew, boom, jib) if slew or boom or jib else None

    def _joint_friction(self) -> Contacts | None:
        return checked_friction(self.friction or JointFriction(), self.lugre or JointLuGre(), self.rope.drive)

    def _stops(self) -> Stops | None:
        """Return the stops of the run, None where nothing has to be watched."""
        return self.rope.stops(bool(self.limits or self._joint_friction()))

    def _cable(self) -> ForceRope | RateRope | LockedRope:
        drive = self.rope.drive
        self.rope.check(self.initial.q[3], self.initial.v[3], 3)
        if self.springs.rope is not None and drive != "force":
            raise SceneError(f"springs.rope: only a force drive can have one, this drive is {drive!r}")
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
