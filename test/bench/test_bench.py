"""The benchmark: cases, sweeps, targets, and its files."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from click.testing import CliRunner

from crane_bench.cli.bench import bench
from crane_bench.speed.cases import CASES, ERROR_LEVELS, case_scene, is_asked, reference_of
from crane_bench.speed.crane_sim_engine import NAME, CraneSimEngine
from crane_bench.speed.engine import Run, RunResult
from crane_bench.speed.page import format_page
from crane_bench.speed.results import Target, cheapest_points, read_points, targets
from crane_bench.speed.store import merge_suite, read_store, round_floats, write_store
from crane_bench.speed.sweep import (
    WorkPrecisionPoint,
    cheapest,
    measure_points,
    run_trial,
    select_candidates,
    sweep_method,
)
from crane_sim.files.errors import SceneError

REFERENCE = reference_of(CASES[0])._replace(payload=np.zeros(3), error_bound=0.0)


def point(engine: str, error: float, time: float) -> WorkPrecisionPoint:
    """Return a point with this engine, error [m] and time [µs/s], other fields arbitrary."""
    return WorkPrecisionPoint(engine, "rk4", 0.01, error, None, time, time, 3, 4, 1)


def run(error: float, setting: float = 0.1) -> Run:
    """Return a run whose payload ends `error` [m] from the origin."""
    return Run(
        "toy",
        "rk4",
        setting,
        lambda repetitions: RunResult(np.array([error, 0.0, 0.0]), 4 * repetitions, repetitions),
    )


def test_every_case_has_a_reference_at_the_end_of_its_scene() -> None:
    """References belong to the scenes' own ends and tell all errors.

    The finest level is asked of the cases in which engines are compared.

    Doubles do not reach the finest on S4, whose rounding is magnified by its ratio of masses.
    """
    from crane_bench.reproduce.hardcases import hardcase_references

    for case in CASES:
        assert hardcase_references()[case.scene]["t"][-1] == pytest.approx(
            case_scene(case).duration, abs=1e-12
        )
        error_bound = reference_of(case).error_bound
        assert is_asked(ERROR_LEVELS[-2], error_bound)
        assert (
            is_asked(ERROR_LEVELS[-1], error_bound) or not case.compare_engines or case.id == "S4"
        )


@pytest.mark.parametrize("name", ["overhead", "knuckle_springs"])
def test_references_that_decide_agree_with_a_second_method(name: str) -> None:
    """Taylor's method in extended precision agrees with stored solutions within their errors.

    These are those of a solution's own two settings.
    """
    checked = 0
    for case in json.loads(
        (Path(__file__).parents[1] / "data" / f"{name}.json").read_text()
    ).values():
        if "agreement_taylor_m" in case:
            # of the solution's own two settings
            assert case["agreement_taylor_m"] <= case["agreement_m"]
            checked += 1
    assert checked == (5 if name == "overhead" else 1)


@pytest.mark.parametrize(
    ("method", "order", "finest", "coarsest"), [("rk4", 4, 1e-3, 6e-3), ("rk8", 8, 0.03, 0.12)]
)
def test_our_runs_converge_at_their_order(
    method: str, order: int, finest: float, coarsest: float
) -> None:
    """On S1 the error falls by the method's order, and evaluations are stages times steps."""
    runs = [
        r
        for r in CraneSimEngine(case_scene(CASES[0])).runs(method)
        if finest < r.setting < coarsest
    ]
    trials = [run_trial(r, reference_of(CASES[0])) for r in runs]
    steps = [10.0 / (t.steps or 1) for t in trials]
    slope = np.polyfit(np.log(steps), np.log([t.error for t in trials]), 1)[0]
    # at a swing of 60° and these steps the order is not yet exact
    assert slope == pytest.approx(order, abs=0.5)
    assert all(t.evaluations == (12 if method == "rk8" else 4) * (t.steps or 0) for t in trials)


def test_a_sweep_ends_at_the_accuracy_of_its_reference() -> None:
    """Once a run is as good as its reference allows, finer ones are skipped; failures stay."""
    results = sweep_method([run(np.nan), run(1e-3), run(0.0), run(0.0)], REFERENCE)
    assert [t.error for t in results] == [np.inf, 1e-3, 0.0]


def test_the_cheapest_point_reaches_the_error() -> None:
    """The cheapest point at an error is the fastest of those that reach it, if there are any."""
    points = [point("a", 1e-3, 1.0), point("a", 1e-7, 5.0), point("a", 1e-8, 4.0)]
    assert cheapest(points, 1e-2) == points[0]
    assert cheapest(points, 1e-6) == points[2]
    assert cheapest(points, 1e-9) is None


def test_rounds_time_candidates_for_the_cheapest() -> None:
    """Only runs near the cheapest at one of the errors are timed in rounds.

    Every run is timed once.
    """
    trials = [
        run_trial(run(e), REFERENCE)._replace(seconds=s)
        for e, s in ((1e-3, 0.1), (1e-3, 1.0), (1e-7, 2.0), (1.0, 0.01))
    ]
    assert select_candidates(trials) == {0, 2}
    points = measure_points({"toy": trials}, 1.0, lambda what: None)
    assert [p.timings > 1 for p in points].count(True) >= 1 and all(p.timings >= 1 for p in points)


def test_verdicts_name_the_missed_targets() -> None:
    """The verdict names each missed target.

    The targets are C's time by a factor of the scene, and 1/15 of the best general engine's.
    """
    rows = [point(NAME, 1e-13, 10.0), point("hand C", 1e-13, 5.0), point("MuJoCo", 1e-13, 100.0)]
    rows += [point("Pinocchio", 1e-13, 900.0), point("CasADi C", 1e-13, 9.0)]
    results = targets("S1", {"points": [list(row) for row in rows]})
    assert len(results) == len(ERROR_LEVELS)
    assert results[0] == Target("S1", 1e-2, 2.0, "MuJoCo", 10.0, 0.9)
    assert results[0].verdict() == "misses C, general, CasADi"
    fine = Target("S1", 1e-9, 1.0, "MuJoCo", 20.0, 1.2, 1.4)
    assert fine.verdict() == "misses heyoka" and fine._replace(of_taylor=1.6).verdict() == "holds"
    assert (
        fine._replace(level=1e-12).verdict()
        == "holds"
        != fine._replace(case="S3a", of_taylor=4.9).verdict()
    )
    assert (
        results[0]._replace(case="S4", of_hand_c=1.9, of_generated=1.2).verdict() == "holds"
    )  # the factor of S4 is 10
    of_c = {"S1": 1.3, "S2k": 1.3, "S5": 1.5, "S3a": 2.0, "S3b": 2.0, "S4": 2.0}
    for case, most in of_c.items():
        met = Target(case, 1e-9, most, "MuJoCo", 20.0, 1.2, 5.0)
        assert (
            met.verdict() == "holds" and met._replace(of_hand_c=most + 0.01).verdict() == "misses C"
        )


def scenes_data(date: str, engine: str, case: str, *points: WorkPrecisionPoint) -> dict[str, Any]:
    """Return the data of `scenes.measure_scenes` with one case and one engine."""
    scene = {"points": [list(p) for p in points], "refused": {}, "compiling_s": {}}
    head = {
        "date": date,
        "machine": {},
        "engines": {engine: "1"},
        "missing": {},
        "cannot": {engine: {}},
    }
    return head | {"scenes": {case: scene}}


def test_data_survive_the_file(tmp_path: Path) -> None:
    """New results replace those of their engine and method only.

    Infinite errors are read back as such.
    """
    data = merge_suite(
        {},
        "scenes",
        scenes_data("1", "a", "S1", point("a", float("inf"), 1.0), point("a", 1e-3, 1.0)),
    )
    data = merge_suite(data, "scenes", scenes_data("2", "b", "S1", point("b", 1.23456789e-3, 1.0)))
    data = merge_suite(data, "scenes", scenes_data("3", "a", "S1", point("a", 1e-4, 3.0)))
    data = merge_suite(data, "scenes", scenes_data("4", "b", "S5"))
    write_store(data, tmp_path)
    again = read_store(tmp_path)
    assert (
        again == data
        and again["scenes"]["date"] == "4"
        and again["scenes"]["engines"] == {"a": "1", "b": "1"}
    )
    results = read_points(again["scenes"]["scenes"]["S1"])
    assert [(p.engine, p.error) for p in results] == [("a", 1e-4), ("b", 1.2346e-3)]
    infinite = merge_suite({}, "scenes", scenes_data("1", "a", "S1", point("a", float("inf"), 1.0)))
    assert read_points(infinite["scenes"]["scenes"]["S1"])[0].error == float("inf")
    assert round_floats({"a": (1, 2.0000001)}) == {"a": [1, 2.0]}


@pytest.mark.parametrize("text", ["{", "[1]", '{"scenes": {}}'])
def test_an_unreadable_data_file_is_named(text: str, tmp_path: Path) -> None:
    """A file that is no JSON, or not the benchmark's, is named in a single-line error."""
    (tmp_path / "performance.json").write_text(text)
    with pytest.raises(SceneError, match="performance.json: cannot be read"):
        read_store(tmp_path)


def test_bench_writes_data_figure_and_page(tmp_path: Path) -> None:
    """`crane bench` on one scene and method writes three files; the page is from the data."""
    pytest.importorskip("matplotlib")
    result = CliRunner().invoke(
        bench, ["--scene", "S1", "--method", "rk8", "--save", str(tmp_path)]
    )
    assert result.exit_code == 0, result.output
    data = json.loads((tmp_path / "performance.json").read_text())
    results = cheapest_points(read_points(data["scenes"]["scenes"]["S1"]))[NAME]
    assert all(
        p is not None and p.method == "rk8" and p.error <= level
        for p, level in zip(results, ERROR_LEVELS, strict=True)
    )
    text = (tmp_path / "performance.md").read_text()
    assert text == format_page(data, drawn=True) and "| S1 | crane_sim |" in text
    assert (tmp_path / "performance.png").read_bytes()[:4] == b"\x89PNG"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--scene", "S9"], "S9"),
        (["--method", "rk5"], "rk5"),
        (["flight"], "flight"),
        (["start", "--quick"], "only apply to scenes"),
    ],
)
def test_bad_arguments_are_named(arguments: list[str], message: str, tmp_path: Path) -> None:
    """An impossible argument is named in a single-line error."""
    result = CliRunner().invoke(bench, [*arguments, "--save", str(tmp_path)])
    assert isinstance(result.exception, SceneError) and message in str(result.exception)
