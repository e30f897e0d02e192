"""Initial states of a run, and states from which it continues."""

from collections.abc import Sequence
from dataclasses import replace
from math import isfinite, pi, remainder
from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.files.errors import SceneError, shorten
from crane_sim.hardware.drives import Drives
from crane_sim.integrators import Status, apply_pending_events, dense_output, restart
from crane_sim.numerics.jit import NONE, entry_point, optimisation
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.hardware import HardwareRun
from crane_sim.stepping.hardware_periods import state_at
from crane_sim.stepping.periods import begin
from crane_sim.system import efforts_from_row, switching

_TOLERANCE = 1e-9  # relative difference of a joint from its wanted value, for rounding


def as_tuple(vector: Any) -> tuple[float, ...]:
    """Return a vector of compiled code, a tuple or an array, as a tuple of floats."""
    return vector if isinstance(vector, tuple) else tuple(vector.tolist())


@entry_point
@optimisation(NONE)
def switch_at_start(p, integration, row):
    """Return an initial integration, switched by every guard that fails under `row` (nu,).

    `row` has the efforts.
    """
    return apply_pending_events(switching(p), p, efforts_from_row(p, row), integration)


@entry_point
@optimisation(NONE)
def restart_within_step(method, p, u, integration, t):
    """Return the integration restarted at time t [s] within the last step, under the source u."""
    return restart(integration, t, dense_output(method, p, u, integration, t))


@entry_point
@optimisation(NONE)
def restart_under_drives(method, p, hardware, inputs, integration, t):
    """Return the integration restarted at time t [s] within the last step, taken under drives.

    The drives have these inputs.
    """
    u = Drives(t, hardware.drives, hardware.servos, inputs)
    return restart(integration, t, state_at(inputs, method, p, u, integration, t))


def make_initial(scene: Scene) -> tuple[Any, Any, Any, Any, HardwareRun | None]:
    """Return (integration, q, v, measured (q, v), the scene's hardware) at the start of a run."""
    integration, q, v = begin(scene.model, np.array(scene.initial_q), np.array(scene.initial_v))
    q, v = as_tuple(q), as_tuple(v)
    if scene.hardware is None or scene.hardware.ideal:
        return integration, q, v, (q, v), None
    hardware = HardwareRun(scene)
    measured = hardware.sample_first_state(scene.model, integration, scene.period)
    return integration, q, v, (as_tuple(measured[0]), as_tuple(measured[1])), hardware


def resume(metered: Any, integration: Any, t: float, q: Sequence[float], v: Sequence[float]) -> Any:
    """Return an integration without a meter as one of the metered model.

    It goes on from time t [s] and joints q, v.
    """
    # without a meter no part of a state depends on the time
    initial, _, _ = begin(metered, np.array(q), np.array(v))
    evaluations, steps, rejected = integration.evaluations, integration.steps, integration.rejected
    return initial._replace(t0=t, t=t, evaluations=evaluations, steps=steps, rejected=rejected)


def with_initial(scene: Scene, q: Sequence[float] | None, v: Sequence[float] | None) -> Scene:
    """Return the scene with another initial state; arguments of `Plant.reset`.

    Raises:
        SceneError: the crane cannot be in that state.
    """
    if q is None and v is None:
        return scene
    positions = _as_tuple(scene, "positions", scene.initial_q if q is None else q)
    velocities = _as_tuple(scene, "velocities", scene.initial_v if v is None else v)
    start = replace(scene, initial_q=positions, initial_v=velocities)
    integration, *shown = begin(scene.model, np.array(positions), np.array(velocities))
    for what, wanted, actual in zip(
        ("positions", "velocities"), (positions, velocities), shown, strict=True
    ):
        _check_possible(scene, what, wanted, as_tuple(actual))
    integration = switch_at_start(
        _without_slack_guard(scene.model), integration, np.zeros(len(scene.actuated))
    )
    if integration.status == Status.TERMINATED:
        raise SceneError(
            f"positions: {system.describe_event(scene.model, integration.terminal_guard)[0]} there"
        )
    return start


def _without_slack_guard(model: Any) -> Any:
    """Return the model without the guard of a slack rope; an overhead crane keeps it.

    Without efforts a boom may accelerate faster than its falling payload.
    """
    stops, overhead = getattr(model, "stops", None), getattr(model, "overhead", None)
    return (
        model
        if stops is None or overhead is not None
        else model._replace(stops=stops._replace(taut=0.0))
    )


def _as_tuple(scene: Scene, what: str, values: Sequence[float]) -> tuple[float, ...]:
    try:
        numbers = tuple(map(float, values))
    except (TypeError, ValueError):
        raise SceneError(
            f"{what} = {shorten(values)}: must be a number for each of the joints"
        ) from None
    if len(numbers) != len(scene.joint_names):
        raise SceneError(
            f"{what}: has {len(numbers)} values, the joints are {', '.join(scene.joint_names)}"
        )
    for name, value in zip(scene.joint_names, numbers, strict=True):
        if not isfinite(value):
            raise SceneError(f"{what}: {name} = {value}: must be finite")
    return numbers


def _check_possible(
    scene: Scene, what: str, wanted: tuple[float, ...], actual: tuple[float, ...]
) -> None:
    """Raise SceneError for a joint that the crane holds elsewhere, e.g. a locked rope's length."""
    for name, unit, expected, possible in zip(
        scene.joint_names, scene.joint_units, wanted, actual, strict=True
    ):
        turn = unit == "rad" and what == "positions"
        gap = remainder(expected - possible, 2.0 * pi) if turn else expected - possible
        if not abs(gap) <= _TOLERANCE * max(1.0, abs(expected)):
            raise SceneError(
                f"{what}: {name} = {expected:g}: is not possible, this crane would have "
                f"{possible:g}"
            )
