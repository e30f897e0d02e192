"""Metrics of one's own in studies: columns by a function that a study's file names."""

import io
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from rich.console import Console

import crane_sim
from crane_sim import study as studies
from crane_sim.cli.sweep import print_result
from crane_sim.files.document import read
from crane_sim.files.errors import SceneError
from crane_sim.report.study_page import study_page
from crane_sim.study.summary import shown_metrics
from crane_sim.study.tuning import tune

MASS = "cable.node_masses.0"
STUDY: dict[str, Any] = {
    "scene": "overhead_energy",
    "duration": 0.2,
    "parameters": {MASS: [8.0, 12.0]},
    "variants": {"energy": {}, "weak": {"control.kp": [10.0]}},
}
OWN = """
def furthest(run):
    return {"furthest": abs(run.q[:, 0]).max(), "none": None, "odd_steps": 0.5}

def broken(run):
    raise SystemExit(3)

def of_strong_laws(run):
    return {"inverse": 1.0 / int(abs(run.u[:, 0]).max() > 340.0)}

class Table:
    def __repr__(self):
        return "rows\\n    rows"

RETURNED = {"metric": {}}

def returned(run):
    return RETURNED["metric"]
"""


@pytest.fixture
def own(tmp_path: Path) -> Path:
    """Return a file with functions of a run."""
    file = tmp_path / "own.py"
    file.write_text(OWN)
    return file


def run_with(metrics: str, folder: Path, **changes: Any) -> list[dict[str, Any]]:
    """Return the rows of the small study with metrics of its own."""
    return studies.run(STUDY | {"metrics": metrics} | changes, folder, workers=1).table.to_pylist()


def test_a_study_has_metrics_of_ones_own(own: Path, tmp_path: Path) -> None:
    """A function that the file names adds columns to the rows of the study without it.

    A function or module that is not there is one line.
    """
    file = tmp_path / "study.yaml"
    file.write_text(yaml.safe_dump(STUDY | {"metrics": "own.py:furthest"}))
    found, plain = studies.run(file, tmp_path / "own", 1), studies.run(STUDY, tmp_path / "plain", 1)
    for row, case in zip(found.table.to_pylist(), studies.cases(found.study), strict=True):
        run = crane_sim.simulate("overhead_energy", overrides=case.changes)
        assert (
            row["furthest"] == abs(run.q[:, 0]).max()
            and row["none"] is None
            and row["odd_steps"] == 0.5
        )
    same = ["case", "status", "state_sha256", "residual_swing_deg"]
    assert found.table.select(same) == plain.table.select(same)
    for name, reason in (
        (f"{own}:nowhere", "has no function 'nowhere'"),
        ("foo", "= 'foo': must be FILE.py:FUNCTION or MODULE:FUNCTION"),
        ("nowhere_at_all:foo", "No module named 'nowhere_at_all'"),
    ):
        with pytest.raises(SceneError, match=reason):
            run_with(name, tmp_path / "refused")


@pytest.mark.parametrize(
    ("returned", "line"),
    [
        *(
            (
                {name: 1.0},
                f"returned {name!r}, which is taken by the table's own columns; take another name",
            )
            for name in ("status", f"parameter.{MASS}", "state_sha256")
        ),
        ({"settling_time.bridge": 1.0}, "returned 'settling_time.bridge', which is taken"),
        ({1: 1.0}, "returned 1 as a name; names are text"),
        ({"far": [1.0]}, r"returned far = \[1.0\]; must be a number"),
        ({"far": "3.0"}, "returned far = '3.0'; must be a number"),
        ("Table()", "returned rows rows; must return a dict"),
        (None, "returned None; must return a dict of name: number"),
    ],
)
def test_what_can_be_no_column_is_refused_after_one_run(
    returned: Any, line: str, own: Path, tmp_path: Path
) -> None:
    """What can be no column is refused in one line that says what is possible.

    These are names that the table has, and what are no numbers by name; nothing is written.
    """
    text = returned if returned == "Table()" else repr(returned)
    own.write_text(OWN.replace('{"metric": {}}', f'{{"metric": {text}}}'))
    with pytest.raises(SceneError, match=line) as error:
        run_with(f"{own}:returned", tmp_path / "refused")
    assert f"study: metrics = '{own}:returned': " in str(error.value) and "\n" not in str(
        error.value
    )
    assert not (tmp_path / "refused").exists()


@pytest.mark.parametrize("content", [b"", b"\xff\xfe", b'{"study": 5}'])
def test_a_damaged_identity_is_one_line(content: bytes, tmp_path: Path) -> None:
    """A damaged study.json is named in one line by a study that finds it, and by its reader."""
    for name in ("study.json", "table.parquet"):
        (tmp_path / name).write_bytes(content)
    with pytest.raises(
        SceneError, match=r"^\S*study\.json: is damaged; name another folder[^\n]*$"
    ):
        studies.run(STUDY, tmp_path, 1)
    with pytest.raises(SceneError, match=r"^\S*study\.json: is damaged[^\n]*$"):
        studies.read_result(tmp_path)


def test_values_of_several_types_are_text(tmp_path: Path) -> None:
    """Numbers, text and a refused flag as values of one parameter make one column.

    Each is in a block of its own.
    """
    found = studies.run(
        STUDY | {"parameters": {"initial.angles": [0.1, "10 deg", 1, True]}}, tmp_path, 1
    )
    assert found.column("parameter.initial.angles").tolist()[::2] == ["0.1", "10 deg", "1", "True"]
    assert found.column("status").tolist()[::2] == ["ok", "ok", "ok", "refused"]


def test_the_worst_runs_are_those_without_a_value(own: Path, tmp_path: Path) -> None:
    """Runs without the metric are recorded before that with the largest value, failed ones not."""
    # by mass; another one is an error, and so a failed run
    values = {8.0: 1.0, 9.0: None, 10.0: 2.0}
    look_up = f"{values}[run.scene.document['cable']['node_masses'][0]]"
    own.write_text(f"def late(run):\n    return {{'late': {look_up}}}\n")
    changes = {"parameters": {MASS: [7.0, *values]}, "variants": {}, "metrics": f"{own}:late"}
    worst = {"worst": {"metric": "late", "count": 2}}
    result = studies.run(STUDY | changes | {"recordings": worst}, tmp_path / "study", 1)
    assert result.column("status").tolist() == ["failed", "ok", "ok", "ok"]
    assert sorted(file.stem for file in (result.folder / "recordings").iterdir()) == [
        "000002",
        "000003",
    ]


def test_recordings_without_a_recorder_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A study or search with recordings is refused in one line if rerun-sdk is missing.

    That comes before anything runs.
    """
    monkeypatch.setitem(sys.modules, "rerun", None)
    monkeypatch.setattr("crane_sim.study.execution.check_cases", pytest.fail)
    monkeypatch.setattr("crane_sim.study.tuning_checks.check_cases", pytest.fail)
    tuned = STUDY | {
        "tune": {
            "gains": {"control.kp.0": {"low": 1.0, "high": 2.0}},
            "objectives": ["peak_swing_deg"],
        }
    }
    for start, study in ((studies.run, STUDY), (tune, tuned)):
        with pytest.raises(
            SceneError, match=r"^study: recordings: needs the Python package rerun-sdk,[^\n]*$"
        ):
            start(study | {"recordings": {"every": 2}}, tmp_path / "refused", 1)
    assert not (tmp_path / "refused").exists()


def test_a_metric_that_fails_is_a_row_that_failed(own: Path, tmp_path: Path) -> None:
    """Where the function raises, its row is `failed` with function and error; others stay.

    Also where all fail, the study reaches its end, with the metrics of every run's summary.
    """
    rows = run_with(f"{own}:of_strong_laws", tmp_path / "some")
    strong = [row["peak_effort.trolley"] > 340.0 for row in rows]
    assert 0 < sum(strong) < 4 and [row["status"] for row in rows] == [
        ("failed", "ok")[each] for each in strong
    ]
    (line,) = {row["error"] for row in rows if row["error"]}
    assert line.startswith(f"metrics = '{own}:of_strong_laws': ZeroDivisionError: ")
    assert [row["inverse"] for row in rows] == [1.0 if each else None for each in strong]
    result, lines = studies.read_result(tmp_path / "some"), io.StringIO()
    print_result(result, Console(file=lines, width=200))
    (each,) = result.failure_differences().values()
    counts = (
        f"only energy in {each.first_only}, only weak in {each.second_only}, both in {each.both}"
    )
    assert f"failures by sample: {counts}; McNemar's p {each.p_value:.2g}\n" in lines.getvalue()
    broken = run_with(f"{own}:broken", tmp_path / "all")
    assert all("SystemExit: 3" in row["error"] and row["status"] == "failed" for row in broken)
    assert [row["state_sha256"] for row in broken] == [row["state_sha256"] for row in rows]


def test_recordings_of_a_finished_study_may_be_asked_for_later(own: Path, tmp_path: Path) -> None:
    """Recordings are no part of a study: its folder takes others, and no row is run again."""
    study, folder = STUDY | {"metrics": f"{own}:furthest"}, tmp_path / "folder"
    with pytest.raises(SceneError, match="unknown metric 'further'.*did you mean 'furthest'"):
        studies.run(study | {"recordings": {"worst": {"metric": "further"}}}, folder, 1)
    first = studies.run(study, folder, 1)
    again = studies.run(
        study | {"recordings": {"worst": {"metric": "furthest", "count": 1}}}, folder, 1
    )
    assert again.table == first.table
    (file,) = (folder / "recordings").iterdir()
    assert int(file.stem) == np.argmax(first.column("furthest"))
    assert studies.run(study, folder, 1).table == first.table
    with pytest.raises(SceneError, match="holds another study"):
        studies.run(study | {"seed": 5, "recordings": {"failures": True}}, folder, 1)


LAW = """
def push(t, q, v):
    return (40.0 * (3.0 - q[0]) - 80.0 * v[0] + 100.0 * q[1],)
"""
NAMED: dict[str, dict[str, Any]] = {
    "metrics": {"metrics": "NAMED"},
    "variants": {"variants": {"energy": {}, "own": {"control.law": "NAMED"}}},
    "scene": {"scene": read("overhead_energy") | {"control": {"law": "NAMED"}}},
}


@pytest.mark.parametrize("place", NAMED)
def test_a_study_goes_on_with_the_functions_that_began_it(
    place: str, own: Path, tmp_path: Path
) -> None:
    """After an edit of a file of metrics or of a law, its folder is refused in one line.

    The folder stays as it is.

    With the content that began the study, its folder is taken again.
    """
    law = tmp_path / "law.py"
    law.write_text(LAW)
    file, function = (own, "furthest") if place == "metrics" else (law, "push")
    plain = {key: value for key, value in STUDY.items() if key != "variants"}
    changes = json.loads(json.dumps(plain | NAMED[place]).replace("NAMED", f"{file}:{function}"))
    first, text = studies.run(changes, tmp_path / "folder", 1), file.read_text()
    assert set(first.column("status")) == {"ok"}
    file.write_text(text + "\n# edited\n")
    line = (
        f"folder {tmp_path / 'folder'}: was begun with another content of {file}; name another "
        "folder, or remove it"
    )
    with pytest.raises(SceneError) as refused:
        studies.run(changes, tmp_path / "folder", 1)
    assert str(refused.value) == line
    file.write_text(text)
    assert studies.run(changes, tmp_path / "folder", 1).table == first.table


def test_a_function_that_is_edited_meanwhile_ends_the_study(own: Path, tmp_path: Path) -> None:
    """Rows by two functions never mix: the next block names the file.

    Another study takes what the file has now.
    """

    def edit(*_: int) -> None:
        own.write_text(OWN.replace(".max()", ".min()"))

    study = STUDY | {"metrics": f"{own}:furthest"}
    line = f"{own}: not as when the study began; undo that, or begin it in another folder"
    with pytest.raises(SceneError) as ended:
        studies.run(study, tmp_path / "edited", 1, on_progress=edit)
    assert str(ended.value) == line
    assert {row["furthest"] for row in run_with(f"{own}:furthest", tmp_path / "again")} == {0.0}


def test_own_metrics_are_in_the_summary(own: Path, tmp_path: Path) -> None:
    """Summary, terminal and page show a study's own metrics, also where first rows lack them.

    They are behind those of every run.

    In a narrow terminal names break, and no number is cut.
    """
    own.write_text(
        OWN
        + """
def late(run):
    return {"far": float(run.q[-1, 0])} if run.scene.seed % 2 else {"mean [m]": 0.000123456}
"""
    )
    study = STUDY | {"design": "monte_carlo", "samples": 4, "seed": 3, "metrics": f"{own}:late"}
    study["parameters"] = {MASS: {"distribution": "uniform", "low": 8.0, "high": 12.0}}
    result = studies.run(study, tmp_path / "folder", 1)
    assert len({seed % 2 for seed in result.column("seed")}) == 2
    assert sorted(result.own_metrics) == ["far", "mean [m]"]
    assert set(shown_metrics(result)[-2:]) == {"far", "mean [m]"}
    lines = io.StringIO()
    print_result(result, Console(file=lines, width=80))
    shown = lines.getvalue()
    assert "far " in shown and "mean [m]" in shown and "0.0001235" in shown and "…" not in shown
    assert max(map(len, shown.splitlines()[:-1])) <= 80 and "mean [m]" in study_page(result)


def test_what_a_killed_write_has_left_is_removed_and_a_damaged_block_is_named(
    own: Path, tmp_path: Path
) -> None:
    """A study resumes beside a killed process's unfinished files; a damaged block is one line."""
    folder = tmp_path / "study"
    with pytest.raises(RuntimeError, match="stop"):
        studies.run(STUDY, folder, workers=1, on_progress=raise_after_two)
    (folder / "rows" / ".000003.arrow.123").touch()
    (folder / ".table.parquet.123").touch()
    whole = sorted((folder / "rows").glob("*.arrow"))
    content = whole[0].read_bytes()
    whole[0].write_bytes(b"")
    with pytest.raises(
        SceneError, match=r"000000\.arrow: is damaged .*; remove it: its cases are run anew"
    ):
        studies.run(STUDY, folder, workers=1)
    whole[0].write_bytes(content)
    assert len(studies.run(STUDY, folder, workers=1).table) == 4
    assert sorted(file.name for file in folder.iterdir()) == ["study.json", "table.parquet"]


def raise_after_two(done: int, _: int) -> None:
    """End a study after two of its cases."""
    if done == 2:
        raise RuntimeError("stop")


def test_a_module_that_is_edited_in_a_living_process_is_loaded_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """An edited module gives another hash of the study's identity, in one Python process too.

    The hash is that of the functions that made the numbers.
    """
    monkeypatch.syspath_prepend(tmp_path)
    module = tmp_path / "edited_metrics.py"
    for value in (
        1.0,
        22.0,
    ):  # of unlike length: byte code is told from older one by time in seconds and by size
        module.write_text(f"def own(run):\n    return {{'own': {value}}}\n")
        rows = run_with("edited_metrics:own", tmp_path / str(value))
        assert {row["own"] for row in rows} == {value}
