"""Speed against error on every scene of the benchmark, this simulator beside its peers."""

import time
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from crane_bench.speed import crane_sim_engine
from crane_bench.speed.cases import CASES, Case, ReferenceSolution, case_scene, reference_of
from crane_bench.speed.engine import Engine, EngineUnavailable, Run
from crane_bench.speed.measurement import machine
from crane_bench.speed.peers import engines
from crane_bench.speed.problem import problem_of
from crane_bench.speed.sweep import Trial, measure_points, sweep_method
from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.simulation.derived import world_points

ProgressCallback = Callable[[str], Any]
QUICK, QUICK_METHODS = ("S1", "S2k", "S3a", "S5"), ("rk4", "rk8", "dop853")
"""Scenes and methods of `--quick`."""


def select_cases(ids: Sequence[str], quick: bool) -> list[Case]:
    """Return the cases with these ids or scene names; without ids all, or those of `--quick`.

    Raises:
        SceneError: there is no such case.
    """
    known = {case.id: case for case in CASES} | {case.scene: case for case in CASES}
    for name in ids:
        if name not in known:
            raise SceneError(unknown_key(name, [case.id for case in CASES], "--scene"))
    return [known[name] for name in ids or (QUICK if quick else [case.id for case in CASES])]


def measure_scenes(
    cases: Sequence[Case], methods: Sequence[str], peers: bool, on_progress: ProgressCallback
) -> dict[str, Any]:
    """Return machine, engines, and by id of a case its points and its refused engines.

    Args:
        cases: to measure.
        methods: of this simulator; all when empty.
        peers: measure every installed engine, not only the hand-written C.
        on_progress: called with a line at each step.

    Raises:
        SceneError: there is no such method.
    """
    for name in methods:
        if name not in crane_sim_engine.METHODS:
            raise SceneError(unknown_key(name, crane_sim_engine.METHODS, "--method"))
    peer_engines, missing = engines(peers)
    versions = {crane_sim_engine.NAME: crane_sim_engine.VERSION} | {
        engine.name: engine.version for engine in peer_engines
    }
    cannot = {engine.name: engine.unsupported_scenes for engine in peer_engines}
    date = time.strftime("%Y-%m-%d")
    scenes = {case.id: _scene(case, methods, peer_engines, on_progress) for case in cases}
    head = {
        "date": date,
        "machine": machine(),
        "engines": versions,
        "missing": missing,
        "cannot": cannot,
    }
    return head | {"scenes": scenes}


def _scene(
    case: Case, methods: Sequence[str], peers: Sequence[Engine], on_progress: ProgressCallback
) -> dict[str, Any]:
    scene, reference = case_scene(case), reference_of(case)
    simulator, trials, refused = crane_sim_engine.CraneSimEngine(scene), {}, {}
    trials[crane_sim_engine.NAME] = []
    for method in _select_methods(case, simulator, methods):
        on_progress(f"{case.id}: {crane_sim_engine.NAME}, {method}")
        trials[crane_sim_engine.NAME] += sweep_method(simulator.runs(method), reference)
    for engine in peers if case.compare_engines else ():
        on_progress(f"{case.id}: {engine.name}")
        try:
            trials[engine.name] = _peer(engine, simulator, reference)
        except EngineUnavailable as reason:
            refused[engine.name] = str(reason)
        except Exception as reason:  # a failing peer loses its own row only
            refused[engine.name] = f"failed: {type(reason).__name__}: {reason}".partition("\n")[0]
    points = measure_points(trials, scene.duration, lambda line: on_progress(f"{case.id}: {line}"))
    head = {
        "scene": case.scene,
        "title": case.title,
        "duration": scene.duration,
        "trusted": reference.error_bound,
        "date": time.strftime("%Y-%m-%d"),
    }
    rows = [list(point) for point in points]
    return head | {"compiling_s": simulator.compile_times, "refused": refused, "points": rows}


def _select_methods(
    case: Case, simulator: crane_sim_engine.CraneSimEngine, methods: Sequence[str]
) -> list[str]:
    """Return the methods that fit a case, of `methods` if there are any.

    Raises:
        SceneError: none of `methods` fits.
    """
    possible = simulator.methods()
    selected = [method for method in possible if not methods or method in methods]
    if methods and not selected:
        raise SceneError(
            f"--method {methods[0]}: does not fit {case.id}; possible: {', '.join(possible)}"
        )
    return selected


def _peer(
    engine: Engine, simulator: crane_sim_engine.CraneSimEngine, reference: ReferenceSolution
) -> list[Trial]:
    """Return the trials of a peer.

    Raises:
        EngineUnavailable: it cannot model the scene, or lacks a dependency.
    """
    points, _ = world_points(simulator.p, 0.0, simulator.q, simulator.v)
    problem = problem_of(simulator.scene, np.array(points[-1]))
    if problem is None:
        raise EngineUnavailable("no plain description of this scene")
    if reason := engine.unsupported_reason(problem):
        raise EngineUnavailable(reason)
    by_method: dict[str, list[Run]] = {}
    for run in engine.runs(problem):
        by_method.setdefault(run.method, []).append(run)
    return [trial for runs in by_method.values() for trial in sweep_method(runs, reference)]
