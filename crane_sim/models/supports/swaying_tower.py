"""Tower crane on a mast that bends: its top sways, with everything that slews on it.

The first bending modes of the mast are those of a rigid body on a universal joint with springs (a
pseudo-rigid-body model; Howell, Compliant Mechanisms, 2001, chapter 5), h below the jib. The mast
turns by the angle a about the base's x axis and then by b about its own y axis, and does not twist;
all that slews turns by α about the mast. Coordinates stand in the order slew, trolley, a, b.
"""

from typing import NamedTuple

from crane_sim.models.supports.support import Mechanism, Spring
from crane_sim.models.supports.tower_crane import TowerCrane
from crane_sim.multibody.tree import Body, Joint, Point, Tree, X, Y, Z


class SwayingTower(NamedTuple):
    """Parameters of the support."""

    support: TowerCrane  # the rigid support, whose slew inertia the masses have
    masses: tuple[float, ...]  # kg, of what slews and of the mast's head, without the trolley
    places: tuple[float, ...]  # m, of these masses along the jib, from the tower's axis
    height: float  # m, h
    stiffness: float  # N m/rad, of either angle
    damping: float  # N m s/rad

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return self.support.coordinate(i)

    def mechanism(self) -> Mechanism:
        """Return joints and bodies: the mast's two angles, slew, and trolley along the jib."""
        slewing = tuple(
            Body(mass, (place, 0, 0)) for mass, place in zip(self.masses, self.places, strict=True)
        )
        head, trolley = (0, 0, self.height), Body(self.support.trolley.mass)
        joints = (
            Joint(X, ((2, 1),), offset=(0, 0, -self.height)),
            Joint(Y, ((3, 1),), parent=0),
            Joint(Z, ((0, 1),), parent=1, offset=head, bodies=slewing),
            Joint(X, ((1, 1),), slides=True, parent=2, bodies=(trolley,)),
        )
        springs = [
            Spring(lever, self.stiffness, 0, self.damping) for lever in ((0, 0, 1, 0), (0, 0, 0, 1))
        ]
        return Mechanism(
            Tree(joints, Point(3)),
            limits=(*self.support.mechanism().limits, None, None),
            actuated=(0, 1),
            springs=tuple(springs),
            outline=(Point(2),),
            bending=2,
        )
