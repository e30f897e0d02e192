"""The equations of a scene, and a step of its method, as a self-contained C file."""

from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.files.errors import SceneError
from crane_sim.integrators.integration import scratch, step
from crane_sim.numerics.states import leaves
from crane_sim.scenes.scene import SceneSource, load_scene
from crane_sim.stepping.periods import begin
from crane_sim.tracing.c_source import c_source
from crane_sim.tracing.calls import trace_on_arrays
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import rebuilt


def export_c(scene: SceneSource, function: str = "rhs") -> str:
    """Return C99 source of a scene, its parameters as constants; it needs the C library only.

    It defines `void rhs(double t, double *x, double *u, double *derivative)`, the derivative of the
    state x at time t [s] under efforts u, or `void step(double t, double h, double *x, double *u,
    double *next)`, the state a step of h [s] of the scene's method later, efforts held. Its first
    comment has the state at the start, the order of the efforts, and the options of the compiler
    with which it has the bits of the simulator.

    Args:
        scene: a Scene, or what `load_scene` reads.
        function: "rhs" or "step".

    Raises:
        SceneError: the scene is invalid, the function is none of these, or the model has what C is
            not written for.
    """
    scene = load_scene(scene)
    if function not in _FUNCTIONS:
        raise SceneError(f"function = {function!r}: possible: {', '.join(_FUNCTIONS)}")
    x = begin(scene.model, np.array(scene.initial_q), np.array(scene.initial_v))[0].x
    start = np.array(leaves(x), dtype=float)
    n, nu = len(start), len(scene.actuated)
    make, sizes = _FUNCTIONS[function]
    try:
        traced = trace_on_arrays(make(scene, x), (*sizes, n, nu, n))
        text = c_source(traced, function)
    except TraceError as error:
        raise SceneError(
            f"scene {scene.name}: {function} cannot be written in C: {error}"
        ) from error
    return f"{_heading(scene, start)}{text}"


def _heading(scene: Any, start: np.ndarray) -> str:
    efforts = ", ".join(
        f"{name} [{unit}]" for name, unit in zip(scene.actuated, scene.effort_units, strict=True)
    )
    return (
        f"/* Crane of the scene {scene.name}.\n"
        f"   State at the start ({len(start)}): {', '.join(map(repr, start.tolist()))}\n"
        f"   Efforts ({len(scene.actuated)}): {efforts}\n"
        "   Compile it with -std=c99 -ffp-contract=off -fno-builtin-pow. */\n\n"
    )


def _make_rhs(scene: Any, like: Any) -> Any:
    p = scene.model

    def rhs(t: Any, x: Any, u: Any, derivative: Any) -> None:
        _store(derivative, system.rhs(p, t, _state_like(like, x, 0), system.efforts_from_row(p, u)))

    return rhs


def _make_step(scene: Any, like: Any) -> Any:
    p, method = scene.model, scene.method

    def one_step(t: Any, h: Any, x: Any, u: Any, following: Any) -> None:
        state = _state_like(like, x, 0)
        held = system.efforts_from_row(p, u)
        _store(following, step(method, p, t, state, held, h, scratch(state, p)))

    return one_step


_FUNCTIONS = {"rhs": (_make_rhs, (None,)), "step": (_make_step, (None, None))}
"""What makes each function, and the sizes of its arguments before state, efforts and result: None
of a number."""


def _state_like(like: Any, x: Any, first: int) -> Any:
    """Return the state whose floats are the elements of an array from the first on."""
    if isinstance(like, np.ndarray):
        return x
    if not isinstance(like, tuple):
        return x[first]
    parts = ()
    for part in like:
        parts = (*parts, _state_like(part, x, first))
        first += len(leaves(part))
    return rebuilt(like, parts)


def _store(out: Any, x: Any) -> None:
    entries = leaves(x)
    for i in range(len(entries)):
        out[i] = entries[i]
