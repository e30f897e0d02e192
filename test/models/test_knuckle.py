"""The knuckle crane's equations against published states, a second derivation, conservation."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from comparison import relative
from knuckle_derivation import second_derivation

import crane_sim
from crane_sim import system
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.states import add_scaled
from crane_sim.simulation.derived import derive

REFERENCE = json.loads((Path(__file__).parents[1] / "data" / "knuckle.json").read_text())
GROUPS: dict[str, dict[str, Any]] = {
    "plain": {},
    "turning rods": {"boom.axial_inertia": 0.3, "jib.axial_inertia": 0.1},
    "springs": {
        "springs": {
            "boom": {"stiffness": 200.0, "rest": 0.7},
            "jib": {"stiffness": 100.0, "rest": -1.0, "relative": True},
            "rope": {"stiffness": 20.0, "rest": 2.5},
        }
    },
    "absolute jib spring": {"springs": {"jib": {"stiffness": 100.0, "rest": "-20 deg"}}},
    "drag": {"payload_drag": {"coefficient": 0.3}},
    "quadratic friction": {
        "swing_friction": {"model": "quadratic", "tangential": 0.3, "radial": 0.2}
    },
    "linear friction": {"swing_friction": {"model": "linear", "tangential": 0.3, "radial": 0.2}},
    "paper friction": {"swing_friction": {"model": "paper", "tangential": 0.3, "radial": 0.2}},
}
# relative: two derivations in doubles differ by rounding times the condition of the 6x6 matrix,
# ~1e3
EQUATIONS = 1e-12


def scene_of(
    parameters: dict[str, float], changes: dict[str, Any] | None = None, **more: Any
) -> crane_sim.Scene:
    """Return a scene with the reference file's parameters."""
    p = parameters
    document = {
        "crane": "knuckle",
        "duration": 20.0,
        "gravity": p["g"],
        "boom": {"length": p["l_B"], "mass": p["m_B"], "inertia": p["I_B"]},
        "jib": {"length": p["l_J"], "mass": p["m_J"], "inertia": p["I_J"]},
        "tower": {"inertia": p["I_tot"]},
        "payload": {"mass": p["m"]},
        "initial": {"q": [0, 0.5, -0.2, 2.0, 0, 0]},
    }
    return crane_sim.load_scene(document | more, changes)


@pytest.mark.parametrize(
    "state", REFERENCE["random_states"], ids=range(len(REFERENCE["random_states"]))
)
def test_accelerations_equal_forty_digit_ones(state: dict[str, Any]) -> None:
    """Forward dynamics equal the published 40-digit accelerations.

    They do without losses, with friction and with drag.
    """
    friction = {"model": "quadratic", "tangential": state["k1"], "radial": state["k2"]}
    groups = {
        "qdd": {},
        "qdd_friction_mode2": {"swing_friction": friction},
        "qdd_drag": {"payload_drag": {"coefficient": state["cdrag"]}},
    }
    for key, group in groups.items():
        scene = scene_of(state["params"], **group)
        actual = crane_sim.acceleration(scene, state["q"], state["qd"], state["u"])
        assert relative(actual, state[key]) < EQUATIONS, key


def random_states(n: int) -> list[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return n random (q, v, u), the swing anywhere within 80 degrees."""
    rng = np.random.default_rng(1)
    low, high = np.array([-3, -1.2, -1.2, 0.5, -1.4, -1.4]), np.array([3, 1.2, 1.2, 4.0, 1.4, 1.4])
    return [(rng.uniform(low, high), rng.normal(0, 1, 6), rng.normal(0, 50, 4)) for _ in range(n)]


@pytest.mark.parametrize("group", GROUPS, ids=lambda name: name.replace(" ", "-"))
def test_accelerations_equal_a_second_derivation(group: str) -> None:
    """Forward dynamics equal sympy's Lagrange equations from T and U.

    They do for every optional group.
    """
    scene = scene_of(REFERENCE["random_states"][0]["params"], GROUPS[group])
    for q, v, u in random_states(20):
        assert (
            relative(crane_sim.acceleration(scene, q, v, u), second_derivation(scene, q, v, u))
            < EQUATIONS
        )


@entry_point
def balance(p, q, v, u, h):
    """Return (dE/dt by central differences along the motion, power) at a state."""
    x = system.state(p, 0.0, q, v)
    dx = system.rhs(p, 0.0, x, u)
    ahead, behind = add_scaled(x, h, dx), add_scaled(x, -h, dx)
    gained = (
        system.kinetic(p, ahead)
        - system.kinetic(p, behind)
        + system.potential(p, ahead)
        - system.potential(p, behind)
    )
    return gained / (2.0 * h), system.power(p, 0.0, x, u)


DRIVES = {
    "rate": {"rope": {"drive": "rate"}},
    "lagging rate": {"rope": {"drive": "rate", "time_constant": 0.2}},
}


@pytest.mark.parametrize(
    "group", [*GROUPS, *DRIVES, "locked"], ids=lambda name: name.replace(" ", "-")
)
def test_power_balance(group: str) -> None:
    """The energy changes by the power of efforts, winch and losses and by nothing else.

    This holds for every group and drive.
    """
    changes = {**GROUPS, **DRIVES, "locked": {"rope": {"drive": "locked"}}}[group]
    scene = scene_of(REFERENCE["random_states"][0]["params"], changes)
    for q, v, u in random_states(10):
        v[3] = 0.0 if group == "locked" else v[3]
        change, power = balance(
            scene.model, tuple(q), tuple(v), tuple(u[: len(scene.actuated)]), 1e-5
        )
        # central differences: truncation h^2 times a third derivative ~1e3 W/s^2, rounding 1e-16 E
        # / h
        assert change == pytest.approx(power, rel=1e-6, abs=1e-5)


@pytest.mark.parametrize("drive", ["rate", "lagging rate", "locked"])
def test_imposed_rope_motion_is_the_force_driven_one_at_that_tension(drive: str) -> None:
    """A rope of imposed motion moves the crane exactly as a force-driven one at its tension."""
    parameters = REFERENCE["random_states"][0]["params"]
    free = scene_of(parameters)
    scene = scene_of(parameters, {**DRIVES, "locked": {"rope": {"drive": "locked"}}}[drive])
    for q, v, u in random_states(10):
        v[3] = 0.0 if drive == "locked" else v[3]
        u = u[: len(scene.actuated)]
        tension = derive(scene, np.zeros(1), q[None], v[None], u[None]).tension[0]
        actual = crane_sim.acceleration(scene, q, v, u)
        expected_rope = {"rate": u[-1], "lagging rate": (u[-1] - v[3]) / 0.2, "locked": 0.0}[drive]
        # the tension is formed from terms up to 1e2 times the result
        assert actual[3] == pytest.approx(expected_rope, abs=1e-10)
        assert relative(crane_sim.acceleration(free, q, v, [*u[:3], -tension]), actual) < 1e-11


def test_energy_of_the_reference() -> None:
    """`energy` equals the published total energy along a trajectory."""
    for case in REFERENCE["trajectories"]:
        scene = scene_of(case["params"])
        for sample in case["samples"]:
            assert crane_sim.energy(scene, sample["q"], sample["qd"]) == pytest.approx(
                sample["E"], abs=1e-11
            )  # rounding of ~1e2 J
