"""The schema of a scene file with a mobile crane, and the model that it describes."""

from math import cos, sin
from typing import Any, ClassVar, Literal

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, Positive, Real, Tilt
from crane_sim.models.supports.flexible import FlexibleSupport
from crane_sim.models.supports.telescopic_boom import BaseSection, Superstructure, TelescopedSection, TelescopicBoom
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.backlash import SupportJoints
from crane_sim.scenes.schema.flexibility import BoomFlexibility, flexible_boom, outer_inertias
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.rigging import RiggingStart
from crane_sim.scenes.schema.supported import JointMobility, SupportedFile
from crane_sim.scenes.schema.suspended import SuspendedFile
from crane_sim.trajectories.inputs import Constant


class Initial(Group):
    """Joint coordinates at t = 0, in joint order; the boom's is its elevation from the horizontal."""

    q: tuple[Angle, Angle, Positive, Positive, Tilt, Tilt]  # rad, slew, boom, telescope [m], rope [m],
    # swing_tangential, swing_radial
    v: tuple[Real, Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # rad/s, of the same joints; of
    # telescope and rope [m/s]
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class MobileReference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Angle, Angle, Positive, Positive] | None = None  # rad, where slew, boom, telescope [m] and rope or
    # falls [m] should end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    slew: Channel = Constant(0.0)  # N m, torque about the vertical
    boom: Channel = Constant(0.0)  # N m, torque on the elevation
    telescope: Channel = Constant(0.0)  # N, force along the boom, outwards
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class MobileGroups(SupportedFile):
    """The groups of a mobile crane's support."""

    support_joints: ClassVar[SupportJoints] = (("slew", "rad", "N m"), ("boom", "rad", "N m"), ("telescope", "m", "N"))
    superstructure: Superstructure  # what slews besides the boom
    boom: BaseSection  # the boom's base section
    telescope: TelescopedSection  # the section that is telescoped out
    flexibility: BoomFlexibility | None = None  # how the boom bends; left out: it is rigid
    reference: MobileReference | None = None  # where the crane should go

    @property
    def support_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the support's joints that have some."""
        return limits_of(
            ("slew", "superstructure.limits", self.superstructure.limits),
            ("boom", "boom.limits", self.boom.limits),
            ("telescope", "telescope.limits", self.telescope.limits),
        )

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        return super().windages | {"boom.windage": self.boom.windage}

    def _elevation_and_length(self, q: Any) -> tuple[float, float]:
        """Return (elevation [rad], length [m]) of the structure that carries the rope, at joint positions q."""
        return q[1], q[2]

    def _tip_radius_and_height(self, q: Any, bend: float) -> tuple[float, float]:
        """Return (radius, height) [m] of the boom's tip at joint positions q, bent upwards by `bend` [rad]."""
        ahead, above = self.superstructure.foot
        return ahead + q[2] * cos(q[1] + bend), above + q[2] * sin(q[1] + bend)

    def joint_mobility(self) -> JointMobility:
        """Return the mobility of slew, boom and telescope at t = 0; of a boom that bends, its outer section's alone."""
        _, elevation, length, *_ = self._initial.q
        s, c, radius = sin(elevation), cos(elevation), self._tip_radius_and_height(self._initial.q, 0.0)[0]
        first = self.boom if self.flexibility is None else BaseSection(0.0, 0.0, 0.0)
        moving = TelescopicBoom(self.superstructure, first, self.telescope)
        about_z, about_root = outer_inertias(moving, elevation, length)
        about_z += self.superstructure.inertia if self.flexibility is None else 0.0
        jacobian_t = np.array([[0.0, radius, 0.0, 1.0], [-length * s, 0.0, length * c, 0.0], [c, 0.0, s, 0.0]])
        return JointMobility(jacobian_t, np.diag([1.0 / about_z, 1.0 / about_root, 1.0 / self.telescope.mass]))

    def support(self) -> TelescopicBoom | FlexibleSupport:
        """Return the parameters of the support.

        Raises:
            SceneError: the telescoped section's centre of mass lies behind the foot pin, or nothing can bend.
        """
        self._check_shortest()
        rigid = TelescopicBoom(self.superstructure, self.boom, self.telescope)
        return flexible_boom(rigid, self.flexibility, self._initial.q)

    def _check_shortest(self) -> None:
        """Raise SceneError where the telescoped section does not fit the shortest boom."""
        start = self._initial.q[2]
        shortest = min(start, *(self.telescope.limits or (start,))[:1])
        if shortest < self.telescope.centre:
            raise SceneError(
                f"telescope.centre = {self.telescope.centre}: exceeds the shortest boom length, {shortest:g} m at "
                "initial.q[2] or telescope.limits[0]: the section's centre of mass would lie behind the foot pin"
            )
        if self.flexibility is not None and self.telescope.inertia == 0.0 and shortest == self.telescope.centre:
            raise SceneError(
                "telescope.inertia = 0: must be greater than 0 below `flexibility` where telescope.centre is the "
                f"shortest boom length, {shortest:g} m: what bends would have no inertia about the foot pin"
            )


class MobileFile(MobileGroups, SuspendedFile):
    """A scene with a mobile crane: a boom that slews, luffs and telescopes, a payload on rope and links."""

    crane: Literal["mobile"]  # the kind of crane
    initial: Initial  # the state at t = 0
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law
