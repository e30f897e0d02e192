"""The catalogue's hard cases against references from extended precision: error, evaluations, time.

A reference has an estimate of its own error, `trusted`; a case holds when all nodes are within
max(1e-9 m, ten times that) at every instant, or within the case's own bound where the model is an
approximation or the motion is chaotic.
"""

import json
import time
from typing import Any, NamedTuple

import numpy as np

from crane_sim.files.catalogue import config_folder
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.dynamics import acceleration
from crane_sim.simulation.rollout import Rollout, simulate

MIN_BOUND = 1e-9  # m, of positions; s, of event times
MAX_ACCELERATION_ERROR, MAX_ENERGY_DRIFT = 1e-12, 1e-9
BOUNDS = {
    "overhead_heavy": (1e-8, "fast waves of light links, 30 000 rad of them"),
    "overhead_heavy_straight": (1e-8, "payload only: the rod has no waves of the links"),
}
"""Bounds [m] in place of the general one, and why."""
PAYLOAD_ONLY = {"overhead_heavy_straight"}
HEAVY_PAYLOAD, LONG_RUN = "N = 30, ratio 1e8", "overhead_long, a million steps"
"""The cases that are not compared with a trajectory."""
MIN_STEPS = 1_000_000  # of the long case


class HardCase(NamedTuple):
    """One hard case, measured."""

    case: str
    measure: str  # quantity of the error
    method: str
    error: float
    bound: float
    events: float | None  # s, error of the event times
    evaluations: int
    time: float  # s of wall time, without compilation
    verdict: str

    VARIES = ("time",)  # columns that differ from run to run


def read_references(name: str) -> dict[str, Any]:
    """Return a file of references."""
    return json.loads((config_folder() / "references" / f"{name}.json").read_text())


def hardcase_references() -> dict[str, Any]:
    """Return references by scene: t (K,), nodes (K, N, 3) [m], trusted [m], events [s]."""
    return read_references("hardcases")


def measure_case(scene: str, reference: dict[str, Any]) -> HardCase:
    """Run one case, twice so that nothing is compiled in the second."""
    loaded, t = load_scene(scene), np.array(reference["t"])
    simulate(loaded, sample_times=t)
    run = simulate(loaded, sample_times=t)
    bound, _ = BOUNDS.get(scene, (max(MIN_BOUND, 10.0 * reference["trusted"]), ""))
    error, time_error = largest_distance(run, reference, scene), event_time_error(run, reference)
    holds = error <= bound and (time_error is None or time_error <= MIN_BOUND)
    method, stats = type(loaded.method).__name__.lower(), run.stats
    verdict = "holds" if holds else "does not hold"
    return HardCase(
        scene,
        "nodes, m",
        method,
        error,
        bound,
        time_error,
        stats["rhs_evaluations"],
        stats["wall_time"],
        verdict,
    )


def largest_distance(run: Rollout, reference: dict[str, Any], scene: str) -> float:
    """Return the largest distance [m] of a run's nodes from the reference's."""
    nodes = np.array(reference["nodes"])
    last = 1 if scene in PAYLOAD_ONLY else nodes.shape[1]
    return float(np.max(np.abs(run.nodes[:, -last:] - nodes[:, -last:])))


def event_time_error(run: Rollout, reference: dict[str, Any]) -> float | None:
    """Return the largest error [s] of the event times; None without events."""
    if "events" not in reference:
        return None
    expected, measured = (
        np.array(reference["events"]),
        np.array([t for t, _ in run.events if t > MIN_BOUND]),
    )
    return float(np.max(np.abs(measured - expected))) if len(measured) == len(expected) else np.inf


def name_hard_cases() -> list[str]:
    """Return the names of all cases, without running any."""
    return [*hardcase_references(), HEAVY_PAYLOAD, LONG_RUN]


def measure_hard_cases() -> list[HardCase]:
    """Return all hard cases."""
    cases = [measure_case(scene, reference) for scene, reference in hardcase_references().items()]
    return [*cases, heavy_accelerations(), long_energy()]


def heavy_accelerations() -> HardCase:
    """Return the relative error of thirty links' accelerations against 60 digits.

    The payload is 1e8 times a node's mass.
    """
    data = read_references("accelerations")
    scene, first = load_scene(data["scene"]), data["states"][0]
    acceleration(scene, first["q"], first["v"], first["u"])  # compiles
    started, error = time.perf_counter(), 0.0
    for state in data["states"]:
        expected = np.array(state["acceleration"])
        measured = acceleration(scene, state["q"], state["v"], state["u"])
        error = max(error, float(np.max(np.abs(measured - expected)) / np.max(np.abs(expected))))
    verdict = "holds" if error <= MAX_ACCELERATION_ERROR else "does not hold"
    wall, count = time.perf_counter() - started, len(data["states"])
    return HardCase(
        HEAVY_PAYLOAD,
        "accelerations, relative",
        "-",
        error,
        MAX_ACCELERATION_ERROR,
        None,
        count,
        wall,
        verdict,
    )


def long_energy() -> HardCase:
    """Return the drift of a double pendulum's energy over its potential's range.

    The run has at least a million steps.
    """
    scene = load_scene("overhead_long", {"duration": 10_000.0})
    run = simulate(scene)
    drift = float(np.max(np.abs(run.energy - run.energy[0])) / np.ptp(run.derived.potential))
    verdict = (
        "holds"
        if drift <= MAX_ENERGY_DRIFT and run.stats["steps"] >= MIN_STEPS
        else "does not hold"
    )
    method, stats = type(scene.method).__name__.lower(), run.stats
    counted = stats["rhs_evaluations"], stats["wall_time"]
    return HardCase(
        LONG_RUN, "energy, relative", method, drift, MAX_ENERGY_DRIFT, None, *counted, verdict
    )
