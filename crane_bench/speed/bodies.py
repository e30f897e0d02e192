"""A rigid load beside MuJoCo, speed against error: `crane bench bodies`.

MuJoCo gets the scene's own bodies, joints, falls and inputs (`peers.mechanism`). An error is the
distance at the end of the run of the load's attachment, on falls of its centre of mass, from our
own finest run; beside it stands the angle of the load's attitude.
"""

from collections.abc import Sequence
from typing import Any

from crane_bench.speed import crane_sim_engine
from crane_bench.speed.body_cases import CASES, STEPS, BodyCase, body_scene, make_reference
from crane_bench.speed.cases import ERROR_LEVELS, MIN_TRUST, is_asked
from crane_bench.speed.engine import EngineUnavailable
from crane_bench.speed.measurement import machine
from crane_bench.speed.peers import mujoco_engine
from crane_bench.speed.peers.mechanism import mechanism_of
from crane_bench.speed.results import cheapest_points, read_points
from crane_bench.speed.sweep import WorkPrecisionPoint, measure_points, sweep_method

METHODS = ("rk4", "rk8")
"""Ours, with steps that end at the inputs' kinks: error control does not look for those, and so
gains nothing here."""
PEER_METHODS = ("RK4", "implicitfast")
CANNOT = (
    "Only ours models falls that go slack at an instant (MuJoCo damps slack tendons) and ropes of "
    "prescribed length as",
    "such (MuJoCo has a winch 1e12 times as heavy as what hangs on it). These scenes were freed "
    "from wind that presses",
    "by relative velocity, laws, sensors and drives.",
)
BODY_ERROR_LEVELS = ERROR_LEVELS[:4]  # m: these references are too coarse for the finest


def measure_bodies(
    cases: Sequence[BodyCase] = CASES, methods: Sequence[str] = METHODS
) -> dict[str, Any]:
    """Return the points of all engines on each case; `methods` of this simulator."""
    versions, missing = {crane_sim_engine.NAME: crane_sim_engine.VERSION}, {}
    try:
        versions[mujoco_engine.NAME] = mujoco_engine.find_version()
    except EngineUnavailable as reason:
        missing[mujoco_engine.NAME] = str(reason)
    scenes = {case.id: measure_case(case, methods, not missing) for case in cases}
    return {"engines": versions, "missing": missing, "scenes": scenes, "machine": machine()}


def measure_case(case: BodyCase, methods: Sequence[str], peer: bool) -> dict[str, Any]:
    """Return the points of one case, of this simulator's methods; `peer`: of MuJoCo's, too."""
    scene = body_scene(case)
    simulator, mechanism = crane_sim_engine.CraneSimEngine(scene), mechanism_of(scene)
    assert mechanism is not None
    reference, attitude_bound = make_reference(simulator)
    trials = {
        crane_sim_engine.NAME: [
            trial
            for method in methods
            for trial in sweep_method(simulator.runs(method, STEPS), reference)
        ]
    }
    if peer:
        sweeps = (mujoco_engine.runs(mechanism, method) for method in PEER_METHODS)
        trials[mujoco_engine.NAME] = [
            trial for runs in sweeps for trial in sweep_method(runs, reference)
        ]
    points = measure_points(trials, scene.duration, lambda line: None)
    head = {"scene": case.scene, "title": case.title, "duration": scene.duration}
    bounds = {"trusted": reference.error_bound, "attitude_trusted": attitude_bound}
    return head | bounds | {"points": [list(point) for point in points]}


def format_bodies(results: dict[str, Any]) -> list[str]:
    """Return the cheapest run of every engine at every error, and the closest one of all."""
    lines = [f"not there: {name} ({why})" for name, why in results["missing"].items()]
    lines.append(", ".join(f"{name} {version}" for name, version in results["engines"].items()))
    for case, scene in results["scenes"].items():
        trusted = f"reference within {scene['trusted']:.0e} m, {scene['attitude_trusted']:.0e} rad"
        lines.append(
            f"{case}: {scene['title']} ({scene['scene']}), {scene['duration']:g} s; {trusted}"
        )
        coarse = [
            f"{level:.0e} m" for level in BODY_ERROR_LEVELS if not is_asked(level, scene["trusted"])
        ]
        reason = f"below {MIN_TRUST:g} times the reference's error"
        lines += [f"  not compared, {reason}: {', '.join(coarse)}"] * bool(coarse)
        lines += _describe_engines(scene)
    return [*lines, *CANNOT]


def _describe_engines(scene: dict[str, Any]) -> list[str]:
    """Return the lines of all engines on a scene."""
    points, levels = (
        read_points(scene),
        [i for i, e in enumerate(BODY_ERROR_LEVELS) if is_asked(e, scene["trusted"])],
    )
    found, lines = cheapest_points(points, scene["trusted"]), list[str]()
    ours = found[crane_sim_engine.NAME]
    for engine, cheapest in found.items():
        lines += [f"  {engine:<10} {line}" for line in _describe_levels(levels, cheapest, ours)]
        closest = min((p for p in points if p.engine == engine), key=lambda p: p.error)
        errors = (
            _errors(closest) if closest.error > scene["trusted"] else "within the reference's error"
        )
        lines.append(f"  {engine:<10} closest: {errors}, {closest.method} {closest.setting:.2g}")
    return lines


def _describe_levels(
    compared: Sequence[int],
    cheapest: Sequence[WorkPrecisionPoint | None],
    ours: Sequence[WorkPrecisionPoint | None],
) -> list[str]:
    """Return a line for each run that is cheapest at some errors, with the range of these."""
    rows = dict[WorkPrecisionPoint | None, list[int]]()
    for i in compared:
        rows.setdefault(cheapest[i], []).append(i)
    lines = list[str]()
    for point, levels in rows.items():
        span = " to ".join(f"{BODY_ERROR_LEVELS[i]:.0e}" for i in sorted({levels[0], levels[-1]}))
        lines.append(f"{span:>14} m {_describe(point, [ours[i] for i in levels])}")
    return lines


def _describe(point: WorkPrecisionPoint | None, ours: Sequence[WorkPrecisionPoint | None]) -> str:
    if point is None:
        return "is not reached"
    times = [own.us_per_s for own in ours if own is not None]
    ratios = " to ".join(
        f"{ratio:.3g}" for ratio in sorted({point.us_per_s / time for time in times})
    )
    ratio_text = f"{ratios} x ours" if ratios else "ours does not reach it"
    run = f"{_errors(point)}, {point.method} {point.setting:.2g}"
    return f"{point.us_per_s:8.1f} µs per simulated second, {ratio_text}; {run}"


def _errors(point: WorkPrecisionPoint) -> str:
    angle = f", {point.attitude_error:.0e} rad" if point.attitude_error is not None else ""
    return f"{point.error:.0e} m{angle}"
