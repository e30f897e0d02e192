"""Tuning of gains: the search, its resumption, and what is held out."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from command_line import crane
from test_study_runs import without_times

import crane_sim
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene
from crane_sim.study import tuning
from crane_sim.study.execution import check_cases
from crane_sim.study.recordings import selected_cases
from crane_sim.study.result import StudyResult, read_result
from crane_sim.study.schema import BASELINE, Recordings, Worst, load_study
from crane_sim.study.statistics import PairedDifference, compare_pairs
from crane_sim.study.workers import start_workers

KP, KD = "control.kp.0", "control.kd.0"
STUDY: dict[str, Any] = {
    "name": "gains",
    "scene": "overhead_energy",
    "design": "sobol",
    "samples": 8,
    "duration": 8.0,
    "parameters": {"reference.q.0": {"distribution": "uniform", "low": 1.0, "high": 3.0}},
    "tune": {
        "changes": {"control.kp": [12.0], "control.kd": [22.0]},
        "gains": {
            KP: {"low": 5.0, "high": 100.0, "log": True},
            KD: {"low": 5.0, "high": 100.0, "log": True},
        },
        "objectives": ["residual_swing_deg", "peak_effort"],
        "trials": 14,
        "keep": 1,
    },
}


def with_tune(**changes: Any) -> dict[str, Any]:
    """Return the study with changes of its group `tune`."""
    return STUDY | {"tune": STUDY["tune"] | changes}


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> tuning.TuningResult:
    """Return a search that nothing has interrupted."""
    return tuning.tune(STUDY, tmp_path_factory.mktemp("tune") / "whole", workers=1)


@pytest.mark.long
def test_a_search_that_goes_on_is_the_undisturbed_one(
    whole: tuning.TuningResult, tmp_path: Path
) -> None:
    """A search interrupted in its fifth trial ends like one that runs all at once.

    The other trials have two workers or one.
    """
    tuning.tune(with_tune(trials=5), tmp_path, workers=2)
    journal = tmp_path / "trials.log"
    journal.write_bytes(journal.read_bytes()[:-20])  # in the middle of the line that ends the fifth
    again = tuning.tune(STUDY, tmp_path, workers=2)
    assert again.chosen == whole.chosen and again.front == whole.front
    assert without_times(again.held_out.table) == without_times(whole.held_out.table)


def test_the_values_of_a_trial_are_means_of_runs(whole: tuning.TuningResult) -> None:
    """A candidate's values are the means of the metrics of `simulate` over training samples.

    The gains are those of the candidate.
    """
    best = whole.front[0]
    changes = {"control.kp": [best.gains[KP]], "control.kd": [best.gains[KD]]}
    runs = []
    for case in check_cases(load_study({k: v for k, v in STUDY.items() if k != "tune"})):
        runs.append(crane_sim.simulate("overhead_energy", overrides=case.changes | changes).summary)
    swing = sum(run["residual_swing_deg"] for run in runs) / len(runs)
    effort = sum(run["peak_effort"]["trolley"] for run in runs) / len(runs)
    # sums of four numbers, in whatever order
    assert best.values == pytest.approx((swing, effort), rel=1e-14)


def test_no_trial_beats_one_of_the_front(whole: tuning.TuningResult) -> None:
    """The front is in the order of its first objective, and so the reverse of the second's."""
    swing, effort = zip(*(each.values for each in whole.front), strict=True)
    assert (
        len(whole.front) > 1
        and list(swing) == sorted(swing)
        and list(effort) == sorted(effort, reverse=True)
    )
    assert whole.chosen["least_residual_swing_deg"] == whole.front[0]
    assert whole.chosen["least_peak_effort"] == whole.front[-1]


def test_gains_that_lose_the_crane_are_no_candidates() -> None:
    """A trial ends with the first sample that fails or lacks the metric.

    How far it came is its violation.
    """
    study = load_study(STUDY | {"tune": None, "changes": {"trolley.limits": [-9.0, 2.0]}})
    with start_workers(1, None) as pool:
        weak = {"control.kp": [10.0], "control.kd": [20.0], "control.apparent_mass": 2.5}
        values, violation = tuning.evaluate_gains(study, weak, ("settling_time",), pool)
        reached = [case.parameters["reference.q.0"] < 2.0 for case in check_cases(study)]
    assert values == (math.inf,) and 0.0 < violation == 1.0 - reached.index(False) / 8


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        (
            {"design": "grid", "samples": None, "parameters": {"reference.q.0": [1.0, 2.0]}},
            "design = grid: its held-out",
        ),
        ({"design": "morris"}, "latin_hypercube, sobol, monte_carlo, saltelli"),
        (
            {"variants": {"scene": {}, "compromise_1": {}}},
            "variants.compromise_1: is a name that tune gives",
        ),
        ({"gains": {"control.kq": {"low": 1.0, "high": 2.0}}}, "kq"),
        ({"gains": {KP: {"low": 3.0, "high": 2.0}}}, "low = 3 must be less than high = 2"),
        (
            {"gains": {KP: {"low": 0.0, "high": 2.0, "log": True}}},
            "log needs a number greater than 0",
        ),
        ({"gains": {KP: {"low": -2.0, "high": 2.0}}}, "-2"),
        (
            {"gains": {"reference.q.0": {"low": 1.0, "high": 2.0}}},
            "sets what the parameter reference.q.0 sets, too",
        ),
        (
            {"gains": {"reference.q.0.x": {"low": 1.0, "high": 2.0}}},
            "sets what the parameter reference.q.0 sets, too",
        ),
        ({"objectives": ["residual_swing"]}, "did you mean 'residual_swing_deg'"),
        ({"objectives": ["law"]}, "tune.objectives: unknown metric"),
        ({"objectives": ["parameter.reference.q.0"]}, "tune.objectives: unknown metric"),
        ({"objectives": ["limit_margin.trolley"]}, "is better when it is larger"),
        (
            {"objectives": ["settling_time"], "gains": {KP: {"low": 1e-3, "high": 2e-3}}},
            "widen or move the ranges",
        ),
        (
            {"gains": {"control.kq.0": {"low": 1.0, "high": 2.0}}},
            "tune.gains.control.kq.0 = 1: scene",
        ),
        ({"changes": {"control.kq": [1.0]}}, "tune.changes: scene"),
        ({"changes": {}}, "tune.gains.control.kp.0 = 5: "),
    ],
)
def test_searches_that_are_not_possible(changes: dict[str, Any], line: str, tmp_path: Path) -> None:
    """One line names the key and what is possible."""
    study = {
        key: value
        for key, value in changes.items()
        if key in ("design", "samples", "parameters", "variants")
    }
    settings = {key: value for key, value in changes.items() if key not in study}
    with pytest.raises(SceneError) as error:
        tuning.tune(quick(study, **settings), tmp_path / "search", workers=1)
    assert line in str(error.value) and "\n" not in str(error.value)


def test_a_folder_of_another_search_stays_as_it_is(whole: tuning.TuningResult) -> None:
    """Other ranges in the same folder are refused; more trials are not."""
    folder = whole.held_out.folder.parent
    before = (folder / "trials.log").read_bytes()
    with pytest.raises(SceneError, match="holds another search"):
        tuning.tune(with_tune(gains={KP: {"low": 1.0, "high": 2.0}}), folder, workers=1)
    assert (folder / "trials.log").read_bytes() == before


def test_a_search_with_all_of_its_trials_is_judged_once(whole: tuning.TuningResult) -> None:
    """A search with fewer trials than its folder has returns the whole one.

    It is judged by the study that is there.
    """
    folder = whole.held_out.folder.parent
    again = tuning.tune(with_tune(trials=5), folder, workers=1)
    assert again.trials == whole.trials and again.chosen == whole.chosen
    seen = {
        case.parameters["reference.q.0"] for case in check_cases(load_study(STUDY | {"tune": None}))
    }
    judged = set(whole.held_out.table["parameter.reference.q.0"].to_pylist())
    assert len(judged) == 8 and not seen & judged  # samples that the search has not seen
    assert (
        again.held_out.folder == whole.held_out.folder
        and again.held_out.table == whole.held_out.table
    )


def test_the_command_prints_gains_and_judgement(whole: tuning.TuningResult, tmp_path: Path) -> None:
    """`crane tune` resumes the search in its folder; `crane sweep` refuses the file in one line."""
    file = tmp_path / "gains.yaml"
    file.write_text(yaml.safe_dump(STUDY))
    shown = crane(
        "tune", str(file), "-o", str(whole.held_out.folder.parent), "--workers", "1", "--json"
    )
    found = json.loads(shown.stdout)
    assert found["trials"] == 14 and found["chosen"].keys() == whole.chosen.keys()
    row = found["held_out"]["peak_effort"]["least_peak_effort"]
    assert row["verdict"] == "improved" and row["low"] <= row["difference"] <= row["high"] < 0.0
    refused = crane("sweep", str(file), "-o", str(tmp_path / "sweep"))
    assert (
        refused.returncode == 2
        and "crane tune" in refused.stderr
        and not (tmp_path / "sweep").exists()
    )


def test_intervals_decide() -> None:
    """An interval on one side of zero shows an improvement or its opposite.

    One that has zero in it shows none.

    Of few pairs, nothing is claimed; without an interval the test decides; gains that fail more
    often are no better.
    """
    better, worse = difference(8, -2.0, -1.0), difference(8, 1.0, 2.0)
    assert tuning.verdict_on(better) == "improved" and tuning.verdict_on(worse) == "worse"
    assert tuning.verdict_on(difference(8, -1.0, 1.0)) == "no difference shown"
    few = compare_pairs(np.zeros(5), np.full(5, -1.0))  # a constant difference
    assert tuning.verdict_on(few) == "too few samples"
    assert tuning.verdict_on(compare_pairs(np.zeros(6), np.full(6, -1.0))) == "improved"
    last_bits = np.full(8, 1.0) * (1.0 - 2.0**-53)
    assert tuning.verdict_on(compare_pairs(np.ones(8), last_bits)) == "no difference shown"
    nan = math.nan
    assert tuning.verdict_on(difference(8, nan, nan, p_value=0.01)) == "improved"
    assert tuning.verdict_on(difference(8, nan, nan, p_value=1.0)) == "no difference shown"
    assert tuning.verdict_on(better, more_failures=True) == "more failures"
    assert tuning.verdict_on(difference(0, nan, nan), more_failures=True) == "more failures"


def difference(pairs: int, low: float, high: float, p_value: float = 0.01) -> PairedDifference:
    """Return a difference with an interval."""
    mean = -1.0 if math.isnan(low) else (low + high) / 2.0
    return PairedDifference(pairs, mean, low, high, 1.0, p_value, 1.0)


WHOLE = {"control.kp": [12], "control.kd": [22]}
QUICK = STUDY | {"samples": 2, "duration": 0.2}
"""A study whose runs are short enough for a process without compilation."""


def quick(study: dict[str, Any] | None = None, **changes: Any) -> dict[str, Any]:
    """Return the short study with other keys, and changes of its group `tune`."""
    settings = STUDY["tune"] | {"objectives": ["peak_effort"], "trials": 1} | changes
    return QUICK | (study or {}) | {"tune": settings}


def test_a_folder_belongs_to_one_process(tmp_path: Path) -> None:
    """A second search in a folder is refused while the first one runs, and changes nothing."""
    refusals = []

    def search_again(done: int, _: int) -> None:
        if done == 0 and not refusals:
            with pytest.raises(
                SceneError, match="another process is running this search"
            ) as refused:
                tuning.tune(quick(), tmp_path, workers=1)
            refusals.append(refused)

    assert (
        tuning.tune(quick(), tmp_path, workers=1, on_progress=search_again).trials == 1 and refusals
    )


def test_the_first_trial_has_the_gains_of_the_scene(tmp_path: Path) -> None:
    """Whole numbers count, of the first variant, from which every trial starts."""
    (found,) = tuning.tune(
        quick({"variants": {"own": WHOLE}}, changes={}), tmp_path, workers=1
    ).front
    assert found.gains == {KP: 12.0, KD: 22.0}


def test_an_error_with_a_sign_counts_by_its_magnitude(tmp_path: Path) -> None:
    """Objectives, comparisons and worst runs take the magnitude of errors that are negative."""
    behind = {"reference.q.0": {"distribution": "uniform", "low": -3.0, "high": -1.0}}
    found = tuning.tune(
        quick({"parameters": behind}, objectives=["final_error"]), tmp_path, workers=1
    )
    ((mean,),) = [each.values for each in found.front]
    judged, errors = found.held_out, found.held_out.column("final_error.trolley")
    assert 1.0 < mean < 3.0 and np.all(errors < 0.0)
    by_variant = [judged.metric(name, BASELINE) for name in ("final_error", "final_error.trolley")]
    assert np.array_equal(by_variant, [-errors[judged.column("variant") == BASELINE]] * 2)
    worst = Recordings(worst=Worst(metric="final_error.trolley", count=1))
    recorded = StudyResult(judged.study.model_copy(update={"recordings": worst}), judged.folder)
    assert selected_cases(recorded) == [int(np.argmin(errors))]


def test_gains_can_be_pasted(tmp_path: Path) -> None:
    """An entry of gains.yaml is a variant, and its lines are those of `--set`.

    That holds though the scene has no such list.

    `crane report` of the folder names the folder of the study.
    """
    mass = {"control.apparent_mass": {"low": 2.0, "high": 3.0}}
    result = tuning.tune(quick(gains=STUDY["tune"]["gains"] | mass), tmp_path, workers=1)
    ((name, found),) = result.chosen.items()
    text = (tmp_path / "gains.yaml").read_text()
    saved = yaml.safe_load(text)
    lists = {"control.kp": [found.gains[KP]], "control.kd": [found.gains[KD]]}
    assert (
        saved == {name: lists | {key: found.gains[key] for key in mass}}
        and "  control.kp: [12.0]\n" in text
    )
    scene = load_scene("overhead_energy", overrides=saved[name])
    assert scene.document["control"]["kp"] == saved[name]["control.kp"]
    check_cases(load_study(QUICK | {"tune": None, "variants": saved}))
    with pytest.raises(
        SceneError, match="holds a search of crane tune; its study is .*held_out_1_keep_1$"
    ):
        read_result(tmp_path)
