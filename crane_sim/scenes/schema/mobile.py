"""The form of a scene file with a mobile crane, and the model that it describes."""

from math import sin
from typing import ClassVar, Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, Positive, Real, Tilt
from crane_sim.models.supports.flexible import FlexibleSupport
from crane_sim.models.supports.telescopic_boom import BaseSection, Superstructure, TelescopedSection, TelescopicBoom
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.backlash import SupportJoints
from crane_sim.scenes.schema.flexibility import BoomFlexibility, flexible_boom
from crane_sim.scenes.schema.groups import Channel, Group
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.reference import ReferenceGroup
from crane_sim.scenes.schema.rigging import RiggingStart
from crane_sim.scenes.schema.suspended import SuspendedFile
from crane_sim.trajectories.inputs import Constant


class Initial(Group):
    """Joint coordinates at t = 0, in joint order; the boom's is its elevation from the horizontal."""

    q: tuple[Angle, Angle, Positive, Positive, Tilt, Tilt]  # rad, slew, boom, telescope [m], rope [m],
    # swing_tangential, swing_radial
    v: tuple[Real, Real, Real, Real, Real, Real] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # rad/s, of the same joints; of
    # telescope and rope [m/s]
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class Reference(ReferenceGroup):
    """Target of the actuated joints."""

    q: tuple[Angle, Angle, Positive, Positive] | None = None  # rad, where slew, boom, telescope [m] and rope [m] end


class InputGroup(Group):
    """Open-loop inputs of the actuated joints; those left out are zero."""

    slew: Channel = Constant(0.0)  # N m, torque about the vertical
    boom: Channel = Constant(0.0)  # N m, torque on the elevation
    telescope: Channel = Constant(0.0)  # N, force along the boom, outwards
    rope: Channel = Constant(0.0)  # effort's unit, as `rope.drive` says


class MobileFile(SuspendedFile):
    """A scene with a mobile crane: a boom that slews, luffs and telescopes, a payload on rope and links."""

    support_joints: ClassVar[SupportJoints] = (("slew", "rad", "N m"), ("boom", "rad", "N m"), ("telescope", "m", "N"))
    crane: Literal["mobile"]  # which form the file has
    superstructure: Superstructure  # what slews besides the boom
    boom: BaseSection  # the boom's base section
    telescope: TelescopedSection  # the section that is telescoped out
    flexibility: BoomFlexibility | None = None  # how the boom bends; left out: it is rigid
    initial: Initial  # the state at t = 0
    reference: Reference | None = None  # where the crane should go
    inputs: InputGroup | None = None  # efforts of the actuated joints where there is no law

    @property
    def tip_height(self) -> float:
        """Height of the boom's tip above the slewing axis' origin at t = 0 [m]."""
        return self.superstructure.foot[1] + self.initial.q[2] * sin(self.initial.q[1])

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        return limits_of(
            ("slew", "superstructure.limits", self.superstructure.limits),
            ("boom", "boom.limits", self.boom.limits),
            ("telescope", "telescope.limits", self.telescope.limits),
            ("rope", "rope.limits", self.rope.limits),
        )

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        return super().windages | {"boom.windage": self.boom.windage}

    @property
    def _place(self) -> tuple[float, float]:
        """(elevation [rad], length [m]) of the structure that carries the rope, at t = 0."""
        return self.initial.q[1], self.initial.q[2]

    def support(self) -> TelescopicBoom | FlexibleSupport:
        """Return the parameters of the support.

        Raises:
            SceneError: the telescoped section's centre of mass lies behind the foot pin, or nothing can bend.
        """
        shortest = min(self.initial.q[2], *(self.telescope.limits or (self.initial.q[2],))[:1])
        if shortest < self.telescope.centre:
            raise SceneError(
                f"telescope.centre = {self.telescope.centre}: exceeds the shortest boom length, {shortest:g} m at "
                "initial.q[2] or telescope.limits[0]: the section's centre of mass would lie behind the foot pin"
            )
        rigid = TelescopicBoom(self.superstructure, self.boom, self.telescope)
        return flexible_boom(rigid, self.flexibility, self.initial.q)
