"""The equations of motion of a scene in joint coordinates: forward dynamics and energy."""

from collections.abc import Mapping, Sequence
from math import isfinite
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.files.errors import SceneError, shorten
from crane_sim.integrators import apply_pending_events, make_event_log, start
from crane_sim.numerics.jit import entry_point, seldom_called
from crane_sim.scenes.scene import SceneSource, load_scene

Vector = Sequence[float] | npt.NDArray[np.float64]


@entry_point
@seldom_called
def joint_acceleration(p, t, q, v, u):
    """Return the result of `acceleration`, compiled.

    Joints held by friction start to slip first where the efforts exceed static friction.
    """
    switches = system.switching(p)
    integration = apply_pending_events(
        switches, p, u, start(p, t, system.state(p, t, q, v), make_event_log(switches))
    )
    return system.acceleration(p, t, integration.x, u)


@entry_point
@seldom_called
def energy_at(p, t, q, v):
    """Return (energy relative to the base, difference of the energy in the world from it) [J]."""
    x = system.state(p, t, q, v)
    kinetic, potential = system.base_energy(p, t, x)
    return system.kinetic(p, x) + system.potential(p, x), kinetic + potential


def _as_vector(name: str, values: Vector, n: int) -> tuple[float, ...]:
    try:
        numbers = () if isinstance(values, str | Mapping) else tuple(map(float, values))
    except (TypeError, ValueError):
        numbers = ()
    if len(numbers) != n and len(numbers):
        raise SceneError(f"{name}: has {len(numbers)} values, {n} are needed")
    if len(numbers) != n or not all(map(isfinite, numbers)):
        raise SceneError(f"{name} = {shorten(values)}: must be {n} finite numbers")
    return numbers


def _time(t: Any) -> float:
    if isinstance(t, bool) or not isinstance(t, int | float | np.number) or not isfinite(t):
        raise SceneError(f"t = {shorten(t)}: must be a finite number of seconds")
    return float(t)


def acceleration(
    scene: SceneSource, q: Vector, v: Vector, u: Vector, t: float = 0.0
) -> npt.NDArray[np.float64]:
    """Return the accelerations of all joints (nq,) [m/s² or rad/s²], by forward dynamics.

    Args:
        scene: a Scene, or what `load_scene` reads.
        q, v: joint positions (nq,) [m or rad] and velocities (nq,) [m/s or rad/s], relative to the
            base.
        u: efforts of the actuated joints (nu,), in their units (N or N m for drives by force); they
            are not clipped to the limits of the drives.
        t: time [s], on which the motion of the base, the wind and changes of the payload depend.

    Raises:
        SceneError: the scene is invalid, or q, v, u or t is not of the right number of finite
            values.
    """
    scene = load_scene(scene)
    nq, nu = len(scene.joint_names), len(scene.actuated)
    q, v, u = _as_vector("q", q, nq), _as_vector("v", v, nq), _as_vector("u", u, nu)
    return np.array(joint_acceleration(scene.model, _time(t), np.array(q), np.array(v), u))


def energy(scene: SceneSource, q: Vector, v: Vector, t: float = 0.0, frame: str = "world") -> float:
    """Return the total energy [J]: kinetic energy, and potential energy of gravity and springs.

    Args:
        scene: a Scene, or what `load_scene` reads.
        q, v: joint positions (nq,) [m or rad] and velocities (nq,) [m/s or rad/s], relative to the
            base.
        t: time [s], which determines position and velocity of a moving base.
        frame: "world": velocities and heights in the world; "base": those relative to the base, as
            if it rested at height 0. They differ only where the base moves.

    Raises:
        SceneError: the scene is invalid, q, v or t is not of the right number of finite values, or
            the frame is unknown.
    """
    if frame not in ("world", "base"):
        raise SceneError(f"frame = {frame!r}: possible: world, base")
    scene = load_scene(scene)
    at = (
        np.array(_as_vector(name, vector, len(scene.joint_names)))
        for name, vector in (("q", q), ("v", v))
    )
    relative, added = energy_at(scene.model, _time(t), *at)
    return relative + added if frame == "world" else relative
