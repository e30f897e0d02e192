"""While a run is being closed: a recorder that dies over its files, a signal that comes, what the last line says."""

import signal
import threading
import time
from collections.abc import Mapping
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from crew_helpers import LIMIT, STUBBORN, crew_of, listen_until
from process_helpers import ends_soon

from crane_sim.orchestration import shutdown
from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process_group import ProcessGroup
from crane_sim.orchestration.roles import RecorderRole, RoleSpec
from crane_sim.orchestration.shutdown import finish_recording
from crane_sim.orchestration.supervisor import Callbacks, Supervisor
from crane_sim.recording.rerun import repair

RECORDER = """
import json, os, signal, sys
control, report = (
    next(int(word.partition(":=")[2]) for word in sys.argv if word.startswith(name)) for name in ("control", "report")
)
tell = lambda **event: os.write(report, (json.dumps(event) + "\\n").encode())
tell(event="ready")
heir = any(word.startswith("standby") for word in sys.argv)
for line in os.fdopen(control):
    word, _, told = line.partition(" ")
    if word == "go":
        before = json.loads(told)
    elif not told.strip():
        break
    elif heir:
        tell(event="done", summary={"recording": "run.rrd", "recorded_steps": before["recorded"], "lost_steps": 0})
    else:
        tell(event="progress", step=70, recorded=70)
        os.kill(os.getpid(), signal.SIGKILL)
"""


class Unforked(ProcessGroup):
    """A crew that starts whoever stands by as it starts all others."""

    def fork(self, name: str, module: str, namespace: str, settings: Mapping[str, object]) -> Child:
        """Start a node."""
        return self.start(name, module, namespace, settings)


def test_a_recorder_that_dies_over_its_files_is_replaced(tmp_path: Path, ros_environment: dict[str, str]) -> None:
    """Killed behind the plant's last step, it is followed by one who knows what the last report said, and ends well."""
    (tmp_path / "node.py").write_text(RECORDER)
    news: list[str] = []
    with Unforked(ros_environment | {"PYTHONPATH": str(tmp_path)}) as crew:
        post = RecorderRole(
            crew, RoleSpec("recorder", "node", "a", {"path": str(tmp_path / "run.rrd"), "mcap": ""}), True
        )
        listen_until(crew, lambda: post.active.ready and post.standbys_ready)
        plant: Any = SimpleNamespace(name="plant", active=SimpleNamespace(step=64, pid=1))
        telling = Callbacks(lambda step: None, news.append, lambda name, pid: None)
        summary = finish_recording(Supervisor(crew, [plant, post], [], telling, 0.0), post, {"steps": 70})
    assert news == ["recorder: it was killed by SIGKILL; replaced"]
    assert summary.pop("restarts") == {"recorder": 1}
    assert summary == {"steps": 70, "recording": "run.rrd", "recorded_steps": 70, "lost_steps": 0}


def test_a_signal_ends_the_repair_of_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """While what a killed recorder left is being recovered, a signal ends that within 3 s, and with it the program."""
    slow, pid, part = tmp_path / "slow", tmp_path / "pid", tmp_path / "run.rrd.part"
    slow.write_text(f"#!/bin/sh\necho $$ >{pid}\nexec sleep 60\n")
    slow.chmod(0o755)
    monkeypatch.setattr(repair, "viewer_program", lambda: slow)
    interrupts, why = list[int](), "recorder: it was killed by SIGKILL"
    with ProcessGroup({}, interrupts) as crew:
        dead: Any = SimpleNamespace(
            ready=True, gone=True, summary=None, recorded=5, fault="it was killed by SIGKILL", order=lambda line: None
        )
        dead.send_signal, dead.ended_by = (lambda number: None), (lambda instant: True)
        post: Any = SimpleNamespace(name="recorder", active=dead, restarts=0, failed=why)
        vars(post).update(path=str(tmp_path / "run.rrd"), mcap="", began=0.0, fail_over=lambda step: False)
        part.touch()
        plant: Any = SimpleNamespace(name="plant", active=SimpleNamespace(step=7))
        nobody: Any = SimpleNamespace()
        threading.Timer(0.3, interrupts.append, [signal.SIGTERM]).start()
        began = time.monotonic()
        summary = finish_recording(Supervisor(crew, [plant, post], interrupts, nobody, 0.0), post, {"steps": 7})
    assert time.monotonic() - began < 0.3 + LIMIT
    ends_soon(int(pid.read_text()))
    assert summary["error"] == f"{why}; {part} is incomplete, it has 5 of 7 steps"


def test_a_signal_hurries_processes_that_do_not_end(tmp_path: Path, ros_environment: dict[str, str]) -> None:
    """A node that ignores SIGTERM has seven seconds in the end, and less than three from a signal on."""
    interrupts: list[int] = []
    with crew_of(tmp_path, STUBBORN, ros_environment, interrupts) as crew:
        child = crew.start("stubborn", "node", "a", {})
        listen_until(crew, lambda: child.ready)
        threading.Timer(0.3, interrupts.append, [signal.SIGTERM]).start()
        began = time.monotonic()
    assert time.monotonic() - began < 0.3 + LIMIT


def last_line(monkeypatch: pytest.MonkeyPatch, first: str, own: dict[str, Any] | None, vacant: str = "") -> str:
    """Return the error of a run that has this one itself, and whose recorder says this."""
    monkeypatch.setattr(shutdown, "_wait_finished", lambda *_: own)
    monkeypatch.setattr(
        shutdown, "recover_recordings", lambda *_: {"recording": "run.recovered.rrd", "recorded_steps": 5}
    )
    conductor: Any = SimpleNamespace(left=1.0, plant=SimpleNamespace(step=9))
    post: Any = SimpleNamespace(path="run.rrd", mcap="", failed=vacant, active=SimpleNamespace(fault=""), began=0.0)
    summary = {"steps": 9} | ({"error": first} if first else {})
    return finish_recording(conductor, post, summary).get("error", "")


def test_what_the_recorder_says_stands_behind_what_ended_the_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither hides the other; what an interruption itself has left undone is no further error."""
    whole = {"recording": "run.rrd", "recorded_steps": 9, "lost_steps": 0}
    full = {"recording": "run.rrd.part", "recorded_steps": 5, "lost_steps": 4, "error": "recorder: disk full"}
    died = "recorder: it was killed by SIGKILL"
    behind = f"{died}; run.recovered.rrd is incomplete, it has 5 of 9 steps"
    assert last_line(monkeypatch, "", whole) == ""
    assert last_line(monkeypatch, "interrupted", full) == "interrupted; recorder: disk full"
    assert last_line(monkeypatch, "", full) == "recorder: disk full"
    assert last_line(monkeypatch, "interrupted", None, died) == f"interrupted; {behind}"
    assert last_line(monkeypatch, "", None, died) == behind
    assert last_line(monkeypatch, "interrupted", None) == "interrupted"
