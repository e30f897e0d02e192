"""Shutdown of a run: fail-over of a recorder killed over its files, signals, and the error."""

import signal
import threading
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from process_group_helpers import IGNORES_SIGTERM, LIMIT, listen_until, make_group
from process_helpers import wait_exited, wait_until

from crane_sim.orchestration import process_group, shutdown
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.roles import RecorderRole, RoleSpec
from crane_sim.orchestration.shutdown import finish_recording
from crane_sim.orchestration.supervisor import Callbacks, Supervisor
from crane_sim.recording.rerun import repair

RECORDER = """
import json, os, signal, sys

def main():
    control, report = (
        next(int(word.partition(":=")[2]) for word in sys.argv if word.startswith(name))
        for name in ("control", "report")
    )
    send = lambda **event: os.write(report, (json.dumps(event) + "\\n").encode())
    send(event="ready")
    standby = any(word.startswith("standby") for word in sys.argv)
    for line in os.fdopen(control):
        word, _, argument = line.partition(" ")
        if word == "go":
            before = json.loads(argument)
        elif not argument.strip():
            return 0
        elif standby:
            send(event="done", summary={"recording": "run.rrd", "recorded_steps": before["recorded"], "lost_steps": 0})
        else:
            send(event="progress", step=70, recorded=70)
            os.kill(os.getpid(), signal.SIGKILL)
"""  # noqa: E501


def test_a_recorder_that_dies_over_its_files_is_replaced(
    tmp_path: Path, ros_environment: dict[str, str]
) -> None:
    """Killed after the plant's last step, it is replaced by a standby from its last report."""
    (tmp_path / "node.py").write_text(RECORDER)
    news: list[str] = []
    with ProcessGroup(ros_environment | {"PYTHONPATH": str(tmp_path)}) as group:
        role = RecorderRole(
            group,
            RoleSpec("recorder", "node", "a", {"path": str(tmp_path / "run.rrd"), "mcap": ""}),
            True,
        )
        listen_until(group, lambda: role.active.ready and role.standbys_ready)
        plant: Any = SimpleNamespace(name="plant", active=SimpleNamespace(step=64, pid=1))
        callbacks = Callbacks(lambda step: None, news.append, lambda name, pid: None)
        summary = finish_recording(
            Supervisor(group, [plant, role], [], callbacks, 0.0), role, {"steps": 70}
        )
    assert news == ["recorder: it was killed by SIGKILL; replaced"]
    assert summary.pop("restarts") == {"recorder": 1}
    assert summary == {"steps": 70, "recording": "run.rrd", "recorded_steps": 70, "lost_steps": 0}


def test_a_signal_ends_the_repair_of_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A signal ends the recovery of a killed recorder's files.

    It ends the repair program, which takes a minute, too.
    """
    slow, pid, part = tmp_path / "slow", tmp_path / "pid", tmp_path / "run.rrd.part"
    slow.write_text(f"#!/bin/sh\necho $$ >{pid}\nexec sleep 60\n")
    slow.chmod(0o755)
    monkeypatch.setattr(repair, "rerun_executable", lambda: slow)
    interrupts, why = list[int](), "recorder: it was killed by SIGKILL"
    with ProcessGroup({}, interrupts) as group:
        dead: Any = SimpleNamespace(
            ready=True,
            exited=True,
            summary=None,
            recorded=5,
            lost_commands=1,
            fault="it was killed by SIGKILL",
        )
        dead.send = lambda line: None
        dead.send_signal, dead.wait_for_exit = (lambda number: None), (lambda deadline: True)
        role: Any = SimpleNamespace(name="recorder", active=dead, restarts=0, failure=why)
        vars(role).update(
            path=str(tmp_path / "run.rrd"), mcap="", start_time=0.0, fail_over=lambda step: False
        )
        part.touch()
        plant: Any = SimpleNamespace(name="plant", active=SimpleNamespace(step=7))
        no_callbacks: Any = SimpleNamespace()
        interrupted = list[float]()

        def interrupt() -> None:
            wait_until(lambda: pid.exists() and bool(pid.read_text().strip()), "the repair program")
            interrupted.append(time.monotonic())
            interrupts.append(signal.SIGTERM)

        threading.Thread(target=interrupt, daemon=True).start()
        summary = finish_recording(
            Supervisor(group, [plant, role], interrupts, no_callbacks, 0.0), role, {"steps": 7}
        )
    assert time.monotonic() - interrupted[0] < LIMIT
    wait_exited(int(pid.read_text()))
    assert summary["error"] == f"{why}; {part} is incomplete, it has 5 of 7 steps"
    # two were not recorded, one lacks its command
    assert (summary["lost_steps"], summary["lost_commands"]) == (3, 1)


def test_a_signal_shortens_the_grace_period(
    tmp_path: Path, ros_environment: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A node that ignores SIGTERM is killed after its grace period, which a signal shortens."""
    monkeypatch.setattr(process_group, "_GRACE", (60.0, 2.0))
    interrupts: list[int] = []
    with make_group(tmp_path, IGNORES_SIGTERM, ros_environment, interrupts) as group:
        child = group.start("stubborn", "node", "a", {})
        listen_until(group, lambda: child.ready)
        threading.Timer(0.3, interrupts.append, [signal.SIGTERM]).start()
        began = time.monotonic()
    assert time.monotonic() - began < 0.3 + LIMIT


def error_of(
    monkeypatch: pytest.MonkeyPatch,
    run_error: str,
    report: dict[str, Any] | None,
    failure: str = "",
) -> str:
    """Return the summary's error of a run with its error, and a recorder's report or failure."""
    monkeypatch.setattr(shutdown, "_finish_or_kill", lambda *_: report)
    monkeypatch.setattr(
        shutdown,
        "recover_recordings",
        lambda *_: {"recording": "run.recovered.rrd", "recorded_steps": 5},
    )
    supervisor: Any = SimpleNamespace(time_left=1.0, plant=SimpleNamespace(step=9))
    role: Any = SimpleNamespace(
        path="run.rrd", mcap="", failure=failure, active=SimpleNamespace(fault=""), start_time=0.0
    )
    summary = {"steps": 9} | ({"error": run_error} if run_error else {})
    return finish_recording(supervisor, role, summary).get("error", "")


def test_the_recorder_s_error_follows_the_run_s(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither hides the other; a recording unfinished by an interruption is no further error."""
    whole = {"recording": "run.rrd", "recorded_steps": 9, "lost_steps": 0}
    full = {
        "recording": "run.rrd.part",
        "recorded_steps": 5,
        "lost_steps": 4,
        "error": "recorder: disk full",
    }
    died = "recorder: it was killed by SIGKILL"
    incomplete = f"{died}; run.recovered.rrd is incomplete, it has 5 of 9 steps"
    assert error_of(monkeypatch, "", whole) == ""
    assert error_of(monkeypatch, "interrupted", full) == "interrupted; recorder: disk full"
    assert error_of(monkeypatch, "", full) == "recorder: disk full"
    assert error_of(monkeypatch, "interrupted", None, died) == f"interrupted; {incomplete}"
    assert error_of(monkeypatch, "", None, died) == incomplete
    assert error_of(monkeypatch, "interrupted", None) == "interrupted"
