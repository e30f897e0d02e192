"""Base class of scene files of cranes whose support turns: a rope below it, further links, a rigid-body payload."""

from collections.abc import Mapping
from math import cos, inf, sin
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.models.stops import Stops
from crane_sim.scenes.schema.actuated import has_strength
from crane_sim.scenes.schema.backlash import drive_names, drive_units, shaft_frequency
from crane_sim.scenes.schema.flexibility import structure_frequency
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.rigged import RiggedFile
from crane_sim.scenes.schema.rigging import ATTITUDE, RiggingStart, link_names, rigging_start
from crane_sim.scenes.schema.supported import SupportedFile
from crane_sim.scenes.schema.winch import ReevedRope
from crane_sim.trajectories.inputs import Constant, Inputs


class SuspendedFile(SupportedFile, RiggedFile):
    """The groups of all such cranes; a schema adds its support, its initial state, reference and inputs."""

    rope: ReevedRope = ReevedRope()  # the winch

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: the support's, rope, two angles of swing, further links, the payload's attitude, bending, drives."""
        own = tuple(name for name, _, _ in self.support_joints)
        body = ATTITUDE if self.payload.inertia is not None else ()
        drives = drive_names(self.backlash, self.support_joints)
        rope = "rope", "swing_tangential", "swing_radial"
        return (*own, *rope, *link_names(len(self.links)), *body, *self._bending, *drives)

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions."""
        own, drives = [unit for _, unit, _ in self.support_joints], drive_units(self.backlash, self.support_joints)
        bends = ("rad",) * len(self._bending)
        further = len(self.joint_names) - len(own) - 3 - len(bends) - len(drives)
        return (*own, "m", "rad", "rad", *("1",) * further, *bends, *drives)

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands, of the actuated joints only."""
        return (*(unit for _, _, unit in self.driven_joints), *self.rope.effort_unit)

    @property
    def actuated(self) -> tuple[str, ...]:
        """Joints that take commands: those of the support, and the rope that a winch drives."""
        return (*(name for name, _, _ in self.driven_joints), *(("rope",) if self.rope.effort_unit else ()))

    @property
    def _suspended_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""
        return self.payload.mass + sum(link.mass for link in self.links)

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        return (*self.support_limits, *limits_of(("rope", "rope.limits", self.rope.limits)))

    def _rigging(self) -> tuple[Any, Any]:
        """Return (q, v) of further links and attitude."""
        ns, q, v = len(self.support_joints), self._initial.q, self._initial.v
        yaw, rate = self.tip(q).yaw, v[0] if self._slews else 0.0
        rope = rope_direction(yaw, rate, q[ns + 1 : ns + 3], v[ns + 1 : ns + 3])
        start = self._initial.rigging or RiggingStart()
        if self.rope.torsion is not None:
            start = start.nearest_to(yaw)
        return rigging_start(start, len(self.links), self.payload.inertia is not None, rope)

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return (
            *self._initial.q,
            *self._rigging()[0],
            *self._deflections(self._initial.q),
            *self._initial_drive_state[0],
        )

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return (*self._initial.v, *self._rigging()[1], *(0.0,) * len(self._bending), *self._initial_drive_state[1])

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints."""
        reference = self._reference
        return reference.q[: len(self.effort_units)] if reference is not None and reference.q is not None else None

    @property
    def rope_length(self) -> float:
        """Length of rope and further links at t = 0 [m]."""
        return self._initial.q[len(self.support_joints)] + sum(link.length for link in self.links)

    @property
    def payload_height(self) -> float:
        """Height of the payload's attachment above the base's origin at t = 0 [m]."""
        q, ns = self._initial.q, len(self.support_joints)
        further = [self._rigging()[0][3 * k + 2] * link.length for k, link in enumerate(self.links)]
        return self.tip(q).position[2] - q[ns] * cos(q[ns + 1]) * cos(q[ns + 2]) + sum(further)

    @property
    def lowest_pressure(self) -> float:
        """Height [m] above the base's origin below which no wind presses on the payload, where the tip keeps its."""
        if self.base_motion is not None or self._bending or self.tip_mobility()[2, 2] != 0.0:
            return -inf
        start = self._initial.q
        free = self.rope.limits[1] if self.rope.limits is not None else inf
        longest = start[len(self.support_joints)] if self.rope.drive == "locked" else free
        return self._lowest_below(self.tip(start).position[2], longest)

    def resting_joints(self, target: tuple[float, ...]) -> Mapping[str, float]:
        """Return the angles [rad] of the structure's modes, by joint, at rest at a target (nu,); none of a rigid one.

        Raises:
            SceneError: it bends too far.
        """
        return dict(zip(self._bending, self._left_to_rest()._deflections(target), strict=True))

    def method_requirements(self, sampled: bool) -> MethodRequirements:
        """Return the scene's requirements on its method."""
        smooth = not (sampled or self._stops() or self.has_quadratic_loss)
        ns, mobility = len(self.support_joints), self.tip_mobility()
        rates = shaft_frequency(self.backlash), self._twist_frequency(float(mobility[3, 3])), self._friction_rate()
        rope = min((self._initial.q[ns], *(self.target or ())[len(self.driven_joints) :]))
        stiffest = max(*rates, self._swing_frequency(rope, mobility))
        if self._bending:
            stiffest = max(stiffest, structure_frequency(self.support(), self._elevation_and_length(self._initial.q)))
        return MethodRequirements(stiffest or None, 0.0, elastic=False, smooth=smooth, duration=self.duration)

    def _stops(self) -> Stops | None:
        """Return the conditions that end a run, None where nothing ends or switches it."""
        return self.rope.stops(bool(self.limits)) or (Stops() if self._has_events else None)

    @property
    def _has_events(self) -> bool:
        """Whether something other than limits switches the model or ends a run."""
        rubs = has_strength(self.friction, self.lugre)
        return bool(self.events or self.backlash or self.rope.torsion or rubs or self.is_in_kinked_wind)

    def model(self) -> Any:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        ns, start = len(self.support_joints), self._initial
        self.rope.check(start.q[ns], start.v[ns], ns)
        self.rope.check_surroundings(self)
        names = tuple(name for name, _, _ in self.support_joints)
        geared_joints = (*names, "rope") if self.rope.takes_motor else names
        hoist, stops = self.rope.drive_of(self), self._stops()
        return self.suspended_crane(self._driven_support(), start.q[ns], hoist, stops, geared_joints)

    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the open-loop inputs, zero where one is left out; constant zero efforts without `inputs`.

        Raises:
            SceneError: there is an input of a slew or a rope that no drive moves.
        """
        inputs = getattr(self, "inputs", None)
        if inputs is None:
            return (0.0,) * len(self.actuated)
        self._check_inputs(inputs)
        if "rope" in inputs.model_fields_set and not self.rope.effort_unit:
            raise SceneError(f"inputs.rope: drives nothing, rope.drive = {self.rope.drive!r}; leave it out")
        return Inputs(tuple(getattr(inputs, name, Constant(0.0)) for name in self.actuated))


def rope_direction(yaw: float, yaw_rate: float, angles: Any, rates: Any) -> tuple[Any, Any]:
    """Return the rope's unit vector and its rate, each (3,), in the axes of the base.

    Args:
        yaw, yaw_rate: of the support's frame [rad], [rad/s].
        angles, rates: of the swing (θ1, θ2) in that frame.
    """
    (s1, c1, s2, c2), (w1, w2) = (sin(angles[0]), cos(angles[0]), sin(angles[1]), cos(angles[1])), rates
    n, u = (s2, c2 * s1, -c2 * c1), (c2 * w2, c2 * c1 * w1 - s2 * s1 * w2, c2 * s1 * w1 + s2 * c1 * w2)
    u = (u[0] - yaw_rate * n[1], u[1] + yaw_rate * n[0], u[2])
    s, c = sin(yaw), cos(yaw)
    return (c * n[0] - s * n[1], s * n[0] + c * n[1], n[2]), (c * u[0] - s * u[1], s * u[0] + c * u[1], u[2])
