"""Runs of studies: the rows are those of single runs, whatever interrupts them."""

import json
import os
import pickle
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from command_line import CRANE, crane
from process_helpers import LIMIT, started_program, wait_exited, wait_until

import crane_sim
from crane_sim import study as studies
from crane_sim.cli.commands import app
from crane_sim.files.errors import SceneError
from crane_sim.recording.files import unfinished_name
from crane_sim.study.recordings import record_selected

MASS = "cable.node_masses.0"
STUDY: dict[str, Any] = {
    "name": "masses",
    "scene": "overhead_energy",
    "design": "sobol",
    "samples": 8,
    "seed": 2,
    "duration": 2.0,
    "parameters": {MASS: {"distribution": "uniform", "low": 5.0, "high": 20.0}},
    "variants": {"energy": {}, "weak": {"control.kp": [10.0]}},
}
FAILING = STUDY | {
    "design": "grid",
    "samples": None,
    "duration": 5.0,
    "changes": {"trolley.limits": [-9.0, 4.0]},
    "parameters": {MASS: [5.0, -1.0]},
    "variants": {
        "energy": {},
        "stiff": {"control.kp": [2000.0]},
    },  # which overshoots by more than a metre
    "recordings": {"failures": True},
}


def without_times(table: Any) -> Any:
    """Return a table without the column that differs from run to run."""
    return table.drop_columns(["wall_time"])


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> studies.StudyResult:
    """Return a study that nothing has interrupted."""
    return studies.run(STUDY, tmp_path_factory.mktemp("study") / "whole", workers=1)


def test_rows_are_single_runs(whole: studies.StudyResult) -> None:
    """A row has the state's hash and the metrics of `simulate`, to the last bit.

    The parameters are those of the row.
    """
    rows = whole.table.to_pylist()
    assert [row["case"] for row in rows] == list(range(16)) and {row["status"] for row in rows} == {
        "ok"
    }
    for row in (rows[0], rows[7], rows[-1]):
        changes = STUDY["variants"][row["variant"]] | {
            MASS: row[f"parameter.{MASS}"],
            "seed": row["seed"],
        }
        run = crane_sim.simulate("overhead_energy", duration=2.0, overrides=changes)
        assert row["state_sha256"] == run.summary["state_sha256"]
        assert row["residual_swing_deg"] == run.summary["residual_swing_deg"]
        assert row["peak_effort.trolley"] == run.summary["peak_effort"]["trolley"]
    assert len({row["state_sha256"] for row in rows}) == 16


def test_a_cluster_writes_the_same_table(whole: studies.StudyResult, tmp_path: Path) -> None:
    """Workers of a Dask cluster write the table of plain processes.

    An address without a scheduler is an error of one line.
    """
    found = studies.run(STUDY, tmp_path / "cluster", workers=1, scheduler="local")
    assert without_times(found.table) == without_times(whole.table)


def test_a_result_is_pickled(whole: studies.StudyResult) -> None:
    """A result that was read from, as by another process, has the same columns."""
    names = list(whole.types)
    copy = pickle.loads(pickle.dumps(whole))
    assert list(copy.types) == names and len(copy) == len(whole)


def test_a_finished_study_runs_nothing(whole: studies.StudyResult) -> None:
    """The same study in its folder is read, not run: not even the times differ."""
    counts: list[tuple[int, int]] = []
    again = studies.run(STUDY, whole.folder, on_progress=lambda *count: counts.append(count))
    assert counts == [(16, 16)] and again.table == whole.table
    with pytest.raises(SceneError, match="holds another study; name another folder"):
        studies.run(STUDY | {"seed": 3}, whole.folder)


@pytest.fixture(scope="module")
def failing(tmp_path_factory: pytest.TempPathFactory) -> studies.StudyResult:
    """Return a study with runs that fail and scenes that are not possible."""
    return studies.run(FAILING, tmp_path_factory.mktemp("study") / "failing", workers=1)


def test_a_run_that_fails_is_a_row(failing: studies.StudyResult) -> None:
    """Failed and impossible runs are rows with status and reason.

    Metrics stand there up to where the run failed.
    """
    rows = failing.table.to_pylist()
    assert [row["status"] for row in rows] == ["ok", "failed", "refused", "refused"]
    assert "travel limit" in rows[1]["error"] and 0.0 < rows[1]["sim_time"] < 5.0
    assert "-1.0" in rows[2]["error"] and rows[2]["state_sha256"] is None
    assert failing.failed("stiff").tolist() == [True, True] and failing.failed(
        "energy"
    ).tolist() == [False, True]


def test_failures_are_recorded(failing: studies.StudyResult) -> None:
    """The failed run has a recording, with the bits of its row; a refused scene has none."""
    (file,) = (failing.folder / "recordings").iterdir()
    assert file.name == "000001.rrd"
    assert (
        crane_sim.read_recording(file).summary["state_sha256"]
        == failing.table["state_sha256"][1].as_py()
    )


def test_a_recording_that_a_killed_study_left_is_made_anew(
    failing: studies.StudyResult, tmp_path: Path
) -> None:
    """Half a recording is removed, not recovered beside the whole one, which has the same bits."""
    folder = Path(shutil.copytree(failing.folder, tmp_path / "study"))
    (file,) = (folder / "recordings").iterdir()
    file.rename(unfinished_name(file))
    record_selected(studies.read_result(folder))
    assert [each.name for each in (folder / "recordings").iterdir()] == ["000001.rrd"]


PROGRAM = """
import sys, json
from crane_sim import study
if __name__ == "__main__":
    study.run(json.loads(sys.argv[1]), sys.argv[2], workers=2)
"""


@pytest.mark.parametrize("kills", [2, pytest.param(20, marks=pytest.mark.long)])
def test_a_killed_study_goes_on(whole: studies.StudyResult, tmp_path: Path, kills: int) -> None:
    """A study killed at random instants and begun again has the undisturbed one's table.

    Its processes are killed with it.

    Blocks that are on disk when it is killed are not touched again. Two processes run it, one the
    undisturbed one.
    """
    folder, program, rng = (
        tmp_path / "killed",
        tmp_path / "program.py",
        np.random.default_rng(kills),
    )
    program.write_text(PROGRAM)
    many = STUDY | {"samples": 64, "duration": 4.0}
    command = [sys.executable, str(program), json.dumps(many), str(folder)]
    kept: dict[str, int] = {}
    for _ in range(kills):
        process = subprocess.Popen(command)
        time.sleep(float(rng.uniform(0.5, 3.0)))  # any instant will do: start, runs or the end
        workers = Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        os.kill(process.pid, signal.SIGKILL)
        process.wait(10.0)
        for pid in workers:
            wait_exited(int(pid))
        now = (
            {file.name: file.stat().st_mtime_ns for file in (folder / "rows").glob("0*")}
            if folder.exists()
            else {}
        )
        assert kept.items() <= now.items() or (folder / "table.parquet").exists()
        kept = now
    result = studies.run(many, folder, workers=2)
    undisturbed = studies.run(many, tmp_path / "undisturbed", workers=1)
    assert without_times(result.table) == without_times(undisturbed.table)


@pytest.mark.parametrize(
    "send",
    [
        pytest.param(os.kill, id="process"),
        pytest.param(os.killpg, id="terminal", marks=pytest.mark.long),
    ],
)
def test_an_interrupted_sweep_ends_in_one_line(
    send: Callable[[int, int], None], tmp_path: Path
) -> None:
    """SIGINT to `crane sweep` gives one line, and no process remains.

    It goes to the workers, too, as a terminal sends it.
    """
    file, rows = tmp_path / "study.yaml", tmp_path / "folder" / "rows"
    file.write_text(yaml.safe_dump(STUDY | {"samples": 65536}))
    command = [CRANE, "sweep", str(file), "-o", str(tmp_path / "folder"), "--workers", "2"]
    with started_program(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        wait_until(lambda: any(rows.glob("0*")) or process.poll() is not None, "rows")
        workers = [
            int(pid)
            for pid in Path(f"/proc/{process.pid}/task/{process.pid}/children").read_text().split()
        ]
        send(process.pid, signal.SIGINT)
        shown = process.communicate(timeout=LIMIT)
        assert (process.returncode, *shown) == (1, "", "crane: interrupted\n")
        assert len(workers) == 3  # with Python's own, which removes what is left of semaphores
        for pid in workers:
            wait_exited(pid)


@pytest.mark.long
def test_workers_of_a_cluster_that_are_killed_lose_nothing(tmp_path: Path) -> None:
    """Up to twenty killed workers of a Dask cluster do not change the table of a study."""
    dask, distributed = pytest.importorskip("dask"), pytest.importorskip("distributed")
    # a local cluster gives a worker up that is not there 15 s after one of its name ended: it may
    # just start again
    patience = {"distributed.deploy.lost-worker-timeout": "1h"}
    many, rng, kills = STUDY | {"samples": 8192}, np.random.default_rng(4), 0
    options = {"threads_per_worker": 1, "host": "127.0.0.1", "dashboard_address": None}
    with (
        dask.config.set(patience),
        distributed.LocalCluster(n_workers=2, **options) as cluster,
        ThreadPoolExecutor(1) as thread,
    ):
        address = cluster.scheduler_address
        study = thread.submit(studies.run, many, tmp_path / "killed", scheduler=address)
        while kills < 20 and not study.done():
            # any instant will do, after some progress since the last one
            time.sleep(float(rng.uniform(0.1, 0.5)))
            if len(list((tmp_path / "killed" / "rows").glob("0*"))) < 3 * kills:
                continue
            # one that has joined: its nanny starts another one
            nannies, joined = cluster.workers.values(), cluster.scheduler.workers
            alive = [
                pid for nanny in nannies if nanny.worker_address in joined and (pid := nanny.pid)
            ]
            with suppress(ProcessLookupError):  # it has ended by itself
                if alive:
                    os.kill(int(rng.choice(alive)), signal.SIGKILL)
                    kills += 1
        table = study.result(500.0).table
    assert kills >= 5  # 20 unless the study ends between two looks at it
    plain = studies.run(many, tmp_path / "plain", workers=2).table
    assert without_times(table) == without_times(plain)


def test_a_study_has_a_page(failing: studies.StudyResult, tmp_path: Path) -> None:
    """`crane report FOLDER` writes one file without requests.

    It has failures first, then each variant's metrics and links to runs.

    Folders without a finished study are refused in one line.
    """
    page = tmp_path / "page.html"
    app(["report", str(failing.folder), "-o", str(page)], standalone_mode=False)
    text = page.read_text()
    assert (
        text.index("Runs that failed")
        < text.index("<h2>Metrics</h2>")
        < text.index("Differences from energy")
    )
    assert "travel limit" in text and text.count("<svg") >= 4
    assert not re.findall(r'(?:src|href)="(?!#|data:|recordings/)[^"]*"', text)
    (tmp_path / "empty").mkdir()
    with pytest.raises(SceneError, match="holds no study"):
        app(["report", str(tmp_path / "empty")], standalone_mode=False)


def test_the_command_prints_a_summary_and_copies_the_study(
    whole: studies.StudyResult, tmp_path: Path
) -> None:
    """`crane sweep --json` prints failures, metrics by variant and their paired differences.

    `--copy-to` puts table, study and the rest of the folder where fsspec finds it; an unknown store
    is refused.
    """
    file, place = tmp_path / "masses.yaml", tmp_path / "store"
    file.write_text(json.dumps(STUDY))  # JSON is YAML
    done = crane(
        "sweep", str(file), "-o", str(whole.folder), "--json", "--copy-to", f"file://{place}/masses"
    )
    assert studies.read_result(place / "masses").table == whole.table
    with pytest.raises(SceneError, match="--copy-to nowhere:"):
        app(
            ["sweep", str(file), "-o", str(tmp_path / "new"), "--copy-to", "nowhere://b/masses"],
            standalone_mode=False,
        )
    assert not (tmp_path / "new").exists()
    printed = json.loads(done.stdout)
    assert printed["runs"] == 16 and printed["failures"] == {"energy": 0, "weak": 0}
    swing = whole.metric("residual_swing_deg", "weak") - whole.metric(
        "residual_swing_deg", "energy"
    )
    assert printed["metrics"]["residual_swing_deg"]["weak - energy"]["mean"] == pytest.approx(
        swing.mean(), rel=1e-12
    )
