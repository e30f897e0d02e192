"""Supports declared as trees against the closed forms of their equations, at random states."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

from crane_sim.models.moving_base import BaseKinematics, turned_about_z
from crane_sim.models.supports import (
    forward_kinematics,
    support_acceleration,
    tip_mobility,
    with_base,
)
from crane_sim.models.supports.bridge import Bridge, DrivenAxis
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.models.supports.swaying_tower import SwayingTower, SwayState
from crane_sim.models.supports.telescopic_boom import BaseSection, Superstructure, TelescopedSection, TelescopicBoom
from crane_sim.models.supports.tower_crane import JibTrolley, Slew, TowerCrane
from crane_sim.multibody import supports
from crane_sim.multibody.supports import Bar
from crane_sim.multibody.tree import (
    BaseMotion,
    Tree,
    accelerations,
    compute_dynamics,
    efforts_of,
    point_mobility,
)

G = 9.81
pytestmark = pytest.mark.interpreted


class Case(NamedTuple):
    """One support twice, and how the closed form's coordinates q become the tree's: A q, so efforts A⁻ᵀ u."""

    closed: Any
    tree: Tree
    coordinates: Any  # A (n, n)
    state: Callable[[Any, Any], Any] = lambda q, v: (*q, *v)
    middle: tuple[float, ...] = (0.0, 0.0, 0.0)  # of the random positions


def eye(n: int) -> Any:
    """Return the coordinates of a tree that are those of the closed form."""
    return np.eye(n)


ROD = Rod(5.0, 2.0, 4.2), Rod(4.0, 3.0, 4.0)
BARS = Bar(2.0, 4.2, 2.5), Bar(3.0, 4.0, 2.0)
AXIAL = tuple(rod._replace(axial_inertia=0.3) for rod in ROD)
RELATIVE = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 1.0]])  # its jib is from the horizontal
MASSES, PLACES = (9.0e3, 4.0e3, 6.0e3), (-12.0, 25.0, 0.0)
SWAYING = SwayingTower(TowerCrane(Slew(1.0), JibTrolley(550.0)), MASSES, PLACES, 41.0, 0.0, 0.0)
CASES = {
    "knuckle": Case(Knuckle(*ROD, Tower(8.0)), supports.knuckle_boom(8.0, *BARS, (5.0, 4.0)), RELATIVE),
    "knuckle with axial inertia": Case(
        Knuckle(*AXIAL, Tower(8.0)),
        supports.knuckle_boom(8.0, *(bar._replace(axial_inertia=0.3) for bar in BARS), (5.0, 4.0)),
        RELATIVE,
    ),
    "mobile": Case(
        TelescopicBoom(Superstructure(30.0, (0.5, 1.2)), BaseSection(5.0, 2.0, 4.0), TelescopedSection(3.0, 1.5, 2.0)),
        supports.telescopic_boom(
            30.0, (0.5, 1.2), Bar(5.0, 4.0, 2.0, 0.0), Bar(3.0, 2.0, -1.5, 0.0)
        ),
        eye(3),
        middle=(0.0, 0.6, 7.0),
    ),
    "tower": Case(
        TowerCrane(Slew(900.0), JibTrolley(40.0)), supports.tower_crane(900.0, 40.0), eye(2), middle=(0.0, 12.0)
    ),
    "bridge": Case(
        Bridge(DrivenAxis(5.0), DrivenAxis(20.0)), supports.bridge(5.0, 20.0), np.array([[0.0, 1.0], [1.0, 0.0]]),
        middle=(0.0, 0.0),
    ),
    "swaying tower": Case(
        SWAYING,
        supports.swaying_tower(MASSES, PLACES, 41.0, 550.0),
        np.array([[0, 0, 1, 0], [0, 0, 0, 1], [1, 0, 0, 0], [0, 1, 0, 0]], dtype=float),
        lambda q, v: SwayState((q[0], q[1], v[0], v[1]), (q[2], q[3]), (v[2], v[3])),
        (0.0, 20.0, 0.0, 0.0),
    ),
}  # fmt: skip


def turned(a: Any, s: float, c: float) -> tuple[float, float, float]:
    """Return a vector of the axes of the closed form's frame, turned by an angle from the base's, in the base's."""
    return c * a[0] - s * a[1], s * a[0] + c * a[1], a[2]


@pytest.mark.parametrize("moving", [False, True], ids=["at rest", "on a moving base"])
@pytest.mark.parametrize("name", CASES)
def test_tree_equals_closed_form(name: str, moving: bool) -> None:
    """Accelerations under efforts and a force on the tip, and its mobility, are those of the closed form.

    To 1e-11 of their size at 100 random states: both round their cancellations, by some 1e-13.
    """
    case, rng = CASES[name], np.random.default_rng(17)
    n = len(case.middle)
    for _ in range(100):
        q, v = rng.uniform(-0.7, 0.7, n) + case.middle, rng.standard_normal(n)
        u, (force, along) = rng.standard_normal(n) * 50.0, rng.standard_normal((2, 3)) * 20.0
        w, alpha, imposed = rng.standard_normal((3, 3)) * (0.3 if moving else 0.0)
        base = BaseKinematics((0.0, 0.0, 0.0), tuple(imposed), tuple(w), tuple(alpha)) if moving else None
        motion = BaseMotion((-imposed[0], -imposed[1], G - imposed[2]), tuple(w), tuple(alpha))
        ours = of_tree(case, q, v, u, motion, tuple(force), tuple(along))
        theirs = of_closed_form(case, q, v, u, base, tuple(force), tuple(along))
        np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-11 * max(map(abs, theirs[:-1])))


def of_tree(case: Case, q: Any, v: Any, u: Any, motion: BaseMotion, force: Any, along: Any) -> tuple[float, ...]:
    """Return (accelerations of the closed form's coordinates, mobility of the tip along a vector) by the tree."""
    a = case.coordinates
    dynamics = compute_dynamics(case.tree, tuple(a @ q), tuple(a @ v), motion)
    s, c = dynamics.turn
    pulled, direction = ((c * x + s * y, c * y - s * x, z) for x, y, z in (force, along))
    efforts = np.linalg.solve(a.T, u) + efforts_of(case.tree, dynamics, case.tree.tip, pulled)
    mobility = point_mobility(case.tree, dynamics, case.tree.tip, direction)
    return (*np.linalg.solve(a, accelerations(dynamics, tuple(efforts))), mobility)


def of_closed_form(case: Case, q: Any, v: Any, u: Any, base: Any, force: Any, along: Any) -> tuple[float, ...]:
    """Return the same by the closed form, whose frame turns with the slew, or with the base for one that has none."""
    pose = forward_kinematics(case.closed, case.state(q, v))
    angle = 0.0 if isinstance(case.closed, Bridge) else q[0]
    s, c = np.sin(angle), np.cos(angle)
    tau = with_base(case.closed, tuple(u), turned_about_z(base, angle), pose)
    pulled, direction = turned(force, -s, c), turned(along, -s, c)
    return (*support_acceleration(case.closed, pose, G, tau, pulled), tip_mobility(case.closed, pose, direction))
