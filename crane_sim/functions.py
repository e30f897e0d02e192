"""The equations of a scene as plain functions: forward dynamics and energy."""

from collections.abc import Mapping, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim import outputs as _outputs  # noqa: F401  registers what a crane shows
from crane_sim import system
from crane_sim.explain import SceneError, shortened
from crane_sim.integrators import record, settled, start
from crane_sim.jit import entry
from crane_sim.metrics import energies
from crane_sim.scene import Scene, load_scene

Vector = Sequence[float] | npt.NDArray[np.float64]
SceneSource = Scene | str | Path | Mapping[str, Any]


@entry
def joint_acceleration(p, t, q, v, u):
    """Compiled `acceleration`; what sticks breaks loose first where the efforts are strong enough."""
    switches = system.switching(p)
    flow = settled(switches, p, u, start(p, t, system.state(p, t, q, v), record(switches)))
    return system.acceleration(p, t, flow.x, u)


@entry
def state_of(p, q, v):
    """Compiled `system.state`."""
    return system.state(p, 0.0, q, v)


def _numbers(name: str, values: Vector, n: int) -> tuple[float, ...]:
    try:
        found = () if isinstance(values, str | Mapping) else tuple(map(float, values))
    except (TypeError, ValueError):
        found = ()
    if len(found) != n and len(found):
        raise SceneError(f"{name}: has {len(found)} values, {n} are needed")
    if len(found) != n or not all(map(isfinite, found)):
        raise SceneError(f"{name} = {shortened(values)}: must be {n} finite numbers")
    return found


def _time(t: Any) -> float:
    if isinstance(t, bool) or not isinstance(t, int | float | np.number) or not isfinite(t):
        raise SceneError(f"t = {shortened(t)}: must be a finite number of seconds")
    return float(t)


def acceleration(scene: SceneSource, q: Vector, v: Vector, u: Vector, t: float = 0.0) -> npt.NDArray[np.float64]:
    """Return the joint accelerations (nq,) at positions q (nq,), velocities v (nq,) under efforts u (nu,), unlimited.

    Raises:
        SceneError: the scene is not possible, or a vector is not of as many finite numbers as the scene asks for.
    """
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    nq, nu = len(scene.joint_names), len(scene.actuated)
    q, v, u = _numbers("q", q, nq), _numbers("v", v, nq), _numbers("u", u, nu)
    return np.array(joint_acceleration(scene.model, _time(t), np.array(q), np.array(v), u))


def energy(scene: SceneSource, q: Vector, v: Vector) -> float:
    """Return the total energy [J] at positions q (nq,) and velocities v (nq,): kinetic, gravity, springs.

    Raises:
        SceneError: the scene is not possible, or a vector is not of as many finite numbers as the scene asks for.
    """
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    at = (np.array(_numbers(name, vector, len(scene.joint_names))) for name, vector in (("q", q), ("v", v)))
    return energies(scene.model, state_of(scene.model, *at))[0]
