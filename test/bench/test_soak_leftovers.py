"""Failures of the soak of interruptions."""

import os
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

from process_helpers import next_line, started_program
from recording_samples import RowWriter, rows_at_rest

from crane_bench.soak import signals
from crane_bench.soak.leftovers import MARK, RECORDING, of_run, orphans
from crane_sim import load_scene


def test_files_are_those_of_a_complete_run_or_of_none(tmp_path: Path) -> None:
    """A run without a received step may leave nothing.

    Steps without a recording, and other files, are failures.
    """
    assert of_run(tmp_path, 0) == []
    assert of_run(tmp_path, 5) == ["no recording of 5 steps"]
    (tmp_path / "run.recovered.rrd").touch()
    assert of_run(tmp_path, 0) == ["left: run.recovered.rrd"]


def test_a_recording_has_all_received_steps(tmp_path: Path) -> None:
    """It may have more steps than a late subscriber has received, but not fewer."""
    scene = load_scene("knuckle_setpoint", {"duration": 0.1})
    session = RowWriter(scene, tmp_path / RECORDING)
    session.write_rows(rows_at_rest(scene, 10))
    session.finish({"scene": scene.name, "steps": 10})
    assert of_run(tmp_path, 10) == of_run(tmp_path, 7) == []
    assert of_run(tmp_path, 11) == ["recording: 10 steps, its summary says 10, received 11"]


def test_a_process_that_outlives_its_run_is_found_and_ended() -> None:
    """It is identified by a variable of its environment, independent of its present parent."""
    env = os.environ | {MARK: "mine"}
    with started_program(
        [sys.executable, "-c", "input()"], stdin=subprocess.PIPE, env=env
    ) as process:
        assert orphans("another's") == []
        (line,) = orphans("mine")
        assert line.startswith("outlives the run: ") and process.wait(60.0) == -signal.SIGKILL


def test_a_process_that_holds_the_pipes_of_its_run_is_a_failure() -> None:
    """A run's output is waited for no longer than permitted.

    What outlives the run and holds it is named, and ended.
    """
    child = [sys.executable, "-c", "import time; time.sleep(600.0)"]
    program = f"import subprocess; subprocess.Popen({child!r}); print('ready', flush=True)"
    ends: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with started_program(
        [sys.executable, "-c", program], env=os.environ | {MARK: "held"}, **ends
    ) as process:
        assert next_line(process) == "ready\n"
        process.wait(60.0)
        _, (line,) = signals._wait_for_pipes(process, "held", 0.2)
    assert line.startswith("outlives the run: ")
