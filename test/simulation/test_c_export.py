"""The equations of a scene as C have the bits of the simulator."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from c_compiler import c_function, needs_compiler

import crane_sim
from crane_sim import system
from crane_sim.integrators.integration import scratch, step
from crane_sim.numerics.states import leaves
from crane_sim.simulation.c_export import _state_like
from crane_sim.stepping.periods import begin


@needs_compiler
@pytest.mark.parametrize(
    ("name", "function"),
    [("knuckle_setpoint", "rhs"), ("overhead_chain", "step"), ("overhead_stiff", "step")],
)
def test_c_has_the_bits_of_the_simulator(name: str, function: str, tmp_path: Path) -> None:
    """C has the simulator's derivative of floats, explicit step of an array, and implicit step.

    The implicit one has derivatives.
    """
    scene = crane_sim.load_scene(name)
    p, u = scene.model, 100.0 * np.arange(1.0, 1.0 + len(scene.actuated))
    start = begin(p, np.array(scene.initial_q), np.array(scene.initial_v))[0].x
    x = np.array(leaves(start)) + 1e-3  # nothing is at rest
    out = np.empty_like(x)
    given = (0.5, 0.01) if function == "step" else (0.5,)
    c_function(crane_sim.export_c(scene, function), function, tmp_path)(*given, x, u, out)
    state: Any = _state_like(start, x if isinstance(start, np.ndarray) else tuple(x.tolist()), 0)
    held = system.efforts_from_row(p, u)
    if function == "rhs":
        expected = system.rhs(p, 0.5, state, held)
    else:
        expected = step(scene.method, p, 0.5, state, held, 0.01, scratch(state, p))
    assert np.array_equal(out, leaves(expected))


def test_another_function_is_a_single_line_error() -> None:
    """A name that is none of the two names both."""
    with pytest.raises(crane_sim.SceneError, match="function = 'energy': possible: rhs, step"):
        crane_sim.export_c("overhead_energy", "energy")
