"""A tower crane whose mast bends: virtual work, energy, a closed form and the rigid crane."""

from math import sqrt
from typing import Any

import numpy as np
import pytest
from point_masses import (
    Extras,
    Point,
    accelerations,
    mp,
    mpf,
    mpmath,
    on_base,
    plus,
    rod_points,
    rotate,
)

from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.energy_meter import Meter
from crane_sim.models.loads import PointLoad
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.support import Support
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.models.supports.tower_crane import JibTrolley, Slew, TowerCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.trajectories.base_motion import AXES, Base

SEA = {
    "surge": {"amplitude": 0.5, "frequency": 0.7},
    "heave": {"amplitude": 0.8, "frequency": 1.1, "phase": 0.4},
    "roll": {"amplitude": 0.2, "frequency": 0.9, "phase": 1.0},
    "pitch": {"amplitude": 0.15, "frequency": 1.3},
    "yaw": {"amplitude": 0.1, "frequency": 0.5, "phase": 2.0},
}
LENGTHS, MASSES = (2.5, 1.2), (2.0, 10.0)
TROLLEY, HEIGHT, STIFFNESS, DAMPING = 8.0, 5.0, 4e3, 30.0
# mass, centre, inertia; mass and place of ballast; mast's head
JIB, BEHIND, HEAD = (4.0, 3.0, 12.0), (6.0, -2.0), 5.0
Q = np.array([0.4, 6.0, 0.07, -0.11, LENGTHS[0], 0.7, 0.4, -1.1, 0.5])
V = np.random.default_rng(5).uniform(-0.6, 0.6, len(Q))


def structure() -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Return masses [kg] of what slews and their places [m] along the jib."""
    mass, centre, inertia = JIB
    half = sqrt(inertia / mass)
    return (0.5 * mass, 0.5 * mass, BEHIND[0], HEAD), (centre + half, centre - half, BEHIND[1], 0.0)


def support(stiffness: float = STIFFNESS) -> SwayingTower:
    """Return the support."""
    masses, places = structure()
    inertia = sum(m * x * x for m, x in zip(masses, places, strict=True))
    return SwayingTower(
        TowerCrane(Slew(inertia), JibTrolley(TROLLEY)), masses, places, HEIGHT, stiffness, DAMPING
    )


def crane(sea: bool, stiffness: float = STIFFNESS) -> SuspendedCrane:
    """Return the crane, at sea on a moving base."""
    keys = ("amplitude", "frequency", "phase")
    terms = np.array([[SEA.get(axis, {}).get(key, 0.0) for key in keys] for axis in AXES])
    base = (
        Base(np.zeros(6), *(np.ascontiguousarray(part[:, None]) for part in terms.T))
        if sea
        else None
    )
    cable = Chain(np.array(MASSES), np.array(LENGTHS))
    load, winch = PointLoad(MASSES[-1]), ForceHoist(1.5)
    return SuspendedCrane(
        Support(support(stiffness)), cable, load, winch, energy_meter=Meter(), base=base
    )


def on_mast(q: Any, x: Any) -> Point:
    """Return the place of a mass at x on the jib, relative to the base."""
    at = rotate(0, q[2], rotate(1, q[3], rotate(2, q[0], (x, mpf(0), mpf(HEIGHT)))))
    return at[0], at[1], at[2] - HEIGHT


def direction(angles: Any) -> Point:
    """Return the unit vector with azimuth and inclination from the downward vertical."""
    s = mpmath.sin(angles[1])
    return s * mpmath.cos(angles[0]), s * mpmath.sin(angles[0]), -mpmath.cos(angles[1])


def places(q: Any) -> list[tuple[Any, Point]]:
    """Return all points relative to the base; coordinates: slew, trolley, a, b, rope, links.

    Links are given by their directions.
    """
    mass, centre, inertia = JIB
    points = [(m, on_mast(q, s)) for m, s in rod_points(mass, inertia, mpf(centre))]
    points += [(mpf(m), on_mast(q, mpf(x))) for m, x in (BEHIND, (HEAD, 0.0))]
    points.append((mpf(TROLLEY), on_mast(q, q[1])))
    at = points[-1][1]
    for k, (m, span) in enumerate(zip(MASSES, (q[4], mpf(LENGTHS[1])), strict=True)):
        at = plus(at, [span * a for a in direction(q[5 + 2 * k : 7 + 2 * k])])
        points.append((mpf(m), at))
    return points


def joints(q: Any) -> list[Any]:
    """Return the crane's joint coordinates."""
    x, y, z = rotate(2, -q[0], direction(q[5:7]))
    return [q[0], q[1], q[4], mpmath.atan2(y, -z), mpmath.asin(x), *direction(q[7:9]), q[2], q[3]]


def mapped(q: Any, v: Any, a: Any) -> Any:
    """Return the crane's joint coordinates with their first and second derivatives."""
    with mp.workdps(60):
        h, (q, v, a) = mpf(10) ** -18, ([mpf(float(x)) for x in row] for row in (q, v, a))
        low, middle, high = (
            joints([x + s * y + s * s * z / 2 for x, y, z in zip(q, v, a, strict=True)])
            for s in (-h, 0, h)
        )
        first = [(x - y) / (2 * h) for x, y in zip(high, low, strict=True)]
        second = [(x - 2 * y + z) / h**2 for x, y, z in zip(high, middle, low, strict=True)]
        return tuple(np.array([float(x) for x in row]) for row in (middle, first, second))


@pytest.mark.parametrize("sea", [False, True], ids=["at rest", "at sea"])
def test_accelerations_are_those_of_point_masses(sea: bool) -> None:
    """All accelerations agree with virtual work of point masses and springs, at sea too."""
    t, drives, winch = 1.3, np.random.default_rng(7).uniform(-20.0, 20.0, 2), -120.0
    added, efforts = (
        np.zeros(9),
        np.array([*drives, *(-DAMPING * V[2:4]), winch, 0.0, 0.0, 0.0, 0.0]),
    )
    added[4] = 1.5

    def at(t: Any, q: Any) -> list[tuple[Any, Point]]:
        return [(m, on_base(SEA, t, r)) for m, r in places(q)] if sea else places(q)

    extras = Extras(added, lambda t, q: mpf(STIFFNESS) / 2 * (q[2] ** 2 + q[3] ** 2))
    position, rates, second = mapped(Q, V, accelerations(at, t, Q, V, efforts, extras))
    p = crane(sea)
    x = system.state(p, t, position, rates)
    read = system.joints(p, x)
    np.testing.assert_allclose(read[0], position, rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(read[1], rates, rtol=0.0, atol=1e-14)  # rounding of rates below 1
    got = system.acceleration(p, t, x, (*map(float, drives), winch))
    # rounding, 50 terms
    np.testing.assert_allclose(got, second, rtol=0.0, atol=1e-12 * abs(second).max())


@pytest.mark.parametrize("sea", [False, True], ids=["at rest", "at sea"])
def test_the_meter_counts_all_power(sea: bool) -> None:
    """The energy of masses, springs and weight changes by the power of drives, dampers and base."""
    p, t = crane(sea), 1.3
    x, u = system.state(p, t, *mapped(Q, V, 0.0 * V)[:2]), (5.0, -7.0, -120.0)
    slope, h = system.rhs(p, t, x, u), 1e-6
    low, high = (
        system.kinetic(p, y) + system.potential(p, y) for y in (x - h * slope, x + h * slope)
    )
    assert slope[-1] == pytest.approx(system.power(p, t, x, u), rel=1e-15)
    assert (high - low) / (2 * h) == pytest.approx(
        slope[-1], abs=1e-8 * (abs(slope[-1]) + abs(low))
    )  # h², rounding / h


def test_a_mast_sways_at_the_frequency_of_a_closed_form() -> None:
    """Across the jib, held by a heavy slew, the mast sways at √(k / (M h²) - g / h).

    M is the mass of all on its head.

    The jib is symmetric and the load weighs nothing; the weight at height h lowers the frequency
    (Rayleigh).
    """
    masses, places_of = (50.0, 50.0, 30.0), (1e3, -1e3, 0.0)
    tower = SwayingTower(
        TowerCrane(Slew(1e8), JibTrolley(1e-9)), masses, places_of, HEIGHT, STIFFNESS, 0.0
    )
    light = Chain(np.array([1e-9]), np.array([1.0]))
    p = SuspendedCrane(Support(tower), light, PointLoad(1e-9))
    small = 1e-6
    # about the base's x axis: the head goes to -y
    q = np.array([0.0, 1.0, 1.0, 0.0, 0.0, small, 0.0])
    x = system.state(p, 0.0, q, np.zeros(7))
    got = -system.acceleration(p, 0.0, x, (0.0, 0.0))[5] / small
    # the light load, small²
    assert got == pytest.approx(STIFFNESS / (130.0 * HEIGHT**2) - 9.81 / HEIGHT, rel=1e-6)
