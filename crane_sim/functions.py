"""The equations of a scene as plain functions: forward dynamics and energy."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim import outputs as _outputs  # noqa: F401  registers what a crane shows
from crane_sim import system
from crane_sim.explain import SceneError
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
    found = tuple(map(float, values))
    if len(found) != n:
        raise SceneError(f"{name}: has {len(found)} values, {n} are needed")
    return found


def acceleration(scene: SceneSource, q: Vector, v: Vector, u: Vector, t: float = 0.0) -> npt.NDArray[np.float64]:
    """Return the joint accelerations (nq,) at positions q (nq,), velocities v (nq,) under efforts u (nu,), unlimited.

    Raises:
        SceneError: the scene is not possible, or a vector has the wrong length.
    """
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    nq, nu = len(scene.joint_names), len(scene.actuated)
    q, v, u = _numbers("q", q, nq), _numbers("v", v, nq), _numbers("u", u, nu)
    return np.array(joint_acceleration(scene.model, float(t), np.array(q), np.array(v), u))


def energy(scene: SceneSource, q: Vector, v: Vector) -> float:
    """Return the total energy [J] at positions q (nq,) and velocities v (nq,): kinetic, gravity, springs.

    Raises:
        SceneError: the scene is not possible, or a vector has the wrong length.
    """
    scene = scene if isinstance(scene, Scene) else load_scene(scene)
    at = (np.array(_numbers(name, vector, len(scene.joint_names))) for name, vector in (("q", q), ("v", v)))
    return energies(scene.model, state_of(scene.model, *at))[0]
