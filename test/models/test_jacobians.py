"""Jacobians of every scene of the catalogue, by forward mode, against differences in 60 digits."""

from pathlib import Path

import numpy as np
import pytest
from exact_derivatives import exact_derivative

import crane_sim
from crane_sim import system
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.integration import scratch, step
from crane_sim.integrators.rodas import Rodas
from crane_sim.numerics.derivatives import (
    directional_derivatives,
    directions_like,
    rows_of,
    state_and_time_jacobian,
)
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.states import dimension

SCENES = sorted(
    file.stem for file in (Path(__file__).parents[2] / "config" / "scenes").glob("*.yaml")
)
EACH_KIND = [
    *(
        "knuckle_losses",
        "pendulum_sea",
        "overhead_energy",
        "overhead_spring",
        "overhead_long",
        "overhead_rods",
    ),
    *("overhead_elastic", "overhead_spatial", "port_sts_container", "tower_sway"),
]
SHORT = ["overhead_energy", "port_sts_container"]
COLUMNS = 3  # directions of eight that are compared
TIME = 0.3  # s
ILL_CONDITIONED = {
    **{"overhead_heavy": 1e-7, "overhead_horizontal": 1e-10, "overhead_long_cable": 1e-10},
    **{
        "overhead_kinked": 1e-11,
        "overhead_chain": 1e-11,
        "overhead_chain_50": 1e-11,
        "overhead_lqr_chain": 1e-11,
    },
}
"""Tolerances of chains with light nodes: tensions are differences of much larger numbers (payload
over node mass)."""


class Moving:
    """A scene's crane in motion, and directions of its state without discrete modes."""

    def __init__(self, name: str) -> None:
        scene = crane_sim.load_scene(name)
        rng = np.random.default_rng(SCENES.index(name))
        q = np.array(scene.initial_q) + 0.01
        x = system.state(scene.model, TIME, q, 0.1 * rng.normal(size=len(q)))
        u = tuple(rng.normal(size=len(scene.actuated)).tolist())
        self.arguments = scene.model, TIME, x, u
        self.jacobian, self.change = state_and_time_jacobian(system.rhs, *self.arguments)
        self.seeds = rng.normal(size=(dimension(x), 8))
        self.seeds[~np.any(self.jacobian, axis=1)] = 0.0
        self.of_time = rng.normal(size=8)
        self.directions = None, self.of_time, directions_like(x, self.seeds, 0), None


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.long] * (name not in EACH_KIND)) for name in SCENES],
)
def test_the_derivative_of_the_state_is_exact(name: str) -> None:
    """Along random directions, derivatives are within 1e-12 of differences in 60 digits.

    They are those of state and time, row by row.

    Relative to the sum of the products' sizes: about a thousand roundings, as an evaluation has
    them.
    """
    crane, tolerance = Moving(name), ILL_CONDITIONED.get(name, 1e-12)
    _, derivative = directional_derivatives(system.rhs, crane.arguments, crane.directions)
    change = np.outer(crane.change, crane.of_time)
    rows, scales = (
        np.array(rows_of(derivative)),
        np.abs(crane.jacobian) @ np.abs(crane.seeds) + np.abs(change),
    )
    scales[scales == 0.0] = 1.0
    assert np.max(np.abs(crane.jacobian @ crane.seeds + change - rows) / scales) < tolerance
    for column in range(COLUMNS):
        exact = exact_derivative(system.rhs, crane.arguments, crane.directions, column)
        assert np.max(np.abs(rows[:, column] - exact) / scales[:, column]) < tolerance


def step_of(p, t, x, u, h):
    """Return the state one step of size h after (t, x)."""
    return step(DOP853(), p, t, x, u, h, scratch(x, p))


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.long] * (name not in SHORT)) for name in SCENES]
)
def test_the_derivative_of_a_step_is_exact(name: str) -> None:
    """Along random directions the derivative of one step is that of differences.

    It includes its stages and its projection.

    Relative to the largest row of the step's change over all directions, by the tolerances of a
    dozen evaluations.
    """
    crane = Moving(name)
    stiff = isinstance(crane_sim.load_scene(name).method, Rodas)
    arguments, directions = (*crane.arguments, 1e-6 if stiff else 1e-4), (*crane.directions, None)
    _, derivative = directional_derivatives(step_of, arguments, directions)
    exact = exact_derivative(step_of, arguments, directions)
    found = np.array([row[0] for row in rows_of(derivative)])
    assert np.max(np.abs(found - exact)) < ILL_CONDITIONED.get(name, 1e-12) * np.max(np.abs(exact))


@entry_point
def compiled_jacobian(p, t, x, u):
    """Return the compiled derivatives of the state's derivative by the state."""
    return state_and_time_jacobian(system.rhs, p, t, x, u)[0]


@pytest.mark.parametrize("name", ["knuckle_setpoint", "tower_sway", "overhead_steel"])
def test_the_compiled_jacobian_is_that_of_python(name: str) -> None:
    """Compiled, tangents use fused operations: equal to rounding, of tuples and arrays."""
    crane = Moving(name)
    scale = np.max(np.abs(crane.jacobian), axis=1, keepdims=True)
    found = compiled_jacobian(*crane.arguments)
    assert np.all(np.abs(found - crane.jacobian) <= 1e-13 * scale)
