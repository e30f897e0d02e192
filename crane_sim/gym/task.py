"""A scene as an agent's task: commands, observations, the payload's goal, effects of the seed."""

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple, cast

import numpy as np
import numpy.typing as npt
from gymnasium.spaces import Box, Space

from crane_sim.files.errors import SceneError, shorten
from crane_sim.scenes.scene import Scene, SceneSource, load_scene
from crane_sim.simulation.goals import follows_path, target_position
from crane_sim.trajectories.trajectory import sample_trajectory

Array = npt.NDArray[np.float64]
DEFAULT_SCENES: dict[str, tuple[str, dict[str, Any]]] = {
    "overhead": ("overhead_energy", {"actuators.trolley.limit": 60.0}),
    "bridge": (
        "bridge_speed_drive",
        {"control": None, "reference.q": [0.0, 3.0, 5.0], "actuators.rope.limit": 0.2},
    ),
    "knuckle": (
        "knuckle_setpoint",
        {"actuators.all.limit": 400.0, "actuators.rope.limit": [-50.0, 0.0]},
    ),
    "pendulum": ("offshore_resonant", {"actuators.all.limit": 2.0}),
    "tower": ("tower_gust", {}),
}
"""Scenes of the catalogue by kind of crane, with the changes that give every command a bound and
the payload a goal."""
# of a sensor's record: what may show a joint beyond its travel limits
SHIFTS = ("noise", "bias", "quantum")
CLOCK = ("duration", "control.period")  # keys that are the same in all episodes
# groups that the seed changes; the rest is noise, drawn while running
SEEDED = ("uncertain", "wind", "base_motion")
MaxEffort = float | Sequence[float]


class Goal(NamedTuple):
    """Where the payload should be: one row for all instants, or one for each.

    The instants are the starts of the periods, and the end.
    """

    position: Array  # (rows, n) m, in the axes of the base
    shown: Array  # (rows, m): the part of the observation that shows it

    def row(self, k: int) -> int:
        """Return the row of instant k."""
        return min(k, len(self.shown) - 1)


def task_scene(scene: SceneSource | None, crane: str) -> Scene:
    """Return the scene, by default the crane's own, that takes its commands from outside.

    Raises:
        SceneError: the scene is invalid, takes no commands, or says nowhere where the payload
            should be.
    """
    source, changes = DEFAULT_SCENES[crane] if scene is None else (scene, None)
    loaded = load_scene(source, changes, own_law=False).with_external_commands()
    drawn = loaded.document.get("uncertain") or {}
    if clock := next((key for key in CLOCK if key in drawn), None):
        raise SceneError(
            f"scene {loaded.name}: uncertain.{clock}: all episodes of an environment have one time"
        )
    if not loaded.actuated:
        raise SceneError(f"scene {loaded.name}: has no joint that takes commands")
    if loaded.reference is None and not follows_path(loaded):
        missing = "has neither a target (reference.q) nor a path of the payload"
        raise SceneError(f"scene {loaded.name}: {missing}: nothing to measure the reward from")
    return loaded


def with_seed(scene: Scene, seed: int) -> Scene:
    """Return the scene with another seed, as `load_scene` would.

    It is faster where the seed draws nothing but noise.

    Raises:
        SceneError: the seed draws a crane with other joints, which has no place in an environment's
            spaces.
    """
    if seed == scene.seed:
        return scene
    if any(scene.document.get(group) for group in SEEDED):
        other = load_scene(scene, {"seed": seed}, own_law=False).with_external_commands()
        if other.joint_names != scene.joint_names:
            joints = f"{len(other.joint_names)} joints ({shorten(', '.join(other.joint_names))})"
            line = (
                f"seed = {seed}: draws a crane of {joints}, that of the environment has "
                f"{len(scene.joint_names)}"
            )
            raise SceneError(f"{line}; give the scene one model, such as cable.model")
        return other
    return replace(scene, seed=seed, document={**scene.document, "seed": seed})


def goal_of(scene: Scene) -> Goal:
    """Return the goal of the payload: the scene's path, or else its rest at the target."""
    if not follows_path(scene):
        return Goal(target_position(scene), np.array([scene.reference]))
    t = np.arange(scene.steps + 1) * scene.period
    path = sample_trajectory(scene.trajectory, t)
    return Goal(path[:, 0], np.concatenate([path[:, 0], path[:, 1]], axis=1))


def distance_from(wanted: Array, payload: Array) -> Array:
    """Return the distances (K,) [m] of payloads (K, 3) from goals (K, n), in base axes.

    Term by term, so that K changes no bit.
    """
    total = np.zeros(len(wanted))
    for goal, position in zip(wanted.T, payload.T, strict=False):
        total += (position - goal) * (position - goal)
    return np.sqrt(total)


def observation_names(scene: Scene) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Return (names, units) of an observation: positions, velocities, and the goal.

    The goal are the targets of the actuated joints, or position and velocity of the path.
    """
    rates = tuple("1/s" if unit == "1" else f"{unit}/s" for unit in scene.joint_units)
    names = (*scene.joint_names, *(f"{name} velocity" for name in scene.joint_names))
    if follows_path(scene):
        axes = "xyz"[: goal_of(scene).position.shape[1]]
        shown, units = (
            (*(f"path {a}" for a in axes), *(f"path {a} velocity" for a in axes)),
            ("m", "m/s"),
        )
        return (*names, *shown), (
            *scene.joint_units,
            *rates,
            *(unit for unit in units for _ in axes),
        )
    own = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    targets = tuple(f"target {name}" for name in scene.actuated)
    return (*names, *targets), (*scene.joint_units, *rates, *(own[name] for name in scene.actuated))


def observation_space(scene: Scene) -> Space[Array]:
    """Return the space of observations: the travel limits, unless sensors shift values."""
    names = observation_names(scene)[0]
    low, high = np.full(len(names), -inf), np.full(len(names), inf)
    for limit in scene.limits:
        i = scene.joint_names.index(limit.joint)
        exact = scene.hardware is None or not any(scene.hardware.sensors[key][i] for key in SHIFTS)
        if exact:
            low[i], high[i] = limit.low, limit.high
        if not follows_path(scene) and limit.joint in scene.actuated:
            k = 2 * len(scene.joint_names) + scene.actuated.index(limit.joint)
            low[k], high[k] = limit.low, limit.high
    return cast("Space[Array]", Box(low, high, dtype=np.float64))


def action_space(scene: Scene, max_effort: MaxEffort | None) -> Space[Array]:
    """Return the space of commands (nu,) in their units: the scene's bounds, or ±`max_effort`.

    Raises:
        SceneError: a bound is missing, or `max_effort` is no bound.
    """
    low, high = command_bounds(scene)
    unbounded = ~(np.isfinite(low) & np.isfinite(high))
    names = ", ".join(
        name for name, missing in zip(scene.actuated, unbounded, strict=True) if missing
    )
    if max_effort is None and names:
        remedy = (
            "give one bound, or one for each joint, in the units of the commands, or "
            "actuators.JOINT.limit"
        )
        raise SceneError(
            f"max_effort: is missing, scene {scene.name} bounds no commands of {names}; {remedy}"
        )
    if max_effort is not None:
        bound = _checked_bound(scene, max_effort)
        low, high = np.where(unbounded, -bound, low), np.where(unbounded, bound, high)
    return cast("Space[Array]", Box(low, high, dtype=np.float64))


def _checked_bound(scene: Scene, max_effort: MaxEffort) -> Array:
    """Return the bounds (nu,) of the commands."""
    line = f"max_effort = {shorten(max_effort)}: must be a number greater than 0"
    try:
        bound = np.array(max_effort, dtype=np.float64)
    except (TypeError, ValueError):
        raise SceneError(f"{line}, or one for each of {', '.join(scene.actuated)}") from None
    if bound.shape not in ((), (len(scene.actuated),)) or not np.all(
        np.isfinite(bound) & (bound > 0.0)
    ):
        raise SceneError(f"{line}, or one for each of {', '.join(scene.actuated)}")
    return np.broadcast_to(bound, len(scene.actuated))


def command_bounds(scene: Scene) -> tuple[Array, Array]:
    """Return the scene's bounds of the commands (nu,), infinite where it has none.

    They are the limit of an effort and the largest effort of its motor, the largest speed of a
    drive by speed, and the travel limits of a drive by position.
    """
    low, high = np.full(len(scene.actuated), -inf), np.full(len(scene.actuated), inf)
    if scene.hardware is None:
        return low, high
    limits = {limit.joint: limit for limit in scene.limits}
    for i, (name, kind) in enumerate(zip(scene.actuated, scene.commands, strict=True)):
        if kind == "effort":
            drive = scene.hardware.drives[i]
            low[i], high[i] = max(drive["low"], -drive["peak"]), min(drive["high"], drive["peak"])
        elif kind == "velocity":
            speed = scene.hardware.servos["max_speed"][i]
            low[i], high[i] = -speed, speed
        elif name in limits:
            low[i], high[i] = limits[name].low, limits[name].high
    return low, high
