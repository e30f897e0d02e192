"""Cranes of a tree, a chain and a load against the equations of `models.suspended`, at random states."""

from typing import Any, NamedTuple

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.models.loads import RigidLoad as ModelBody
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.supports.reeved_hoist import winch_response
from crane_sim.models.suspended.crane import suspended_layout
from crane_sim.multibody import supports
from crane_sim.multibody.chain import Winch
from crane_sim.multibody.load import PointLoad, RigidLoad
from crane_sim.multibody.supports import Bar
from crane_sim.multibody.suspended_crane import Crane, Inputs, Solution, State, aligned, crane_accelerations
from crane_sim.multibody.tree import BaseMotion, Tree

pytestmark = pytest.mark.interpreted
SHIP = {
    "base_motion": {
        "roll": {"amplitude": "4 deg", "frequency": 0.7},
        "pitch": {"amplitude": "3 deg", "frequency": 0.9},
        "heave": {"amplitude": 1.5, "frequency": 0.8},
        "sway": {"amplitude": 1.0, "frequency": 0.6},
    }
}


class Case(NamedTuple):
    """A catalogue scene, its support as a tree, and how its coordinates become the tree's."""

    tree: Any  # of the model's support
    coordinates: Any  # (ns, ns)
    changes: dict[str, Any]


def knuckle_tree(s: Any) -> Tree:
    """Return the tree of a knuckle boom."""
    boom, jib = (Bar(rod.mass, rod.inertia, 0.5 * rod.length, rod.axial_inertia) for rod in (s.boom, s.jib))
    motors = s.motors or (0.0, 0.0, 0.0)
    return supports.knuckle_boom(s.tower.inertia, boom, jib, (s.boom.length, s.jib.length), motors)


def mobile_tree(s: Any) -> Tree:
    """Return the tree of a telescopic boom."""
    base = Bar(s.base_section.mass, s.base_section.inertia, s.base_section.centre, 0.0)
    telescope = Bar(s.telescope.mass, s.telescope.inertia, -s.telescope.centre, 0.0)
    return supports.telescopic_boom(s.superstructure.inertia, s.superstructure.foot, base, telescope)


RELATIVE = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 1.0]])
CASES = {
    "bridge_hook_and_sling": Case(
        lambda s: supports.bridge(s.trolley.mass, s.bridge.mass), np.array([[0.0, 1.0], [1.0, 0.0]]), {}
    ),
    "knuckle_hook_and_sling": Case(knuckle_tree, RELATIVE, {}),
    "mobile_lift": Case(mobile_tree, np.eye(3), {}),
    "tower_gust": Case(
        lambda s: supports.tower_crane(s.slew.inertia, s.trolley.mass), np.eye(2),
        {"wind": None, "payload.windage": None},
    ),
}  # fmt: skip


@pytest.mark.parametrize("ship", [False, True], ids=["on the ground", "on a ship"])
@pytest.mark.parametrize("name", CASES)
def test_accelerations_equal_those_of_the_model(name: str, ship: bool) -> None:
    """Accelerations of support, rope, links and load, and the tensions, are the model's at 50 random states.

    To 1e-10 of the largest: the closed forms that they are compared with cancel to some 1e-12 of it.
    """
    case, rng = CASES[name], np.random.default_rng(23)
    scene = crane_sim.load_scene(name, case.changes | (SHIP if ship else {}))
    p = scene.model
    for _ in range(50):
        t, x = float(rng.uniform(0.0, 20.0)), random_state(scene, rng)
        tau = tuple((rng.standard_normal(len(case.coordinates) + 1) * 1e3).tolist())
        out, row = np.zeros_like(x), np.zeros((1, len(p.cable.masses)))
        system.rhs_into(p, t, x, tau, out, system.workspace(p))
        system.tensions(p, t, x, tau, row, 0, 0)
        nq = suspended_layout(p)[0]
        solution = solve(case, p, t, x, tau)
        ours = flat(case, solution.accelerations)
        np.testing.assert_allclose(ours, out[nq : 2 * nq], atol=1e-10 * abs(out[nq : 2 * nq]).max())
        np.testing.assert_allclose(solution.tensions, row[0], atol=1e-10 * abs(row).max())


def random_state(scene: Any, rng: np.random.Generator) -> np.ndarray:
    """Return a state: support and length about where they start, links and load swinging and turning."""
    p = scene.model
    x = np.array(system.state(p, 0.0, np.array(scene.initial_q), np.zeros(len(scene.initial_q))))
    nq, first, _ = suspended_layout(p)
    x[:first] += rng.uniform(-0.3, 0.3, first)
    x[first:nq] += rng.uniform(-0.4, 0.4, nq - first)
    x[nq : 2 * nq] = rng.uniform(-0.4, 0.4, nq)
    return x


def solve(case: Case, p: Any, t: float, x: np.ndarray, tau: tuple[float, ...]) -> Solution:
    """Return the solution of the crane of a tree, with what the model's winch answers."""
    nq, first, end = suspended_layout(p)
    ns = len(case.coordinates)
    base = base_kinematics_at(p.base, p.gravity, t)
    motion = BaseMotion((0.0, 0.0, p.gravity))
    if base is not None:
        a = base.imposed
        motion = BaseMotion((-a[0], -a[1], p.gravity - a[2]), base.angular_velocity, base.angular_acceleration)
    response = winch_response(p.hoist, t, tau, x, (nq + ns, end), (x[ns], x[nq + ns], p.gravity))
    efforts = tuple(np.linalg.solve(case.coordinates.T, tau[:ns]))
    load = PointLoad(p.load.mass)
    if isinstance(p.load, ModelBody):
        load = RigidLoad(p.load.mass, p.load.inertia, p.load.attachment)
    masses, lengths = tuple(p.cable.masses[:-1]), tuple(p.cable.lengths)
    crane = Crane(case.tree(p.support), masses, lengths, load, hoisted=True)
    winch = Winch(0.0, response[1], response[0]) if response[0] >= 0.0 else Winch(tension=response[1])
    q, v = aligned(state_of(case, p, x[:nq]), state_of(case, p, x[nq : 2 * nq]))
    return crane_accelerations(crane, q, v, Inputs(motion, efforts, winch))


def state_of(case: Case, p: Any, x: np.ndarray) -> State:
    """Return positions or velocities of the model's state as those of the crane of a tree."""
    ns, n = len(case.coordinates), len(p.cable.masses)
    links = tuple(tuple(x[ns + 1 + 3 * k : ns + 4 + 3 * k].tolist()) for k in range(n))
    attitude = tuple(x[-4:].tolist()) if isinstance(p.load, ModelBody) else None
    return State(tuple((case.coordinates @ x[:ns]).tolist()), float(x[ns]), links, attitude)  # type: ignore[arg-type]


def flat(case: Case, accelerations: State) -> np.ndarray:
    """Return accelerations in the order of the model's state."""
    support = np.linalg.solve(case.coordinates, accelerations.support)
    links = [component for n in accelerations.directions for component in n]
    return np.array([*support, accelerations.length, *links, *(accelerations.attitude or ())])
