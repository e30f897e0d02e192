"""The catalogue's hard cases beside references from extended precision: error, evaluations, time.

A reference says how far it is to be trusted; a case holds when all nodes are within max(1e-9 m, ten times that) at
every instant, or within the case's own bound where the model itself leaves something out or the motion is chaotic.
"""

import json
import time
from typing import Any, NamedTuple

import numpy as np

from crane_sim.files.catalogue import config_folder
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.dynamics import acceleration
from crane_sim.simulation.rollout import Rollout, simulate

LEAST = 1e-9  # m
RELATIVE, DRIFT = 1e-12, 1e-9
BOUNDS = {
    "overhead_heavy": (1e-8, "fast waves of light links, 30 000 rad of them"),
    "overhead_heavy_straight": (1e-8, "payload only: the rod leaves the links' own waves out"),
}
"""Bounds other than the rule's [m], and why."""
PAYLOAD_ONLY = {"overhead_heavy_straight"}
HEAVY, LONG = "N = 30, ratio 1e8", "overhead_long, a million steps"
"""The cases that are not compared with a trajectory."""
MOST = 1_000_000  # steps that the long case has at least


class Case(NamedTuple):
    """One hard case, measured now."""

    case: str
    measure: str  # what the error is of
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
    """Return the references by scene: instants t (K,), nodes (K, N, 3) [m], trusted [m], events [s]."""
    return read_references("hardcases")


def measure_case(scene: str, reference: dict[str, Any]) -> Case:
    """Run one case, twice so that nothing is compiled in the second."""
    loaded, t = load_scene(scene), np.array(reference["t"])
    simulate(loaded, sample_times=t)
    run = simulate(loaded, sample_times=t)
    bound, _ = BOUNDS.get(scene, (max(LEAST, 10.0 * reference["trusted"]), ""))
    error, late = largest_distance(run, reference, scene), lateness(run, reference)
    holds = error <= bound and (late is None or late <= LEAST)
    method, stats = type(loaded.method).__name__.lower(), run.stats
    verdict = "holds" if holds else "does not hold"
    return Case(scene, "nodes, m", method, error, bound, late, stats["rhs_evaluations"], stats["wall_time"], verdict)


def largest_distance(run: Rollout, reference: dict[str, Any], scene: str) -> float:
    """Return the largest distance [m] of a run's nodes from the reference's."""
    nodes = np.array(reference["nodes"])
    last = 1 if scene in PAYLOAD_ONLY else nodes.shape[1]
    return float(np.max(np.abs(run.nodes[:, -last:] - nodes[:, -last:])))


def lateness(run: Rollout, reference: dict[str, Any]) -> float | None:
    """Return the largest error [s] of the event times; None without events."""
    if "events" not in reference:
        return None
    expected, measured = np.array(reference["events"]), np.array([t for t, _ in run.events if t > LEAST])
    return float(np.max(np.abs(measured - expected))) if len(measured) == len(expected) else np.inf


def names() -> list[str]:
    """Return the names of all cases, without running any."""
    return [*hardcase_references(), HEAVY, LONG]


def rows() -> list[Case]:
    """Return all hard cases."""
    cases = [measure_case(scene, reference) for scene, reference in hardcase_references().items()]
    return [*cases, heavy_accelerations(), long_energy()]


def heavy_accelerations() -> Case:
    """Return the relative error of accelerations of thirty links below a payload of 1e8 nodes, against 60 digits."""
    known = read_references("accelerations")
    scene, first = load_scene(known["scene"]), known["states"][0]
    acceleration(scene, first["q"], first["v"], first["u"])  # compiles
    started, error = time.perf_counter(), 0.0
    for state in known["states"]:
        expected = np.array(state["acceleration"])
        measured = acceleration(scene, state["q"], state["v"], state["u"])
        error = max(error, float(np.max(np.abs(measured - expected)) / np.max(np.abs(expected))))
    verdict = "holds" if error <= RELATIVE else "does not hold"
    wall, count = time.perf_counter() - started, len(known["states"])
    return Case(HEAVY, "accelerations, relative", "-", error, RELATIVE, None, count, wall, verdict)


def long_energy() -> Case:
    """Return the drift of a double pendulum's energy over a million steps and more, relative to what it swings by."""
    scene = load_scene("overhead_long", {"duration": 10_000.0})
    run = simulate(scene)
    drift = float(np.max(np.abs(run.energy - run.energy[0])) / np.ptp(run.derived.potential))
    verdict = "holds" if drift <= DRIFT and run.stats["steps"] >= MOST else "does not hold"
    method, stats = type(scene.method).__name__.lower(), run.stats
    counted = stats["rhs_evaluations"], stats["wall_time"]
    return Case(LONG, "energy, relative", method, drift, DRIFT, None, *counted, verdict)
