"""The runs of cranebench's campaigns on our own crane, and the metrics that its campaigns compare.

The crane is a scene: trolley and winch by force, each with viscous friction, one link damped at its top, a payload that
the wind presses on by relative velocity. A sample's record of the wind, on a grid of 100 Hz, becomes the gusts.
"""

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.speed.campaign_laws import DISTANCE, DURATION, PERIOD, DampedLaw, make_campaign_law
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.columns import make_driven, stack_columns
from crane_sim.stepping.batch import BatchArrays, TimeGrid, simulate_range
from crane_sim.stepping.periods import Sampled
from crane_sim.stepping.rows import row_width, split
from crane_sim.trajectories.wind import Gust

Array = npt.NDArray[np.float64]

# The numbers are those of cranebench 0.1.2, of its planar plant.
STEP = 0.002  # s, of integration and of the samples that metrics are computed from
END, TAIL = 40.0, 5.0  # s, of a run, and of its end, where residual swing and final error are taken
TOLERANCE = 0.02  # m, of the trolley's position, by which it has settled
TROLLEY_DAMPING, HOIST_DAMPING, SWING_DAMPING = 250.0, 120.0, 40.0  # N s/m, N s/m, N m s/rad
ROPE, PAYLOAD, WIND = 12.0, 4000.0, 12.0  # m, kg, m/s
SCENE: dict[str, Any] = {
    "crane": "overhead",
    "duration": END,
    "gravity": 9.80665,
    "trolley": {"drive": "force", "mass": 1500.0},
    "hoist": {"drive": "force", "inertia": 300.0},
    "cable": {"lengths": [ROPE], "node_masses": [PAYLOAD]},
    "joints": {"damping": [SWING_DAMPING]},
    "integrator": {"method": "rk4", "step": STEP},
}
WINDAGE = {"area": 6.0, "drag_coefficient": 1.2}
GRID = 100.0  # 1/s, of the records of the wind
CHUNK = 10  # runs at a time for each thread: bounds the memory of their samples


class CampaignSample(NamedTuple):
    """One of the cranes that all laws move."""

    payload: float  # kg
    rope: float  # m
    swing_damping: float  # N m s/rad
    trolley_damping: float  # N s/m
    wind: float  # m/s, mean
    turbulence: Array | None  # (n,) m/s, deviations from the mean; None: calm


def calm_scene(sample: CampaignSample) -> Scene:
    """Return the crane of a sample without wind."""
    return load_scene(
        SCENE,
        {
            "cable.node_masses": [sample.payload],
            "cable.lengths": [sample.rope],
            "joints.damping": [sample.swing_damping],
        },
    )


def windy_scene(sample: CampaignSample, calm: Scene) -> Scene:
    """Return the crane of a sample in its wind; the calm one where it has none."""
    if sample.turbulence is None:
        return calm
    scene = load_scene(calm, {"wind": {"speed": sample.wind}, "payload": {"mass": sample.payload, "windage": WINDAGE}})
    nodes = np.zeros((len(sample.turbulence), 3))
    nodes[:, 0] = sample.turbulence
    nodes[1:-1, 1] = 0.5 * (sample.turbulence[2:] - sample.turbulence[:-2])
    wind = scene.model.wind._replace(gusts=(Gust(GRID, nodes), None, None))
    return replace(scene, model=scene.model._replace(wind=wind))


def make_scenes(samples: Sequence[CampaignSample], law: str) -> list[Scene]:
    """Return the scenes of all samples under one of the laws."""
    scenes = list[Scene]()
    for sample in samples:
        calm = calm_scene(sample)
        scene = windy_scene(sample, calm)
        damping = sample.trolley_damping, HOIST_DAMPING
        source = Sampled(DampedLaw(make_campaign_law(law, calm, damping), damping))
        scenes.append(replace(scene, source=source, sampled=False, law_name=law, period=PERIOD))
    return scenes


def run_scenes(scenes: Sequence[Scene]) -> dict[str, Array]:
    """Return the metrics (n,) of scenes by name, computed on all cores."""
    chunks = [scenes[i : i + CHUNK] for i in range(0, len(scenes), CHUNK)]
    with ThreadPoolExecutor(len(os.sched_getaffinity(0))) as pool:
        parts = list(pool.map(_campaign_metrics, chunks))
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _campaign_metrics(scenes: Sequence[Scene]) -> dict[str, Array]:
    times, q, _, u = trajectories(scenes)
    return compute_metrics(times, q, u)


def trajectories(scenes: Sequence[Scene]) -> tuple[Array, Array, Array, Array]:
    """Return (sample times (m,), positions (n, m, 3), velocities (n, m, 3), efforts (n, m, 2)) of scenes of one kind.

    Raises:
        RuntimeError: a run ended early.
    """
    first, n = scenes[0], len(scenes)
    times = np.asarray(STEP * np.arange(round(first.duration / STEP) + 1), np.float64)
    grid, nq = TimeGrid(first.period, first.steps, times), len(first.joint_names)
    rows = np.empty((n, len(times) + 1, row_width(first.model, nq, len(first.actuated))))
    q, v = (np.array([getattr(scene, name) for scene in scenes]) for name in ("initial_q", "initial_v"))
    counts = np.empty((n, 6), np.int64)
    arrays = BatchArrays(q, v, rows, np.empty((n, len(times) + 1, 3)), np.empty(n), counts)
    simulate_range(stack_columns([make_driven(scene) for scene in scenes]), grid, arrays, 0, n)
    if np.any(counts[:, 1] != first.steps):
        raise RuntimeError(f"{first.law_name}: run {int(np.argmax(counts[:, 1] != first.steps))} ended early")
    parts = [split(run[:-1], nq, len(first.actuated)) for run in rows]
    positions, velocities, efforts = (np.array([getattr(part, name) for part in parts]) for name in ("q", "v", "u"))
    damping = np.array([scene.source.law.damping for scene in scenes])
    return times, positions, velocities, efforts + damping[:, None] * velocities[..., :2]  # the commands that are held


def reference_positions(times: Array) -> Array:
    """Return the positions (m,) [m] of the transfer, without delays."""
    s = np.clip(times / DURATION, 0.0, 1.0)
    return DISTANCE * s**3 * (10.0 + s * (6.0 * s - 15.0))


def compute_metrics(times: Array, q: Array, u: Array) -> dict[str, Array]:
    """Return cranebench's metrics (n,), by its names, of the `trajectories` of n runs."""
    error, swing, effort = np.abs(q[..., 0] - reference_positions(times)), np.degrees(q[..., 2]), u[..., 0]
    tail, outside = times >= times[-1] - TAIL, error >= TOLERANCE
    last = len(times) - 1 - np.argmax(outside[:, ::-1], axis=1)  # outside; any number where it never is
    settled = np.where(outside.any(axis=1), times[np.minimum(last + 1, len(times) - 1)], 0.0)
    metrics = {
        "ise_pos": np.trapezoid(error**2, times, axis=1),
        "settle_time": settled,
        "peak_swing": np.abs(swing).max(axis=1),
        "rms_swing": np.sqrt(np.mean(swing**2, axis=1)),
        "residual_swing": np.sqrt(np.mean(swing[:, tail] ** 2, axis=1)),
        "effort": np.trapezoid(effort**2, times, axis=1),
        "peak_input": np.abs(effort).max(axis=1),
        "chatter": np.abs(np.diff(effort, axis=1)).sum(axis=1),
        "final_pos_err": error[:, tail].mean(axis=1),
    }
    return {name: np.asarray(values, np.float64) for name, values in metrics.items()}
