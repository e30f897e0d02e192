"""Flexible structures: a jib or boom that bends about its root, sideways and in its own plane.

Each first bending mode is one of a rigid body on a spring (a pseudo-rigid-body model; Howell,
Compliant Mechanisms, 2001, chapter 5). The inner body turns with the drives; the outer one carries
the cable and turns by further angles, ε about the vertical and δ about the root's transverse axis.
Both are a boom of `telescopic_boom`, (α, β, ℓ) and (α + ε, β + δ, ℓ). An axis without a compliance
has the sum of both. The structure's own weight bends it as well; where a spring is relaxed is its
camber.

Coordinates are those of the rigid support, then ε and δ, those it has. Friction and motors of
drives are on the inner body: a drive that is held leaves the outer one as free as it was.
"""

from typing import Any, NamedTuple

from crane_sim.models.supports.support import Mechanism, Pressed, Spring, Support
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.models.supports.telescopic_boom import TelescopicBoom
from crane_sim.models.supports.tower_crane import TowerCrane
from crane_sim.models.wind_load import BoomWindage
from crane_sim.multibody.tree import Joint, Point, Tree, X, Y, Z
from crane_sim.multibody.vectors import add


class Compliance(NamedTuple):
    """A spring and a damper between two bodies that turn about the same axis: a bending mode."""

    stiffness: float  # N m/rad, k
    rest: float  # rad, where the spring is relaxed
    damping: float  # N m s/rad, c


class FlexibleSupport(NamedTuple):
    """A support that bends; its coordinates are the rigid one's, then its ε and δ, if any."""

    support: Any  # the rigid support, whose coordinates are the drives'
    inner: TelescopicBoom  # what turns with the drives; its telescoped section has no mass
    outer: TelescopicBoom  # what bends: its base section and what moves along it; its
    # superstructure has no inertia
    lateral: Compliance | None  # about the vertical
    vertical: Compliance | None  # in the structure's own plane

    def coordinate(self, i: int) -> tuple[str, str]:
        """Return (name of coordinate i, the key of its limits)."""
        return self.support.coordinate(i)

    def mechanism(self) -> Mechanism:
        """Return joints and bodies: slew, inner boom, the bending joints, outer boom, its slide."""
        rigid = self.support.mechanism()
        n = len(rigid.limits)
        modes = [mode for mode in (self.lateral, self.vertical) if mode is not None]
        count = len(modes)
        is_level = isinstance(self.support, TowerCrane)
        elevation = () if is_level else ((1, 1),)
        inner_joints = self._inner_joints(elevation)
        joints = (*inner_joints, *self._outer_joints(elevation, n, len(inner_joints)))
        inner = len(inner_joints) - 1
        outer = len(joints) - 2
        sections = ((inner, self.inner.base_section), (outer, self.outer.base_section))
        return Mechanism(
            Tree(joints, Point(outer + 1)),
            limits=(*rigid.limits, *(None,) * count),
            actuated=tuple(range(n)),
            springs=tuple(mode_spring(mode, n + i, n + count) for i, mode in enumerate(modes)),
            yaw=(0,) if self.lateral is None else (0, n),
            outline=(Point(-1),) if is_level else (Point(-1), Point(outer)),
            pressed=tuple(
                pressed_part(joint, section.windage)
                for joint, section in sections
                if section.windage is not None
            ),
            bending=count,
        )

    def _inner_joints(self, elevation: tuple[tuple[int, int], ...]) -> tuple[Joint, ...]:
        """Return slew and elevation of what turns with the drives.

        The elevation of a tower crane is fixed to what slews.
        """
        body, pin, slewing = (
            self.inner.base_section.body(),
            self.inner.pin(),
            self.inner.slewing_body(),
        )
        if not elevation:
            return (
                Joint(Z, ((0, 1),), bodies=(slewing, body._replace(centre=add(pin, body.centre)))),
            )
        luff = Joint(Y, elevation, reverse=True, parent=0, offset=pin, bodies=(body,))
        return Joint(Z, ((0, 1),), bodies=(slewing,)), luff

    def _outer_joints(
        self, elevation: tuple[tuple[int, int], ...], n: int, first: int
    ) -> tuple[Joint, ...]:
        """Return the joint that bends sideways, if any, the outer boom and its slide.

        They are behind `first` joints of the inner body; the rigid support has n coordinates.
        """
        sideways = () if self.lateral is None else (Joint(Z, ((n, 1),), parent=0),)
        root = 0 if self.lateral is None else first
        if self.vertical is not None:
            elevation = (*elevation, (n + len(sideways), 1))
        outer = first + len(sideways)
        section = (self.outer.base_section.body(),)
        pin = self.outer.pin()
        boom = Joint(Y, elevation, reverse=True, parent=root, offset=pin, bodies=section)
        telescope = (self.outer.telescope.body(),)
        slide = Joint(X, ((n - 1, 1),), slides=True, parent=outer, bodies=telescope)
        return *sideways, boom, slide


def mode_spring(mode: Compliance, coordinate: int, n: int) -> Spring:
    """Return the spring of a bending mode on one of n coordinates."""
    lever = tuple(1 if i == coordinate else 0 for i in range(n))
    return Spring(lever, mode.stiffness, mode.rest, mode.damping)


def pressed_part(joint: int, windage: Any) -> Pressed:
    """Return a boom or jib on which the wind presses."""
    if isinstance(windage, BoomWindage):
        return Pressed(joint, windage, length=2)
    return Pressed(joint, windage, windage.centre)


def rigid_support(structure: Any) -> Any:
    """Return a structure as it is without bending."""
    return structure.support if isinstance(structure, FlexibleSupport | SwayingTower) else structure


def without_bending(support: Support) -> Support:
    """Return a support without bending and without play; friction and motors are kept."""
    n = len(support.structure.mechanism().limits) - support.structure.mechanism().bending
    motors, frictions = (
        support.motors and support.motors[:n],
        support.frictions and support.frictions[:n],
    )
    return Support(rigid_support(support.structure), motors, frictions)
