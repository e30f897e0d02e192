"""Cranes with a load on elastic falls against the equations of `models.falls`, at random states."""

from typing import Any

import numpy as np
import pytest
from test_suspended_crane import CASES as SUPPORTS
from test_suspended_crane import SHIP, Case

import crane_sim
from crane_sim import system
from crane_sim.models.falls.crane import falls_layout, solve_dynamics, winch_index
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.supports.reeved_hoist import winch_response
from crane_sim.multibody import supports
from crane_sim.multibody.chain import Winch
from crane_sim.multibody.falls_crane import (
    Fall,
    FallsCrane,
    FallsInputs,
    FallsSolution,
    FallsState,
    aligned_attitude,
    falls_accelerations,
)
from crane_sim.multibody.load import RigidLoad
from crane_sim.multibody.tree import BaseMotion, Tree, accelerations, compute_dynamics

pytestmark = pytest.mark.interpreted
CASES = {
    "port_sts_container": SUPPORTS["bridge_hook_and_sling"],
    "spreader_skew": SUPPORTS["bridge_hook_and_sling"],
    "knuckle_ship_falls": SUPPORTS["knuckle_hook_and_sling"],
}


@pytest.mark.parametrize("ship", [False, True], ids=["as it stands", "on a ship"])
@pytest.mark.parametrize("name", CASES)
def test_accelerations_equal_those_of_the_model(name: str, ship: bool) -> None:
    """Accelerations of support, length and load are the model's at 50 random states with slack and taut falls.

    To 1e-9 of the largest: falls of 48 MN turn the rounding of a place, 1e-15 m, into 1e-12 of their pull.
    """
    case, rng = CASES[name], np.random.default_rng(29)
    scene = crane_sim.load_scene(name, SHIP if ship else {})
    p = scene.model._replace(contact=None, exchange=None, wind=None, energy_meter=None, stops=None)
    nq, first, modes = falls_layout(p)
    start = np.array(system.state(scene.model, 0.0, np.array(scene.initial_q), np.zeros(len(scene.initial_q))))
    for _ in range(50):
        x = np.array([*start[: 2 * nq], *rng.integers(0, 2, len(p.falls.offset))], dtype=float)
        x[:nq] += rng.uniform(-0.05, 0.05, nq)
        x[nq : 2 * nq] = rng.uniform(-0.2, 0.2, nq)
        t, tau = float(rng.uniform(0.0, 20.0)), tuple(rng.standard_normal(first).tolist())
        exact = solve_dynamics(p, t, x, tau)
        out = np.zeros_like(x)
        system.rhs_into(p, t, x, tau, out, None)
        ours = flat(case, solve(case, p, t, x, tau).accelerations)
        assert exact.pull.force != (0.0, 0.0, 0.0) or not x[modes:].any()
        np.testing.assert_allclose(ours, out[nq : 2 * nq], atol=1e-9 * abs(out[nq : 2 * nq]).max())


def solve(case: Case, p: Any, t: float, x: np.ndarray, tau: tuple[float, ...]) -> FallsSolution:
    """Return the solution of the crane of a tree, with what the model's winch answers."""
    (nq, first, modes), ns = falls_layout(p), len(case.coordinates)
    base, motion = base_kinematics_at(p.base, p.gravity, t), BaseMotion((0.0, 0.0, p.gravity))
    if base is not None:
        a = base.imposed
        motion = BaseMotion((-a[0], -a[1], p.gravity - a[2]), base.angular_velocity, base.angular_acceleration)
    hoisted, winch = first > ns, Winch()
    if hoisted:
        at = nq + ns, winch_index(p)
        inverse, bias = winch_response(p.hoist, t, tau, x, at, (x[ns], x[nq + ns], p.gravity))
        winch = Winch(0.0, bias, inverse)
    load = RigidLoad(p.load.mass, p.load.inertia, p.load.attachment)
    crane = FallsCrane(case.tree(p.support), falls_of(p.falls), load, None if hoisted else p.falls.length)
    efforts = tuple(np.linalg.solve(case.coordinates.T, tau[:ns]))
    q, v = aligned_attitude(state_of(case, x[:nq], hoisted), state_of(case, x[nq : 2 * nq], hoisted))
    return falls_accelerations(crane, q, v, FallsInputs(motion, efforts, tuple(x[modes:].tolist()), winch))


def falls_of(falls: Any) -> tuple[Fall, ...]:
    """Return the model's falls."""
    rows = zip(falls.top, falls.bottom, falls.axial_stiffness, falls.relaxation, falls.offset, strict=True)
    return tuple(Fall(tuple(a), tuple(b), *rest) for a, b, *rest in rows)


def state_of(case: Case, x: np.ndarray, hoisted: bool) -> FallsState:
    """Return positions or velocities of the model's state as those of the crane of a tree."""
    ns = len(case.coordinates)
    support, (centre, attitude) = tuple((case.coordinates @ x[:ns]).tolist()), (x[-7:-4], x[-4:])
    return FallsState(support, float(x[ns]) if hoisted else None, tuple(centre.tolist()), tuple(attitude.tolist()))


def flat(case: Case, a: FallsState) -> np.ndarray:
    """Return accelerations in the order of the model's state."""
    length = [] if a.length is None else [a.length]
    return np.array([*np.linalg.solve(case.coordinates, a.support), *length, *a.centre, *a.attitude])


REST = BaseMotion((0.0, 0.0, 9.81))
SLEWING = {
    "tower": (supports.tower_crane(900.0, 40.0), (), (12.0,)),
    "swaying tower": (supports.swaying_tower((9.0e3, 4.0e3), (-12.0, 25.0), 41.0, 550.0), (0.03, -0.02), (12.0,)),
}
"""Trees, and the positions of the joints before and after the slew."""


def four_falls(
    tree: Tree, q: Any, angle: float, v: Any = None, relaxation: float = 0.0, base: BaseMotion = REST
) -> FallsSolution:
    """Return the solution of a crane with a load at rest on four falls, turned by an angle about the vertical."""
    falls = tuple(Fall((a, b, 0.1), (a, b, 0.5), 1e6, relaxation) for a in (-1.0, 1.0) for b in (-0.7, 0.7))
    load = RigidLoad(1e3, ((1e3, 0.0, 0.0), (0.0, 1.2e3, 0.0), (0.0, 0.0, 900.0)), (0.0, 0.0, 0.0))
    s, c, rest = np.sin(angle), np.cos(angle), (0.0,) * len(q)
    attitude = (np.cos(angle / 2.0), 0.0, 0.0, np.sin(angle / 2.0))
    positions = FallsState(tuple(q), None, (12.1 * c - 0.1 * s, 12.1 * s + 0.1 * c, -10.6), attitude)
    inputs = FallsInputs(base, rest, (1.0,) * 4)
    return falls_accelerations(
        FallsCrane(tree, falls, load, 10.0),
        positions,
        FallsState(rest if v is None else tuple(v), None, (0.0,) * 3, (0.0,) * 4),
        inputs,
    )


@pytest.mark.parametrize("name", SLEWING)
def test_upper_ends_turn_with_the_slew(name: str) -> None:
    """Slew and load turned together change no tension, whichever joint slews: to the rounding of 1e-15 m of 1e6 N."""
    tree, mast, trolley = SLEWING[name]
    straight = (0.0,) * len(mast)
    expected, turned = (four_falls(tree, (*straight, angle, *trolley), angle).tensions for angle in (0.0, 0.8))
    np.testing.assert_allclose(turned, expected, rtol=1e-10)


@pytest.mark.parametrize("name", SLEWING)
def test_damping_goes_by_the_change_of_elongation(name: str) -> None:
    """At rates of the joints on a base that turns, the damped tension is that of the place ahead by the relaxation.

    T = EA/L (e + τ e') is T of e(t + τ) up to τ² e''/2: τ = 1e-7 s leaves 1e-14 m of elongations of a centimetre.
    """
    tree, mast, trolley = SLEWING[name]
    q, v, tau = np.array([*mast, 0.75, *trolley]), np.array([*(0.1 for _ in mast), 0.4, -0.3]), 1e-7
    base = BaseMotion((0.0, 0.0, 9.81), (0.1, -0.2, 0.3), (0.0, 0.0, 0.0), (1.0, 2.0, 0.5))
    damped = four_falls(tree, q, 0.8, v, tau, base).tensions
    np.testing.assert_allclose(damped, four_falls(tree, q + tau * v, 0.8).tensions, rtol=1e-9)


@pytest.mark.parametrize("name", SLEWING)
def test_the_pull_on_the_support_is_that_of_the_falls_energy(name: str) -> None:
    """Beside their own, falls accelerate the joints by M⁻¹ of the slope of their energy, the sum of T² L / (2 EA).

    The slope by central differences: of steps of 1e-5 m errors of 1e-10, beside a rounding of 1e-9.
    """
    tree, mast, trolley = SLEWING[name]
    q, h = np.array([*mast, 0.75, *trolley]), 1e-5

    def energy(positions: np.ndarray) -> float:
        return sum(tension**2 for tension in four_falls(tree, positions, 0.8).tensions) * 10.0 / 2e6

    slope = np.array([(energy(q + h * e) - energy(q - h * e)) / (2.0 * h) for e in np.eye(len(q))])
    dynamics = compute_dynamics(tree, tuple(q), (0.0,) * len(q), REST)
    expected = accelerations(dynamics, tuple(-slope))
    np.testing.assert_allclose(four_falls(tree, q, 0.8).accelerations.support, expected, rtol=1e-7)
