"""The catalogue's hard cases beside references from extended precision: error, evaluations, time.

A reference says how far it is to be trusted; a case holds when all nodes are within max(1e-9 m, ten times that) at every
instant, or within the case's own bound where the model itself leaves something out or the motion is chaotic.
"""

import json
from typing import Any, NamedTuple

import numpy as np

from crane_sim.catalogue import config_folder
from crane_sim.rollout import Rollout, simulate
from crane_sim.scene import load_scene

LEAST = 1e-9  # m
BOUNDS = {
    "overhead_heavy": (1e-8, "fast waves of light links, 30 000 rad of them"),
    "overhead_heavy_straight": (1e-8, "payload only: the rod leaves the links' own waves out"),
    "overhead_toss_chain": (1e-8, "until the first link is taut again, after which it is chaotic"),
}
"""Bounds other than the rule's [m], and why."""
PAYLOAD_ONLY = {"overhead_heavy_straight"}


class Case(NamedTuple):
    """One hard case, measured now."""

    case: str
    method: str
    error: float  # m, of the nodes
    bound: float  # m
    events: float | None  # s, error of the event times
    evaluations: int
    time: float  # s of wall time, without compilation
    verdict: str


def references() -> dict[str, Any]:
    """Return the references by scene: instants t (K,), nodes (K, N, 3) [m], trusted [m], events [s]."""
    return json.loads((config_folder() / "references" / "hardcases.json").read_text())


def measured(scene: str, reference: dict[str, Any]) -> Case:
    """Run one case, twice so that nothing is compiled in the second."""
    loaded, t = load_scene(scene), np.array(reference["t"])
    simulate(loaded, sample_times=t)
    run = simulate(loaded, sample_times=t)
    bound, _ = BOUNDS.get(scene, (max(LEAST, 10.0 * reference["trusted"]), ""))
    error, late = apart(run, reference, scene), lateness(run, reference)
    holds = error <= bound and (late is None or late <= LEAST)
    method, stats = type(loaded.method).__name__.lower(), run.stats
    verdict = "holds" if holds else "does not hold"
    return Case(scene, method, error, bound, late, stats["rhs_evaluations"], stats["wall_time"], verdict)


def apart(run: Rollout, reference: dict[str, Any], scene: str) -> float:
    """Return the largest distance [m] of a run's nodes from the reference's, up to a first re-tensioning."""
    nodes = np.array(reference["nodes"])
    last = 1 if scene in PAYLOAD_ONLY else nodes.shape[1]
    valid = run.t <= again_taut(run) if scene == "overhead_toss_chain" else np.full(len(run.t), True)
    return float(np.max(np.abs(run.nodes[valid, -last:] - nodes[valid, -last:])))


def again_taut(run: Rollout) -> float:
    """Return when a slack link was taut again for the first time [s]; the end of the run if none was."""
    return next((t for t, what in run.events if "taut" in what), np.inf)


def lateness(run: Rollout, reference: dict[str, Any]) -> float | None:
    """Return the largest error [s] of the event times, up to a first re-tensioning; None without events."""
    if "events" not in reference:
        return None
    expected = np.array(reference["events"])
    expected = expected[expected <= again_taut(run) + LEAST]
    found = np.array([t for t, _ in run.events if t > LEAST])[: len(expected)]
    return float(np.max(np.abs(found - expected))) if len(found) == len(expected) else np.inf


def rows() -> list[Case]:
    """Return all hard cases."""
    return [measured(scene, reference) for scene, reference in references().items()]
