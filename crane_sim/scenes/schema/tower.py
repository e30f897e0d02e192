"""The schema of a scene file with a tower crane, and the model that it describes."""

from math import cos, inf, sin
from typing import Annotated, Any, ClassVar, Literal

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, Positive, Real, Tilt
from crane_sim.models.supports.flexible import FlexibleSupport
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.models.supports.tower_crane import JibTrolley, LockedSlew, Slew, TowerCrane
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.backlash import SupportJoints
from crane_sim.scenes.schema.flexibility import JibFlexibility, flexible_jib
from crane_sim.scenes.schema.groups import Channel, Group, tagged_union_validator
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.mast import angles_at_rest, tilt_inertia, trolley_place
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.rigging import RiggingStart
from crane_sim.scenes.schema.supported import JointMobility, SupportedFile, Tip
from crane_sim.scenes.schema.suspended import SuspendedFile
from crane_sim.trajectories.inputs import Constant


class Initial(Group):
    """Joint coordinates at t = 0, in joint order."""

    q: tuple[Angle, Real, Positive, Tilt, Tilt]  # rad, slew, trolley [m], rope [m], swing_tangential, swing_radial
    v: tuple[Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0)  # rad/s, of the same joints; of trolley and
    # rope [m/s]
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class TowerReference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Angle, Real, Positive] | None = None  # rad, where slew, trolley [m] and rope or falls [m]
    # should end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    slew: Channel = Constant(0.0)  # N m, torque about the vertical
    trolley: Channel = Constant(0.0)  # N, force along the jib, outwards
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class TowerGroups(SupportedFile):
    """The groups of a tower crane's support."""

    support_joints: ClassVar[SupportJoints] = (("slew", "rad", "N m"), ("trolley", "m", "N"))
    slew: Annotated[Any, tagged_union_validator("drive", {"force": Slew, "locked": LockedSlew})]  # jib and counter-jib
    trolley: JibTrolley  # on the jib
    flexibility: JibFlexibility | None = None  # how the jib bends; left out: it is rigid
    reference: TowerReference | None = None  # where the crane should go

    @property
    def support_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the support's joints that have some."""
        return limits_of(
            ("slew", "slew.limits", getattr(self.slew, "limits", None)),
            ("trolley", "trolley.limits", self.trolley.limits),
        )

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        own = {f"slew.{key}": getattr(self.slew, key, None) for key in ("jib_windage", "counter_jib_windage")}
        return super().windages | own

    def _elevation_and_length(self, q: Any) -> tuple[float, float]:
        """Return (elevation [rad], length [m]) of the structure that carries the rope, at joint positions q."""
        return 0.0, q[1]

    def _tip_radius_and_height(self, q: Any, bend: float) -> tuple[float, float]:
        """Return (radius, height) [m] of the trolley at joint positions q, the jib bent upwards by `bend` [rad]."""
        return q[1] * cos(bend), q[1] * sin(bend)

    @property
    def _swaying(self) -> SwayingTower | None:
        """The support on a mast that bends, None of other cranes."""
        tower = self.support() if self.flexibility is not None and self.flexibility.mast is not None else None
        return tower if isinstance(tower, SwayingTower) else None

    def _deflections(self, q: Any) -> tuple[float, ...]:
        """Return the angles [rad] of the structure's modes with the first payload hanging at joint positions q."""
        if (tower := self._swaying) is None:
            return super()._deflections(q)
        return angles_at_rest(tower, q[0], q[1], getattr(self, "gravity", 0.0), self._suspended_mass)

    def tip(self, q: Any) -> Tip:
        """Return where the support's frame is at joint positions q, the structure bent by the first payload."""
        if (tower := self._swaying) is None:
            return super().tip(q)
        return Tip(trolley_place(tower, q[0], q[1], self._deflections(q)), q[0])

    def joint_mobility(self) -> JointMobility:
        """Return the mobility of slew, trolley and what bends at t = 0; of a jib that bends, the jib's alone."""
        if (tower := self._swaying) is not None:
            return self._mobility_on_mast(tower)
        radius, mass, bends = self._initial.q[1], self.trolley.mass, self.flexibility is not None
        jib = getattr(self.slew, "inertia", inf) if self.flexibility is None else self.flexibility.jib.about_axis
        turning = 1.0 / (jib + mass * radius * radius)
        jacobian_t = np.array([[0.0, radius, 0.0, 1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, bends * radius, 0.0]])
        return JointMobility(jacobian_t, np.diag([turning, 1.0 / mass, turning]))

    def _mobility_on_mast(self, tower: SwayingTower) -> JointMobility:
        """Return the mobility of slew and trolley, and of the mast along and across the jib, each as if alone."""
        height, radius, trolley = tower.height, self._initial.q[1], tower.support.trolley.mass
        moved = height**2 * (sum(tower.masses) + trolley)
        jacobian_t = [[0, radius, 0, 1], [1, 0, 0, 0], [height, 0, -radius, 0], [0, height, 0, 0]]
        turning = 1.0 / (self.slew.inertia + trolley * radius**2)
        inverse_inertia = np.diag([turning, 1.0 / trolley, 1.0 / tilt_inertia(tower, radius), 1.0 / moved])
        return JointMobility(np.array(jacobian_t, dtype=float), inverse_inertia)

    def support(self) -> TowerCrane | FlexibleSupport | SwayingTower:
        """Return the parameters of the support.

        Raises:
            SceneError: a locked slew turns, or should, or nothing can bend.
        """
        start = self._initial
        if isinstance(self.slew, LockedSlew):
            goal = self.reference.q[0] if self.reference is not None and self.reference.q is not None else None
            if start.v[0] != 0.0:
                raise SceneError(f"initial.v[0] = {start.v[0]}: slew.drive: locked does not turn")
            if goal is not None and goal != start.q[0]:
                raise SceneError(f"reference.q[0] = {goal}: slew.drive: locked stays at initial.q[0] = {start.q[0]}")
        return flexible_jib(TowerCrane(self.slew, self.trolley), self.flexibility, start.q)


class TowerFile(TowerGroups, SuspendedFile):
    """A scene with a tower crane: a jib that slews, a trolley on the jib, a payload on rope and links."""

    crane: Literal["tower"]  # the kind of crane
    initial: Initial  # the state at t = 0
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law
