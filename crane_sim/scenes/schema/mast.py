"""A tower crane on a mast that bends: its support, and its angles and trolley position at rest."""

from math import cos, hypot, sin, sqrt
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.models.supports.tower_crane import TowerCrane

LARGEST = 0.5  # rad, of an angle at rest: a mode of bending is far from linear there
ROUNDING = 1e-16  # rad, of an angle
HALVES = 1.0, -1.0  # of the jib, a thin rod, as two points


def swaying_tower(
    rigid: TowerCrane, flexibility: Any, ballast: tuple[float, float], radius: float
) -> SwayingTower:
    """Return the support.

    Args:
        rigid: the support without bending.
        flexibility: the group, which has a mast.
        ballast: mass [kg] and position [m] of the point that balances the jib.
        radius: of the trolley at t = 0 [m].

    Raises:
        SceneError: what stands on the mast bends as well, or the wind presses on it.
    """
    jib, mast, slew = flexibility.jib, flexibility.mast, rigid.slew
    for key in ("lateral", "vertical"):
        if getattr(flexibility, key) is not None:
            raise SceneError(
                f"flexibility.mast: stands beside flexibility.{key}, of a jib on an upright mast; "
                "leave out one of both"
            )
    for key in ("jib_windage", "counter_jib_windage"):
        if getattr(slew, key) is not None:
            raise SceneError(
                f"flexibility.mast: stands beside slew.{key}, of a jib on an upright mast; leave "
                "out one of both"
            )
    half = sqrt(jib.inertia / jib.mass)
    masses = (*(0.5 * jib.mass for _ in HALVES), ballast[0], mast.mass)
    places = (*(jib.centre + side * half for side in HALVES), ballast[1], 0.0)
    tower = SwayingTower(rigid, masses, places, mast.height, mast.stiffness, 0.0)
    damping = 2.0 * mast.damping_ratio * sqrt(mast.stiffness * tilt_inertia(tower, radius))
    return tower._replace(damping=damping)


def compute_moments(
    tower: SwayingTower, radius: float, hung: float = 0.0
) -> tuple[float, float, float]:
    """Return Σ m [kg], Σ m x [kg m] and Σ m x² [kg m²] with the trolley at a radius [m].

    A mass [kg] hangs below the trolley.
    """
    masses, places = (*tower.masses, tower.support.trolley.mass + hung), (*tower.places, radius)
    rows = list(zip(masses, places, strict=True))
    return sum(masses), sum(m * x for m, x in rows), sum(m * x * x for m, x in rows)


def tilt_inertia(tower: SwayingTower, radius: float) -> float:
    """Return the inertia [kg m²] of what sways about an axis across the jib.

    The trolley is at a radius [m].
    """
    rows = zip((*tower.masses, tower.support.trolley.mass), (*tower.places, radius), strict=True)
    return sum(m * (x * x + tower.height**2) for m, x in rows)


def angles_at_rest(
    tower: SwayingTower, slew: float, radius: float, gravity: float, hung: float
) -> tuple[float, float]:
    """Return the angles [rad] where springs balance all weights; hung: all hanging mass [kg].

    Raises:
        SceneError: the mast bends too far, or buckles under less than 1.1 times the weights.
    """
    total, moment, _ = compute_moments(tower, radius, hung)
    x, y, z = moment * cos(slew), moment * sin(slew), total * tower.height
    a, b, step, share = 0.0, 0.0, 1.0, gravity / tower.stiffness
    for _ in range(
        200
    ):  # k a = -∂V/∂a of V = g (y sin a + (z cos b - x sin b) cos a), and alike for b
        up = z * cos(b) - x * sin(b)
        new = share * (up * sin(a) - y * cos(a)), share * (z * sin(b) + x * cos(b)) * cos(a)
        step, (a, b) = hypot(new[0] - a, new[1] - b), new
        if step <= ROUNDING or max(abs(a), abs(b)) > LARGEST:
            break
    if not (max(abs(a), abs(b)) <= LARGEST and step <= 1e-12):
        bends = max(abs(a), abs(b)) > LARGEST
        what = (
            f"bends by more than {LARGEST:g} rad at rest"
            if bends
            else "is near buckling under the weights above it"
        )
        raise SceneError(f"flexibility.mast.stiffness = {tower.stiffness:g}: {what}; take more")
    return a, b
