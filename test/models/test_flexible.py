"""Structures that bend: virtual work of point masses, the balance of energy, frequencies and the rigid crane."""

from math import hypot
from typing import Any

import numpy as np
import pytest
from point_masses import Extras, Point, accelerations, mp, mpf, mpmath, on_base, plus, ring_points, rod_points, rotate

from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.energy_meter import Meter
from crane_sim.models.loads import PointLoad
from crane_sim.models.supports.flexible import Compliance, FlexibleSupport
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.telescopic_boom import BaseSection, Superstructure, TelescopedSection, TelescopicBoom
from crane_sim.models.supports.tower_crane import JibTrolley, Slew, TowerCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.wind_load import BoomWindage, JibWindage
from crane_sim.trajectories.base_motion import AXES, Base
from crane_sim.trajectories.wind import Wind

SEA = {
    "surge": {"amplitude": 0.5, "frequency": 0.7},
    "heave": {"amplitude": 0.8, "frequency": 1.1, "phase": 0.4},
    "roll": {"amplitude": 0.2, "frequency": 0.9, "phase": 1.0},
    "pitch": {"amplitude": 0.15, "frequency": 1.3},
    "yaw": {"amplitude": 0.1, "frequency": 0.5, "phase": 2.0},
}
WIND, NO_GUSTS = (9.0, -4.0), (None, None, None)
LENGTHS, MASSES = (2.5, 1.2), (2.0, 10.0)
STIFFNESS, REST, DAMPING, INERTIA, JIB, FOOT = (
    (700.0, 900.0),
    (-0.01, 0.05),
    (30.0, 20.0),
    150.0,
    (4.0, 3.0, 12.0),
    (0.5, 1.2),
)
OWN = {"tower": (0.4, 6.0), "mobile": (0.4, 0.6, 7.0)}
BENT = (0.08, -0.11)  # rad
AXES_THAT_BEND = ((True, True), (True, False), (False, True))


def compliances(which: tuple[bool, bool]) -> tuple[Compliance | None, ...]:
    """Return the compliances of those axes that have one."""
    rows = zip(which, STIFFNESS, REST, DAMPING, strict=True)
    return tuple(Compliance(*row) if bends else None for bends, *row in rows)


def support(name: str, which: tuple[bool, bool]) -> FlexibleSupport:
    """Return a support with wind on the jib, or the boom, that bends about these axes."""
    if name == "tower":
        rigid: Any = TowerCrane(Slew(INERTIA), JibTrolley(8.0))
        mass, centre, inertia = JIB
        behind = -(INERTIA - inertia - mass * centre**2) / mass / centre
        inner = TelescopicBoom(
            Superstructure(0.0), BaseSection(-mass * centre / behind, behind, 0.0), TelescopedSection(0.0, 0.0, 0.0)
        )
        section: Any = BaseSection(mass, centre, inertia)._replace(windage=JibWindage(3.0, 1.3, 3.5))
        outer = TelescopicBoom(Superstructure(0.0), section, TelescopedSection(8.0, 0.0, 0.0))
    else:
        first, second = BaseSection(5.0, 2.0, 4.0), TelescopedSection(3.0, 1.5, 2.0)
        rigid = TelescopicBoom(Superstructure(30.0, FOOT), first, second)
        inner = TelescopicBoom(Superstructure(30.0, FOOT), first, TelescopedSection(0.0, 0.0, 0.0))
        bare = BaseSection(0.0, 0.0, 0.0, windage=BoomWindage(3.0 / 7.0, 1.3))
        outer = TelescopicBoom(Superstructure(0.0, FOOT), bare, second)
    return FlexibleSupport(rigid, inner, outer, *compliances(which))


def base() -> Base:
    """Return the base that moves as SEA says."""
    keys = ("amplitude", "frequency", "phase")
    terms = np.array([[SEA.get(axis, {}).get(key, 0.0) for key in keys] for axis in AXES])
    return Base(np.zeros(6), *(np.ascontiguousarray(column[:, None]) for column in terms.T))


def along(yaw: Any, elevation: Any, distance: Any) -> Point:
    """Return the point at a distance from the root along a boom."""
    return rotate(2, yaw, (distance * mpmath.cos(elevation), mpf(0), distance * mpmath.sin(elevation)))


def root(name: str, yaw: Any) -> Point:
    """Return the place where a boom of this yaw begins."""
    return rotate(2, yaw, (mpf(FOOT[0]), mpf(0), mpf(FOOT[1]))) if name == "mobile" else (mpf(0),) * 3


class Reference:
    """The crane as point masses; coordinates: the support's own, the two angles, rope, directions of both links."""

    def __init__(self, name: str, which: tuple[bool, bool]) -> None:
        """Take its name and the axes about which it bends."""
        self.name, self.which, self.own = name, which, len(OWN[name])

    def axis(self, q: Any) -> tuple[Any, Any, Any]:
        """Return (yaw, elevation, length) of the outer boom."""
        twist, bend = self.angles(q)
        return q[0] + twist, (q[1] if self.own == 3 else 0) + bend, q[self.own - 1]

    def angles(self, q: Any) -> list[Any]:
        """Return both angles, those of rigid axes 0."""
        bent = iter(q[self.own : self.own + sum(self.which)])
        return [next(bent) if bends else mpf(0) for bends in self.which]

    def nodes(self, q: Any) -> tuple[Point, Point, Point]:
        """Return tip, hook and load."""
        yaw, elevation, length = self.axis(q)
        at, rest = plus(root(self.name, yaw), along(yaw, elevation, length)), q[self.own + sum(self.which) :]
        out = [at]
        for k, span in enumerate((rest[0], mpf(LENGTHS[1]))):
            out.append(plus(out[-1], [span * a for a in direction(rest[1 + 2 * k : 3 + 2 * k])]))
        return out[0], out[1], out[2]

    def places(self, q: Any) -> list[tuple[Any, Point]]:
        """Return all points relative to the base."""
        (yaw, elevation, length), foot, slew = self.axis(q), root(self.name, q[0]), q[0]
        outer_foot, points = root(self.name, yaw), []
        if self.name == "tower":
            mass, centre, inertia = JIB
            points += [(m, along(yaw, elevation, s)) for m, s in rod_points(mass, inertia, mpf(centre))]
            behind = -(mpf(INERTIA) - inertia - mass * centre**2) / mass / centre
            points += [(-mass * centre / behind, along(slew, 0, behind)), (mpf(8), along(yaw, elevation, length))]
        else:
            points += ring_points(30.0, slew)
            points += [(m, plus(foot, along(slew, q[1], s))) for m, s in rod_points(5.0, 4.0, mpf(2))]
            rod = rod_points(3.0, 2.0, length - mpf("1.5"))
            points += [(m, plus(outer_foot, along(yaw, elevation, s))) for m, s in rod]
        _, hook, load = self.nodes(q)
        return [*points, (mpf(MASSES[0]), hook), (mpf(MASSES[1]), load)]

    def joints(self, q: Any) -> list[Any]:
        """Return the crane's joint coordinates."""
        at = self.own + sum(self.which)
        x, y, z = rotate(2, -self.axis(q)[0], direction(q[at + 1 : at + 3]))
        swing = [mpmath.atan2(y, -z), mpmath.asin(x)]
        return [*q[: self.own], q[at], *swing, *direction(q[at + 3 : at + 5]), *q[self.own : at]]

    def pressed(self, q: Any) -> Point:
        """Return where the wind presses."""
        yaw, elevation, length = self.axis(q)
        reach = mpf("3.5") if self.name == "tower" else length / 2
        return plus(root(self.name, yaw), along(yaw, elevation, reach))

    def springs(self, q: Any) -> Any:
        """Return the energy of the springs."""
        return sum(mpf(k) / 2 * (a - mpf(r)) ** 2 for k, r, a in zip(STIFFNESS, REST, self.angles(q), strict=True))


def direction(angles: Any) -> Point:
    """Return the unit vector with azimuth and inclination from the downward vertical."""
    s = mpmath.sin(angles[1])
    return s * mpmath.cos(angles[0]), s * mpmath.sin(angles[0]), -mpmath.cos(angles[1])


def mapped(reference: Reference, q: Any, v: Any, a: Any) -> Any:
    """Return the crane's joint coordinates with their first and second derivatives."""
    with mp.workdps(60):
        h, (q, v, a) = mpf(10) ** -18, ([mpf(float(x)) for x in row] for row in (q, v, a))
        low, middle, high = (
            reference.joints([x + s * y + s * s * z / 2 for x, y, z in zip(q, v, a, strict=True)]) for s in (-h, 0, h)
        )
        first = [(x - y) / (2 * h) for x, y in zip(high, low, strict=True)]
        second = [(x - 2 * y + z) / h**2 for x, y, z in zip(high, middle, low, strict=True)]
        return tuple(np.array([float(x) for x in row]) for row in (middle, first, second))


def crane(name: str, which: tuple[bool, bool], sea: bool) -> SuspendedCrane:
    """Return the crane: at sea it stands in the wind, on a moving base."""
    cable = Chain(np.array(MASSES), np.array(LENGTHS))
    plain = SuspendedCrane(support(name, which), cable, PointLoad(MASSES[-1]), ForceHoist(1.5), energy_meter=Meter())
    if not sea:
        return plain
    steady = Wind(hypot(*WIND), 10.0, None, (WIND[0] / hypot(*WIND), WIND[1] / hypot(*WIND)), 0.0, 1.2, NO_GUSTS)
    return plain._replace(base=base(), wind=steady)


def posture(name: str, which: tuple[bool, bool]) -> tuple[Any, Any]:
    """Return coordinates of the reference and their rates."""
    bent = [a for a, bends in zip(BENT, which, strict=True) if bends]
    q = np.array([*OWN[name], *bent, LENGTHS[0], 0.7, 0.4, -1.1, 0.5])
    return q, np.random.default_rng(5).uniform(-0.6, 0.6, len(q))


def wind_of(reference: Reference, t: float, q: Any) -> dict[str, Any]:
    """Return the wind on the jib or boom as entries of Extras: 3 m² with the coefficient 1.3, across it."""
    with mp.workdps(60):
        yaw, elevation, _ = reference.axis([mpf(float(a)) for a in q])
        ends = [on_base(SEA, mpf(t), along(yaw, elevation, s)) for s in (0, 1)]
        axis = [b - a for a, b in zip(*ends, strict=True)]

    def push(velocity: Any) -> Any:
        flow = [mpf(w) - v for w, v in zip((*WIND, 0.0), velocity, strict=True)]
        part = mpmath.fdot(flow, axis)
        across = [a - part * b for a, b in zip(flow, axis, strict=True)]
        return [mpf(1.2) / 2 * mpf(1.3) * 3 * mpmath.norm(across) * a for a in across]

    return {"pushed": lambda t, q: on_base(SEA, t, reference.pressed(q)), "push": push}


@pytest.mark.interpreted
@pytest.mark.parametrize("sea", [False, True], ids=["at rest", "at sea"])
@pytest.mark.parametrize("which", AXES_THAT_BEND, ids=["both", "lateral", "vertical"])
@pytest.mark.parametrize("name", OWN)
def test_accelerations_are_those_of_point_masses(name: str, which: tuple[bool, bool], sea: bool) -> None:
    """All accelerations agree with virtual work of point masses and springs, on a moving base in the wind too."""
    reference, t, (q, v) = Reference(name, which), 1.3, posture(name, which)
    own, at = reference.own, reference.own + sum(which)
    drives, added, efforts = np.random.default_rng(7).uniform(-20.0, 20.0, own), np.zeros(len(q)), np.zeros(len(q))
    added[at], efforts[:own], efforts[at] = 1.5, drives, -120.0
    damping = [c for c, bends in zip(DAMPING, which, strict=True) if bends]
    efforts[own:at] = -np.array(damping) * v[own:at]
    extras = Extras(added, lambda t, q: reference.springs(q), **(wind_of(reference, t, q) if sea else {}))

    def places(t: Any, q: Any) -> list[tuple[Any, Point]]:
        return [(m, on_base(SEA, t, r)) for m, r in reference.places(q)] if sea else reference.places(q)

    joints, rates, second = mapped(reference, q, v, accelerations(places, t, q, v, efforts, extras))
    p = crane(name, which, sea)
    state = system.state(p, t, joints, rates)
    read = system.joints(p, state)
    np.testing.assert_allclose(read[0], joints, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(read[1], rates, rtol=0.0, atol=1e-14)  # rounding of rates below 1
    got = system.acceleration(p, t, state, (*map(float, drives), -120.0))
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-12 * max(1.0, abs(second).max()))  # rounding, 50 terms
