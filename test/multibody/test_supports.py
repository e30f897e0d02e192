"""The knuckle boom as a tree against the closed form that single ropes use.

They are compared at random states.
"""

from typing import Any

import numpy as np
import pytest

from crane_sim.models.effects import BoomSpring, JibSpring
from crane_sim.models.moving_base import BaseKinematics, turned_about_z
from crane_sim.models.supports.knuckle_boom import Knuckle, Rod, Tower
from crane_sim.models.supports.support import Support, SupportState, compute_posture
from crane_sim.models.supports.support_dynamics import (
    accelerations,
    base_efforts,
    compute_dynamics,
    joint_efforts,
    net_efforts,
    responses,
    tip_efforts,
)
from crane_sim.multibody import linear

G, MOTORS = 9.81, (0.4, 0.2, 0.1)
ROD = Rod(5.0, 2.0, 4.2), Rod(4.0, 3.0, 4.0)
SPRINGS = BoomSpring(30.0, 0.3), JibSpring(20.0, -0.2, True)
CASES = {
    "thin rods": Knuckle(*ROD, Tower(8.0)),
    "rods with axial inertia": Knuckle(
        *(rod._replace(axial_inertia=0.3) for rod in ROD), Tower(8.0)
    ),
    "springs and motors": Knuckle(*ROD, Tower(8.0), *SPRINGS, motors=MOTORS),
}


@pytest.mark.parametrize("moving", [False, True], ids=["at rest", "on a moving base"])
@pytest.mark.parametrize("name", CASES)
def test_tree_equals_closed_form(name: str, moving: bool) -> None:
    """Accelerations under efforts and a tip force, and its mobility, are the closed form's.

    To 1e-11 of their size at 100 random states: both round their cancellations, by some 1e-13.
    """
    rng = np.random.default_rng(17)
    for _ in range(100):
        q, v = rng.uniform(-0.7, 0.7, 3), rng.standard_normal(3)
        u, (force, along) = tuple(rng.standard_normal(3) * 50.0), rng.standard_normal((2, 3)) * 20.0
        w, alpha, imposed = rng.standard_normal((3, 3)) * 0.3
        base = (
            BaseKinematics((0.0, 0.0, 0.0), tuple(imposed), tuple(w), tuple(alpha))
            if moving
            else None
        )
        ours = of_tree(CASES[name], q, v, u, base, tuple(force), tuple(along))
        theirs = of_closed_form(CASES[name], q, v, u, base, tuple(force), tuple(along))
        np.testing.assert_allclose(
            ours, theirs, rtol=1e-11, atol=1e-11 * max(map(abs, theirs[:-1]))
        )


def of_tree(
    knuckle: Knuckle, q: Any, v: Any, u: Any, base: Any, force: Any, along: Any
) -> tuple[float, ...]:
    """Return (accelerations, the tip's mobility along a vector) by the tree.

    Vectors are in the slewing frame.
    """
    support = Support(knuckle, knuckle.motors)
    posture = compute_posture(support, SupportState(tuple(q), tuple(v), (), ()))
    dynamics = compute_dynamics(support, posture)
    efforts = linear.add(joint_efforts(support, posture, u), base_efforts(posture, base))
    net = net_efforts(dynamics, G, linear.add(efforts, tip_efforts(posture, force)))
    levers = tip_efforts(posture, along)
    return (*accelerations(dynamics, net, ()), linear.inner(levers, responses(dynamics, levers)))


def of_closed_form(
    knuckle: Knuckle, q: Any, v: Any, u: Any, base: Any, force: Any, along: Any
) -> tuple[float, ...]:
    """Return the same by the closed form."""
    pose = knuckle.forward_kinematics((*q, *v))
    tau = knuckle.add_base_efforts(u, turned_about_z(base, q[0]), pose)
    return (*knuckle.accelerations(pose, G, tau, force), knuckle.tip_mobility(pose, along))
