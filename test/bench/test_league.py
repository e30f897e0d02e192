"""`crane league`: the scenes of its trials, the metrics of a cell, and the page made of cells."""

import json
from itertools import product
from pathlib import Path

import pytest

from crane_bench.cli.league import save_comparison
from crane_bench.league.cases import COLUMNS, GROUPS, Group, Trial
from crane_bench.league.cells import Cell, CellMetrics, evaluate, evaluate_all, median_metrics
from crane_bench.league.scenes import trial_scene
from crane_sim.files.catalogue import config_folder
from crane_sim.files.document import get_value
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.rollout import simulate
from crane_sim.study.schema import load_study

ANGULAR, CARTESIAN = GROUPS[1].entrants[:2]
METRICS = CellMetrics(
    1e-4, 0.01, 0.02, 0.01, 5.0, 0.1, 3.0, 0.5, {"tip_x": 1.0}, {"tip_x": "m/s²"}, 0.0
)


def trial_of(column: str) -> Trial:
    """Return the pendulum's trial in a column."""
    return next(trial for trial in GROUPS[0].trials if trial.column == column)


def test_hidden_changes_are_not_in_the_nominal_scene() -> None:
    """Another payload or rope, or a moving base, is in the scene, not in its nominal scene.

    The nominal scene is the law's.
    """
    heavy, long, sea = (
        trial_scene(trial_of(name), CARTESIAN, 7)
        for name in ("mass +20 %", "rope +5 %", "irregular sea")
    )
    assert (
        heavy["payload"]["mass"] == pytest.approx(4.8)
        and heavy["control"]["nominal"]["payload"]["mass"] == 4.0
    )
    assert long["rope"]["length"] == pytest.approx(1.05 * 1.255)
    assert load_scene(long).law.tracker.pendulum.length == 1.255  # pyright: ignore[reportAttributeAccessIssue]
    assert (
        sea["base_motion"]["sea"]["seed"] == 7 and sea["control"]["nominal"]["base_motion"] is None
    )


def test_a_law_keeps_the_simple_model_of_its_scene() -> None:
    """Beside another sling or mass, LQR still believes in the scene's point mass.

    A shaped path knows the own sling.
    """
    group = next(group for group in GROUPS if group.name.startswith("tower"))
    heavy, long = (
        next(t for t in group.trials if t.column == name) for name in ("mass +20 %", "rope +5 %")
    )
    document = trial_scene(heavy, group.entrants[0], 0)
    assert (
        document["payload"]["mass"] == pytest.approx(4800.0)
        and document["payload"]["inertia"][0] == 1.2 * 2.8e3
    )
    believed = document["control"]["nominal"]
    assert (
        believed["links"] == []
        and believed["payload"]["mass"] == 4450.0
        and believed["payload"]["inertia"] is None
    )
    shaped = next(entrant for entrant in group.entrants if entrant.name.endswith("ZV"))
    document = trial_scene(long, shaped, 0)
    assert document["links"][0]["length"] == pytest.approx(3.15)
    assert document["control"]["nominal"]["links"] == [{"mass": 450.0, "length": 3.0}]
    assert load_scene(document).commands == ("velocity", "velocity", "effort")


def test_a_shaped_path_is_only_in_the_nominal_scene() -> None:
    """In open loop with ZV the suspension point follows the shaped path.

    Errors are from the path as it is.
    """
    shaped = next(entrant for entrant in GROUPS[0].entrants if entrant.name.endswith("ZV"))
    scene = load_scene(trial_scene(trial_of("obstacle"), shaped, 0))
    assert scene.trajectory is not None and scene.trajectory.starts[-1] == 50.0
    nominal_path = scene.law.trajectory  # pyright: ignore[reportAttributeAccessIssue, reportOptionalMemberAccess]
    # half a swing, pi sqrt(1.255 / 9.81)
    assert nominal_path.starts[-1] == pytest.approx(50.0 + 1.1237, abs=1e-4)


def test_settings_are_those_of_the_catalogue() -> None:
    """A law takes the gains of its own scene, at the period of the trial."""
    group = next(group for group in GROUPS if group.name == "knuckle boom")
    trial = group.trials[0]
    plain, weighing, lqr = (
        trial_scene(trial, entrant, 0)["control"] for entrant in group.entrants[:3]
    )
    assert plain["kp"] == [30, 10, 10, 1] and "adaptation" not in plain
    assert weighing["adaptation"] == {"rate": 2} and weighing["kp"] == [30, 10, 10, 2]
    assert lqr["r"] == [0.1, 0.1, 0.1, 1.0] and "kp" not in lqr


def test_tuned_laws_have_the_gains_of_their_search() -> None:
    """Each entrant named tuned has gains of a search in the catalogue, within its limits."""
    entrants = [(group, entrant) for group in GROUPS for entrant in group.entrants if entrant.tuned]
    assert len(entrants) == 6
    for group, entrant in entrants:
        settings = {"control": trial_scene(group.trials[0], entrant, 0)["control"]}
        study = load_study(config_folder() / "tuning" / f"{entrant.tuned}.yaml")
        assert study.tune is not None
        for key, gain in study.tune.gains.items():
            assert gain.low <= get_value(settings, key)[1] <= gain.high, (entrant.tuned, key)


@pytest.mark.long
def test_metrics_of_a_cell_are_those_of_the_summary() -> None:
    """Errors and swing of a cell are those of the run's own summary, computed block by block."""
    trial = Trial("obstacle", "offshore_obstacle")
    cell = evaluate(Group("pendulum", "path", (), ()), ANGULAR, trial)
    summary = simulate(load_scene(trial_scene(trial, ANGULAR, 0))).summary
    assert cell.metrics is not None and not cell.refused and not cell.failed and cell.runs == 1
    # the same sum in another order
    assert cell.metrics.mse == pytest.approx(summary["tracking_mse"], rel=1e-9)
    assert cell.metrics.mae == pytest.approx(summary["tracking_mae"], rel=1e-9)
    assert cell.metrics.peak_error == pytest.approx(summary["tracking_peak"], rel=1e-9)
    # of the control steps; the cell has the last state, too
    hardest = summary["peak_tip_acceleration"]
    assert cell.metrics.tip_acceleration == pytest.approx(hardest, rel=0.01)
    assert 0.0 < (cell.metrics.settling or 0.0) < 10.0  # the scene ends 10 s after its path


def test_a_law_that_does_not_apply_has_its_reason() -> None:
    """The angular law has no camera: the cell has no metrics, but the reason."""
    cell = evaluate(GROUPS[0], ANGULAR, trial_of("30 Hz vision"))
    assert cell.metrics is None and "vision" in cell.refused and not cell.failed


def test_the_median_of_settling() -> None:
    """One run of three that does not settle leaves a median, two of three do not."""
    never = METRICS._replace(settling=None)
    assert median_metrics([METRICS, METRICS._replace(settling=5.0), never]).settling == 5.0
    assert median_metrics([METRICS, never, never]).settling is None
    assert median_metrics([METRICS, METRICS._replace(mae=0.03, effort={"tip_x": 3.0})]).effort == {
        "tip_x": 2.0
    }


CELLS = [
    Cell("pendulum", "angular", "obstacle", 1, METRICS, "", ""),
    Cell("pendulum", "harmonic", "obstacle", 1, None, "", "stopped at t = 1 s"),
    Cell("pendulum", "angular", "30 Hz vision", 10, None, "it has no camera", ""),
]


def test_page_figure_and_data_are_written(tmp_path: Path) -> None:
    """A failing law stays in table and data with its reason; one that does not apply is absent."""
    save_comparison(CELLS, tmp_path)
    page = (tmp_path / "league.md").read_text()
    assert (
        "| harmonic | obstacle: not controlled | 1 | - |" in page
        and "harmonic, obstacle: stopped at t = 1 s" in page
    )
    assert page.count("\n| angular") == 1 and "| tip_x 1 m/s² |" in page
    assert "angular, 30 Hz vision: it has no camera" in page
    assert (tmp_path / "league.png").read_bytes().startswith(b"\x89PNG")
    kept = json.loads((tmp_path / "league.json").read_text())["cells"]
    assert [cell["failed"] for cell in kept] == ["", "stopped at t = 1 s", ""] and kept[0][
        "metrics"
    ]["mae"] == 0.01


@pytest.mark.slow
def test_the_whole_league() -> None:
    """Every entrant has a cell in every trial of its crane: metrics, or a reason for none."""
    cells = list(evaluate_all())
    expected = [
        (g.name, c.name, t.column) for g in GROUPS for c, t in product(g.entrants, g.trials)
    ]
    assert [(cell.crane, cell.law, cell.trial) for cell in cells] == expected
    assert {cell.trial for cell in cells} == set(COLUMNS)
    assert all((cell.metrics is None) <= bool(cell.refused or cell.failed) for cell in cells)
    assert not any(cell.refused for cell in cells if cell.trial != "30 Hz vision")
