"""`crane league --samples`: trials as studies, their cells, and the page made of them."""

import json
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

from crane_bench.cli.league import sampled_json_data, sampled_league, save_samples
from crane_bench.documentation.pages import PAGES
from crane_bench.league.cases import GROUPS, Entrant, Group, Trial
from crane_bench.league.cells import compute_metrics
from crane_bench.league.sampled_cells import METRICS, SampledCell, better_laws, evaluate_samples
from crane_bench.league.sampled_data import read_cells
from crane_bench.league.sampled_table import (
    command_of,
    describe_samples,
    format_samples,
    sampled_tables,
)
from crane_bench.league.samples import study_of
from crane_sim.files.document import get_value
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.rollout import simulate
from crane_sim.study import StudyResult, cases, read_result
from crane_sim.study.schema import scene_document
from crane_sim.study.statistics import IntervalEstimate, PairedDifference

MASSES = "cable.node_masses"
ENERGY, LQR = Entrant("energy", "energy"), Entrant("lqr", "lqr")
TROLLEY = next(group for group in GROUPS if group.name == "overhead, trolley")
FIXED_RAIL_BASE, NODE_GUST = (
    TROLLEY.trials[0].hidden,
    next(t for t in TROLLEY.trials if t.column == "gust").hidden,
)
OUT = {"trolley.limits": [-0.01, 4.0], "initial.v": -2.0}
SHORT = {"duration": 0.4, "control.period": 0.02}
STILL = Trial("set-point", "overhead_energy", SHORT, FIXED_RAIL_BASE)
GUST = Trial("gust", "overhead_energy", SHORT, NODE_GUST)
GROUP = Group(
    "trolley", "target", (ENERGY, LQR, Entrant("twin", "lqr")), (STILL, GUST), {MASSES: 0.1}
)
SAMPLES = 6


class Interrupted(Exception):
    """What stops a league in a test."""


def league_in(folder: Path, **options: Any) -> list[SampledCell]:
    """Return the cells of the small league whose rows are in a folder, by this process."""
    return list(evaluate_samples(SAMPLES, folder, [GROUP], 1, **options))


class WholeLeague(NamedTuple):
    """The small league that nothing has interrupted."""

    folder: Path
    cells: list[SampledCell]


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> WholeLeague:
    """Return the whole small league; tests leave it as it is."""
    folder = tmp_path_factory.mktemp("league") / "whole"
    return WholeLeague(folder, league_in(folder))


def rows_in(folder: Path) -> list[StudyResult]:
    """Return the results of the small league's trials."""
    return [read_result(folder / study_of(GROUP, trial, SAMPLES).folder) for trial in GROUP.trials]


def test_cells_are_statistics_of_rows_and_rows_are_single_runs(whole: WholeLeague) -> None:
    """A cell's medians and shares are those of its rows.

    A row has the metrics of the single run of its scene.
    """
    folder, cells = whole
    assert [(cell.law, cell.trial) for cell in cells] == [
        (entrant.name, trial.column) for trial in GROUP.trials for entrant in GROUP.entrants
    ]
    still, _ = rows_in(folder)
    energy = cells[0]
    errors = np.array(
        [row["payload_mae"] for row in still.table.to_pylist() if row["variant"] == "energy"]
    )
    assert len(errors) == SAMPLES and energy.metrics["payload_mae"].value == np.median(errors)
    assert (
        energy.metrics["payload_mae"].low >= errors.min()
        and energy.metrics["payload_mae"].high <= errors.max()
    )
    # nothing settles within 0.4 s
    assert energy.controlled is not None and energy.controlled.value == 0.0
    assert energy.metrics["payload_settling"].value == np.inf
    row, case = still.table.to_pylist()[1], cases(still.study)[1]
    run = simulate(load_scene(scene_document(still.study), case.changes))
    assert row["variant"] == "lqr" and row["payload_mae"] == compute_metrics(run, on_path=False).mae
    assert row["state_sha256"] == run.summary["state_sha256"]


def test_all_laws_see_the_same_samples(whole: WholeLeague) -> None:
    """A law under two names has the same rows bit for bit, and is better than neither.

    There is no difference from itself.
    """
    cells = {(cell.law, cell.trial): cell for cell in whole.cells}
    for result in rows_in(whole.folder):
        hashes = result.column("state_sha256").reshape(SAMPLES, len(GROUP.entrants))
        assert (hashes[:, 1] == hashes[:, 2]).all() and len(set(hashes[:, 1])) == SAMPLES
    for trial in GROUP.trials:
        own, twin = cells["lqr", trial.column], cells["twin", trial.column]
        assert own.metrics == twin.metrics and own.better_than == twin.better_than
        assert "twin" not in own.better_than


def test_a_league_that_was_interrupted_goes_on(whole: WholeLeague, tmp_path: Path) -> None:
    """An interrupted league runs what is missing; its cells are those of a whole one.

    Rows that are there keep their files, and a finished league runs nothing.
    """
    folder = tmp_path / "interrupted"

    def interrupt(done: int, _: int) -> None:
        if done >= 4:
            raise Interrupted

    with pytest.raises(Interrupted):
        league_in(folder, on_progress=interrupt)
    kept = {file: file.stat().st_mtime_ns for file in folder.glob("*/rows/0*.arrow")}
    assert 0 < len(kept) < SAMPLES * len(GROUP.entrants)
    began: list[int] = []

    def look(done: int, _: int) -> None:
        if not began:
            assert {file: file.stat().st_mtime_ns for file in kept} == kept
        began.append(done)

    assert league_in(folder, on_progress=look) == whole.cells
    assert began[0] >= 4
    again: list[tuple[int, int]] = []
    assert league_in(folder, on_progress=lambda *count: again.append(count)) == whole.cells
    count = SAMPLES * len(GROUP.entrants)
    assert again == [(count, 2 * count), (2 * count, 2 * count)]


def test_samples_are_hidden_from_the_laws() -> None:
    """Masses, ropes and the disturbance vary around the trial's numbers.

    A law believes in the catalogue's own ones.
    """
    group = next(group for group in GROUPS if group.name == "overhead, trolley")
    heavy, gust = (
        next(t for t in group.trials if t.column == name) for name in ("mass +20 %", "gust")
    )
    study = study_of(group, heavy, 5).study
    assert study is not None
    masses = [case.changes[MASSES][0] for case in cases(study)][:: len(group.entrants)]
    assert all(10.8 <= mass <= 13.2 for mass in masses) and len(set(masses)) == 5
    case = cases(study)[0]
    document = scene_document(study) | {
        key: value for key, value in case.changes.items() if key == "control"
    }
    assert get_value(document, f"control.nominal.{MASSES}")[1] == [10.0]
    study = study_of(group, gust, 5).study
    assert study is not None
    forces = {max(case.changes["forces.0.force.values"]) for case in cases(study)}
    assert len(forces) == 5 and all(4.0 <= force <= 6.0 for force in forces)


def test_each_sample_has_a_sea_of_its_own() -> None:
    """A trial with a sea has another seed of it in every sample, the same ones for all laws."""
    group = GROUPS[0]
    trial = next(trial for trial in group.trials if trial.column == "irregular sea")
    study = study_of(group, trial, 7).study
    assert study is not None
    listed = list(cases(study))
    for law in study.variant_changes:
        seeds = [case.changes["base_motion.sea.seed"] for case in listed if case.variant == law]
        assert sorted(seeds) == list(range(100, 107))
    assert study_of(
        group, next(t for t in group.trials if "vision" in t.column), 2
    ).refused.keys() >= {"angular"}


@pytest.mark.long
def test_every_trial_is_a_study() -> None:
    """Every trial of every crane has a study of all of its laws.

    It has parameters which its scene has.
    """
    for group in GROUPS:
        for trial in group.trials:
            made = study_of(group, trial, 2)
            assert made.study is not None and len(cases(made.study)) == 2 * len(made.study.variants)
            assert len(made.study.variants) + len(made.refused) == len(group.entrants)


def test_better_is_significant_for_all_pairs_together() -> None:
    """With eight pairs of one sign p = 2/256 is significant among three pairs, not among ten.

    A failure is worse.
    """
    small = np.linspace(1.0, 1.7, 8)
    three = {
        "a": small,
        "b": small + np.linspace(0.5, 0.9, 8),
        "c": small + np.linspace(1.5, 1.9, 8),
    }
    assert better_laws(three) == {"a": ("b", "c"), "b": ("c",), "c": ()}
    many = {str(i): small + i * np.linspace(0.5, 0.9, 8) for i in range(5)}
    assert better_laws(many) == dict.fromkeys(many, ())
    skewed = {
        "a": np.zeros(100),
        "b": np.array([*-np.linspace(0.1, 0.2, 55), *np.linspace(1.0, 1.5, 45)]),
    }
    # by ranks, though b is less in more than half
    assert better_laws(skewed) == {"a": ("b",), "b": ()}
    failed = {"a": small, "b": np.full(8, np.inf)}
    assert better_laws(failed) == {"a": ("b",), "b": ()}


def test_a_page_says_where_samples_are_too_few() -> None:
    """The page says where samples are too few, and only there.

    Laws that differ in every sample cannot be told apart then, or a median has no interval.
    """
    for laws, samples in product(range(2, 9), range(2, 15)):
        errors = {
            str(i): np.linspace(1.0, 1.7, samples) + i * np.linspace(0.5, 0.9, samples)
            for i in range(laws)
        }
        told = not any(better_laws(errors).values())
        text = describe_samples(samples, laws)
        assert (f"no difference among {laws} laws" in text) == told
        # 2 / 2**5: the median is outside of 5 values more often
        assert ("too narrow" in text) == (samples <= 5)
    assert describe_samples(12, 8) == "12 samples of each trial."


def test_page_and_data_are_written(whole: WholeLeague, tmp_path: Path) -> None:
    """The page has a row for each cell, the data its numbers; what is not finite is null."""
    cells = [*whole.cells, SampledCell("trolley", "other", "gust", SAMPLES, "it has no camera")]
    save_samples(cells, tmp_path)
    page = (tmp_path / "league_samples.md").read_text()
    assert (
        "| energy | set-point | 0 % (0 … 39) |" in page
        and "- trolley, other, gust: it has no camera" in page
    )
    assert PAGES["league_samples"].read_rows(page) == [
        f"{cell.crane}, {cell.law}, {cell.trial}" for cell in cells
    ]
    kept = json.loads((tmp_path / "league_samples.json").read_text())
    assert kept == json.loads(json.dumps(sampled_json_data(cells)))
    assert kept["cells"][0]["metrics"]["payload_settling"]["value"] is None
    assert kept["cells"][0]["metrics"]["payload_mae"]["value"] > 0.0


def cell_of(crane: str, samples: int, mean: float = 0.5) -> SampledCell:
    """Return a cell with numbers that are not finite among others."""
    number = IntervalEstimate(1.0, 0.5, np.inf)
    metrics = dict.fromkeys(METRICS, number) | {
        METRICS[-1]: IntervalEstimate(np.inf, np.inf, np.inf)
    }
    difference = PairedDifference(samples - 1, mean, 0.4, 0.6, np.nan, 0.25, 0.0)
    return SampledCell(
        crane,
        "lqr",
        "gust",
        samples,
        "",
        IntervalEstimate(0.5, 0.2, 0.8),
        metrics,
        difference,
        ("energy",),
    )


def test_cranes_are_added_to_the_page(tmp_path: Path) -> None:
    """A crane saved alone replaces its own cells; others stay, in order, with their numbers."""
    first, last = GROUPS[0].name, GROUPS[-1].name
    save_samples([cell_of(last, 4)], tmp_path)
    save_samples([cell_of(first, 12)], tmp_path)
    save_samples(
        [cell_of(last, 12), cell_of(last, 12)._replace(from_best=None, better_than=())], tmp_path
    )
    page, cells = (tmp_path / "league_samples.md").read_text(), read_cells(tmp_path)
    assert [(cell.crane, cell.samples) for cell in cells] == [(first, 12), (last, 12), (last, 12)]
    # NaN equals nothing
    assert page == format_samples(cells) and repr(cells[0]) == repr(cell_of(first, 12))
    assert f"`crane {command_of(12, (first, last))}`" in page.splitlines()[2]
    assert "| 1 (0.5 … -) | - | 0.5 (0.4 … 0.6), 11 pairs | energy |" in page
    save_samples([cell_of(last, 4)], tmp_path)
    page = (tmp_path / "league_samples.md").read_text()
    assert (
        f"`crane {command_of(12, [first])}` and `crane {command_of(4, [last])}`"
        in page.splitlines()[2]
    )
    assert page.index("12 samples of each trial.") < page.index("4 samples of each trial. The 95 %")
    (tmp_path / "league_samples.json").write_text('{"cells": [{"crane": 1}]}')
    with pytest.raises(
        SceneError, match="league_samples.json: cannot be read as the league's data: KeyError"
    ):
        sampled_league(False, str(tmp_path), 2, tmp_path / "rows")
    assert not (tmp_path / "rows").exists()


def test_a_trial_in_which_all_runs_fail_has_cells(tmp_path: Path) -> None:
    """A crane that leaves its rail under every law has no metric, and no law is the best.

    The league goes on.
    """
    narrow = Trial("narrow", "overhead_energy", SHORT | OUT, FIXED_RAIL_BASE)
    group = GROUP._replace(trials=(narrow,), entrants=(ENERGY, LQR))
    cells = list(evaluate_samples(2, tmp_path, [group], 1))
    assert [cell.law for cell in cells] == ["energy", "lqr"]
    for cell in cells:
        assert (
            cell.failed
            and cell.failed_runs == 2
            and not cell.better_than
            and cell.from_best is not None
            and cell.from_best.pairs == 0
        )
        assert cell.controlled is not None and cell.controlled.value == 0.0
    assert "limit" in cells[0].failed and "best" not in [
        line.from_the_best_m for line in sampled_tables(cells)["trolley"]
    ]


def test_infeasible_scenes_are_counted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Where a trial's first sample is refused, the league goes on.

    Its laws have cells with the number of refused samples.

    Page and terminal say how many.
    """
    # some are negative
    group = GROUP._replace(trials=(STILL,), entrants=(ENERGY, LQR), uncertain={MASSES: 10.0})
    cells = list(evaluate_samples(5, tmp_path, [group], 1))
    status = read_result(tmp_path / study_of(group, STILL, 5).folder).column("status").reshape(5, 2)
    refused = (status == "refused").sum(axis=0).tolist()
    assert status[0, 0] == "refused" and 1 < refused[0] < 5
    assert [(cell.law, cell.refused_runs) for cell in cells] == [
        ("energy", refused[0]),
        ("lqr", refused[1]),
    ]
    assert cells[0].controlled is not None and "cable.node_masses" in cells[0].failed
    line = (
        f"- trolley, energy, set-point: {refused[0]} of 5 scenes are infeasible; the first reason: "
    )
    assert line in format_samples(cells)
    sampled_league(False, None, 5, tmp_path, [group])
    assert "\nRuns that failed\n" + line in capsys.readouterr().out
