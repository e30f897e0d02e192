"""Tower crane (hammerhead): a jib that slews about the tower, and a trolley on the jib.

In the slewing frame (e_r, e_t, e_z), with slew angle α, slew inertia J of jib and counter-jib, and
a trolley of mass m at the radius r, under the efforts τ, F and the force f of the cable on the
trolley:

    (J + m r²) α'' + 2 m r r' α' = τ + r f_t,    m (r'' - r α'²) = F + f_r.

The jib's underside, where the cable begins, is at height 0. With a locked slew this is the trolley
of a bridge crane.
"""

from typing import Any, NamedTuple

from crane_sim.files.types import AngleRange, Positive, Range
from crane_sim.models.supports.support import Mechanism, Pressed
from crane_sim.models.wind_load import JibWindage
from crane_sim.multibody.tree import Body, Joint, Point, Tree, X, Z
from crane_sim.multibody.vectors import diagonal


class Slew(NamedTuple):
    """The slewing part: tower head, jib and counter-jib with its ballast."""

    inertia: Positive  # kg m², about the tower's axis, without trolley and payload
    limits: AngleRange | None = None  # rad, of the slew angle; a run ends where one is reached
    jib_windage: JibWindage | None = None  # of the jib: area and drag in the `wind`
    counter_jib_windage: JibWindage | None = None  # of the counter-jib


class LockedSlew(NamedTuple):
    """A slewing part that is braked."""


class JibTrolley(NamedTuple):
    """The trolley on the jib."""

    mass: Positive  # kg, that moves with it
    limits: Range | None = None  # m, of its radius; a run ends where one is reached


class TowerCrane(NamedTuple):
    """Parameters of the support."""

    slew: Slew | LockedSlew
    trolley: JibTrolley

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return (("slew", "slew.limits"), ("trolley", "trolley.limits"))[i]

    def mechanism(self) -> Mechanism:
        """Return the joints and bodies: the slew, and the trolley along the jib."""
        slew, limits = self.slew, self.trolley.limits
        trolley = Joint(X, ((1, 1),), slides=True, parent=0, bodies=(Body(self.trolley.mass),))
        if isinstance(slew, LockedSlew):
            locked = Tree((Joint(Z, ((0, 1),)), trolley), Point(1))
            outline = (Point(-1),)
            return Mechanism(
                locked, (None, limits), actuated=(0, 1), outline=outline, prescribed=(True, False)
            )
        turning, windages = (
            Body(0, inertia=diagonal(0, 0, slew.inertia)),
            (slew.jib_windage, slew.counter_jib_windage),
        )
        return Mechanism(
            Tree((Joint(Z, ((0, 1),), bodies=(turning,)), trolley), Point(1)),
            limits=(slew.limits, limits),
            actuated=(0, 1),
            outline=(Point(-1),),
            pressed=tuple(
                Pressed(0, windage, windage.centre) for windage in windages if windage is not None
            ),
        )

    def prescribe(
        self, t: Any, efforts: tuple[Any, ...], q: tuple[Any, ...], v: tuple[Any, ...]
    ) -> tuple[Any, ...]:
        """Return the accelerations (2,) of a locked slew: none."""
        return (0, 0)
