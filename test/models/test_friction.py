"""Dry friction by events: when joints stick and slip, what they hold, and what the energy says."""

from functools import cache
from math import acos, asin, cos, pi, sin
from typing import Any

import numpy as np
import pytest
from friction_events import Reference, Rubbing, Vector, bristle_forces, check_events, sines
from knuckle_derivation import mass_and_force
from scipy.integrate import solve_ivp

import crane_sim
from crane_sim import load_scene

G = 9.81
ACCURATE = {"method": "dop853", "rtol": 1e-13, "atol": 1e-14}
M, PAYLOAD, DRUM = 10.0, 5.0, 3.0
RAIL: Rubbing = {
    "trolley": {"coulomb": 14.0, "static": 24.0, "viscous": 1.0, "stribeck": 0.1},
    "hoist": {"coulomb": 3.0, "static": 6.0, "stribeck": 0.2},
}
RAIL_WAVES = {"trolley": (40.0, 5.0, 0.0), "hoist": (12.0, 4.0, -50.0)}
TROLLEY: dict[str, Any] = {
    "crane": "overhead",
    "duration": 4.0,
    "trolley": {"mass": M},
    "hoist": {"drive": "force", "inertia": DRUM},
    "cable": {"lengths": 2.0, "node_masses": PAYLOAD},
    "friction": RAIL,
    "initial": {"angles": 0.4},
    "inputs": sines(RAIL_WAVES),
    "integrator": ACCURATE,
}
BOOM: Rubbing = {
    "slew": {"coulomb": 12.0, "static": 16.0, "stribeck": 0.05},
    "boom": {"coulomb": 25.0, "static": 35.0, "viscous": 5.0},
    "jib": {"coulomb": 15.0, "static": 20.0, "stribeck": 0.1},
    "rope": {"coulomb": 1.5, "static": 2.5, "stribeck": 0.05, "viscous": 0.2},
}
BOOM_WAVES = {
    "slew": (30.0, 2.0, 0.0),
    "boom": (60.0, 1.5, 173.0),
    "jib": (40.0, 2.2, 95.0),
    "rope": (4.0, 3.0, -9.81),
}
BRISTLES: Rubbing = {
    "slew": {"coulomb": 12.0, "static": 16.0, "stribeck": 0.05, "stiffness": 3e3, "damping": 30.0},
    "boom": {
        "coulomb": 25.0,
        "static": 35.0,
        "stribeck": 0.1,
        "stiffness": 5e3,
        "damping": 50.0,
        "viscous": 5.0,
    },
    "rope": {"coulomb": 1.5, "static": 2.5, "stribeck": 0.05, "stiffness": 500.0, "damping": 5.0},
}
RAIL_BRISTLES: Rubbing = {
    "trolley": {
        "coulomb": 14.0,
        "static": 24.0,
        "viscous": 1.0,
        "stribeck": 0.1,
        "stiffness": 4e3,
        "damping": 60.0,
    }
}
KNUCKLE: dict[str, Any] = {
    "crane": "knuckle",
    "duration": 4.0,
    "boom": {"length": 5.0, "mass": 2.0, "inertia": 4.0},
    "jib": {"length": 4.0, "mass": 3.0, "inertia": 4.0},
    "tower": {"inertia": 10.0},
    "payload": {"mass": 1.0},
    "initial": {"q": [0, 0.8, -0.25, 2.0, 0.1, 0.2]},
    "inputs": sines(BOOM_WAVES),
    "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-13},
}


def trolley_equations(q: Vector, v: Vector, u: Vector) -> tuple[Vector, Vector]:
    """Return (mass matrix, generalised force) of (x, l, α): trolley, drum, payload, by Lagrange."""
    (_, length, a), (_, rate, w) = q, v
    s, c, m = sin(a), cos(a), PAYLOAD
    mass = np.array(
        [
            [M + m, m * s, m * length * c],
            [m * s, m + DRUM, 0.0],
            [m * length * c, 0.0, m * length**2],
        ]
    )
    turning = [m * length * w * w * s - 2.0 * m * rate * w * c, m * length * w * w + m * G * c]
    return mass, np.array(
        [u[0] + turning[0], u[1] + turning[1], -m * length * (2.0 * rate * w + G * s)]
    )


@cache
def trolley_events() -> list[tuple[float, int, float]]:
    """Return the events of the scene TROLLEY by the reference."""
    return Reference(trolley_equations, RAIL_WAVES, RAIL).events(
        np.array([0.0, 2.0, 0.4, 0.0, 0.0, 0.0]), 4.0
    )


SILENT = {"node": 1, "axis": "x", "force": {"kind": "constant", "value": 0.0}}
SPACE = {"dimensions": 3, "initial": {"directions": [[sin(0.4), 0.0, -cos(0.4)]]}}
MODELS: dict[str, dict[str, Any]] = {"rod": {}, "planar": {"forces": [SILENT]}, "spatial": SPACE}


@pytest.mark.parametrize(
    "model", ["rod", "planar", pytest.param("spatial", marks=pytest.mark.long)]
)
def test_trolley_and_drum_stick_and_slip(model: str) -> None:
    """Trolley and hoist with Stribeck friction stick and slip as Lagrange's equations say.

    This holds in all rigid models.
    """
    expected = trolley_events()
    assert len(expected) > 12 and {(0, 0.0), (1, 0.0), (0, 1.0), (1, -1.0)} <= {
        (j, mode) for _, j, mode in expected
    }
    check_events(crane_sim.simulate(TROLLEY | MODELS[model]), expected, ["trolley", "hoist"])


@pytest.mark.long
def test_every_joint_of_a_knuckle_crane_sticks_and_slips() -> None:
    """Four joints stick and slip at the times of Lagrange's equations with constraints.

    There is a constraint for each joint that sticks.
    """
    scene, frictionless = load_scene(KNUCKLE | {"friction": BOOM}), load_scene(KNUCKLE)
    case = Reference(lambda *at: mass_and_force(frictionless, *at), BOOM_WAVES, BOOM)
    expected = case.events(np.array([*scene.initial_q, *np.zeros(6)]), 4.0)
    assert len(expected) > 12 and {(0, 0.0), (2, 0.0), (1, -1.0), (3, 1.0)} <= {
        (j, mode) for _, j, mode in expected
    }
    check_events(crane_sim.simulate(scene), expected, ["slew", "boom", "jib", "winch"])


NO_STRENGTH = {"coulomb": 0.0, "static": 0.0, "stribeck": 0.1}


def test_friction_without_strength_is_none() -> None:
    """Joints whose friction is zero have no friction in the model: no state, no event, no cost."""
    assert (
        load_scene(KNUCKLE, {"friction": dict.fromkeys(BOOM, NO_STRENGTH)}).model
        == load_scene(KNUCKLE).model
    )
    model = load_scene(TROLLEY, {"friction": dict.fromkeys(RAIL, NO_STRENGTH)}).model
    assert model.trolley.friction is None and model.hoist.friction is None


SPRING = {"model": "elastic", "lengths": 2.0, "node_masses": 5.0, "stiffness": 1e4}
IMPOSSIBLE: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "imposed rope": (
        KNUCKLE,
        {"friction.rope": BOOM["rope"], "rope.drive": "rate"},
        "friction.rope: .* rope.drive",
    ),
    "static below": (
        KNUCKLE,
        {"friction.boom": {"coulomb": 2, "static": 1}},
        "friction.boom.static = 1.0: .* coulomb",
    ),
    "too large": (
        KNUCKLE,
        {"friction.jib": {"coulomb": 1, "static": 1e13}},
        "friction.jib.static = 1.*: must be at m",
    ),
    "no velocity": (
        TROLLEY,
        {"friction.trolley.stribeck": 0.0},
        "friction.trolley.stribeck = 0.0: must be greater",
    ),
    "no drum": (TROLLEY, {"hoist": {"drive": "force"}}, "friction.hoist: .* hoist.inertia"),
    "both": (
        KNUCKLE,
        {"friction": BOOM, "lugre": {"boom": BRISTLES["boom"]}},
        "lugre.boom: .* friction.boom",
    ),
    "both on a rail": (
        TROLLEY,
        {"lugre": RAIL_BRISTLES},
        "lugre.trolley: stands beside friction.trolley",
    ),
    "bristles": (
        TROLLEY,
        {"friction": None, "cable": SPRING, "lugre": RAIL_BRISTLES},
        "lugre.trolley: .* cable.model is 'elastic'",
    ),
}


@pytest.mark.parametrize("case", IMPOSSIBLE, ids=lambda name: name.replace(" ", "-"))
def test_friction_that_is_impossible_is_named(case: str) -> None:
    """Friction that contradicts itself or a drive is refused by one line with the keys of both."""
    scene, changes, line = IMPOSSIBLE[case]
    with pytest.raises(crane_sim.SceneError, match=line):
        load_scene(scene, changes)


def test_bristles_move_as_the_paper_says() -> None:
    """Three joints with LuGre friction move as Lagrange's equations with the bristles.

    The energy adds up.
    """
    joints, end = [0, 1, 3], 2.0
    frictionless = load_scene(KNUCKLE)
    changes = {
        "lugre": BRISTLES,
        "friction": {"jib": BOOM["jib"]},
        "duration": end,
        "integrator": {"method": "dop853"},
    }
    # the jib is held all the time
    scene = load_scene(KNUCKLE, changes | {"friction.jib.static": 1e4})

    def rates(t: float, y: Vector) -> Vector:
        q, v, z = np.split(y, [6, 12])
        u = np.array([b + a * sin(w * t) for a, w, b in BOOM_WAVES.values()])
        force, bending = bristle_forces(BRISTLES, v[joints], z)
        u[joints] -= force
        mass, total = mass_and_force(frictionless, q, v, u)
        free = [0, 1, 3, 4, 5]
        qdd = np.zeros(6)
        qdd[free] = np.linalg.solve(mass[np.ix_(free, free)], total[free])
        return np.concatenate([v, qdd, bending])

    start = np.array([*scene.initial_q, *np.zeros(9)])
    expected = solve_ivp(rates, (0.0, end), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    run = crane_sim.simulate(scene)
    assert run.events == [] and np.ptp(run.q[:, 0]) > 0.1
    # |v| bends the equations where a joint turns round, which costs both solutions an order there
    assert np.max(np.abs(np.concatenate([run.q[-1], run.v[-1]]) - expected[:12])) < 1e-9
    assert run.summary["energy_audit_max"] < 1e-9


@pytest.mark.parametrize("model", ["planar", "spatial"])
def test_bristles_of_a_trolley_bend_as_the_paper_says(model: str) -> None:
    """A trolley with LuGre friction moves as Lagrange's equations with bristles, in all models.

    The models are the rigid ones.
    """

    def rates(t: float, y: Vector) -> Vector:
        q, v, z = np.split(y, [3, 6])
        u = np.array([b + a * sin(w * t) for a, w, b in RAIL_WAVES.values()])
        force, bending = bristle_forces(RAIL_BRISTLES, v[:1], z)
        matrix, total = trolley_equations(q, v, u - [force[0], 0.0])
        return np.concatenate([v, np.linalg.solve(matrix, total), bending])

    start, end = np.array([0.0, 2.0, 0.4, 0.0, 0.0, 0.0, 0.0]), 2.0
    expected = solve_ivp(rates, (0.0, end), start, "DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    run = crane_sim.simulate(
        TROLLEY | MODELS[model] | {"duration": end, "friction": None, "lugre": RAIL_BRISTLES}
    )
    trolley = [run.q[-1, 0], run.v[-1, 0]]
    # |v| bends the equations where a joint turns round, which costs both solutions an order there
    assert run.events == [] and np.max(np.abs(trolley - expected[[0, 3]])) < 1e-9
    assert run.summary["energy_audit_max"] < 1e-9


def test_a_hoist_that_reverses_within_a_step_sticks() -> None:
    """A hoist whose rate V + cos t touches zero between steps sticks until its load frees it.

    Its velocity is interpolated by its derivatives: a guard of positions alone would have stepped
    over both events.
    """
    rate = 0.997  # m/s, of V: zero where cos t = -V
    effort = {"kind": "sine", "offset": -78.1, "amplitude": -30.0, "frequency": 1.0}
    document = {
        "crane": "overhead",
        "duration": 6.0,
        "trolley": {"drive": "fixed"},
        "cable": {"lengths": [5.0], "node_masses": [10.0]},
        "hoist": {"drive": "force", "inertia": 20.0},
        "friction": {"hoist": {"coulomb": 20.0, "static": 40.0}},
        "initial": {"length_rate": rate + 1.0},
        "inputs": {"hoist": effort},
        "integrator": {"method": "rk8", "step": 0.25},
    }
    run = crane_sim.simulate(document)
    sticks, slips = run.events
    assert (sticks[1], slips[1]) == ("the hoist sticks", "the hoist slips forwards")
    # a step of 0.25 s has errors of 1e-5 in the rate
    assert sticks[0] == pytest.approx(pi - acos(rate), abs=1e-3)
    load = 10.0 * 9.81 - 78.1  # N, held beside the sine; it breaks loose at 40 N
    assert slips[0] == pytest.approx(pi + asin((40.0 - load) / 30.0), abs=1e-6)
    assert run.summary["energy_audit_max"] < 1e-12
