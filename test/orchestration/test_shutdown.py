"""Exit of child processes: deadline, unforeseen errors, forks, parent death, repair programs."""

import json
import math
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from process_group_helpers import IGNORES_SIGTERM, LIMIT, listen_until, make_group
from process_helpers import has_exited, next_line, started_program, wait_exited, wait_until

from crane_sim.orchestration import process
from crane_sim.orchestration.child import Child
from crane_sim.orchestration.recovery import recover_bags
from crane_sim.orchestration.shutdown import collect_controller_summary, finish_recording
from crane_sim.orchestration.supervisor import Supervisor
from crane_sim.recording.files import part_of, unfinished_name
from crane_sim.recording.rerun import repair
from crane_sim.recording.rerun.repair import EarlierFiles, Parts

FAILING = """
from crane_sim.ros.common import node_host

def body(host, settings):
    raise OSError(5, "the bus is\\ngone")

def main():
    return node_host.main("odd", {}, body)
"""


def test_an_early_end_has_one_deadline(tmp_path: Path, ros_environment: dict[str, str]) -> None:
    """Plant, law, recorder and standbys that neither report nor exit are killed at one deadline.

    There are four standbys.
    """
    interrupts: list[int] = [signal.SIGINT]
    with make_group(tmp_path, IGNORES_SIGTERM, ros_environment, interrupts) as group:
        names = ("plant", "controller", "recorder", *("standby",) * 4)
        roles: list[Any] = [
            SimpleNamespace(name=name, active=group.start(name, "node", "a", {})) for name in names
        ]
        vars(roles[2]).update(
            path=str(tmp_path / "run.rrd"), mcap="", restarts=0, start_time=0.0, failure=""
        )
        listen_until(group, lambda: all(child.ready for child in group.children))
        no_callbacks: Any = SimpleNamespace()
        supervisor, began = (
            Supervisor(group, roles, interrupts, no_callbacks, 0.0),
            time.monotonic(),
        )
        supervisor.stop_early()
        collect_controller_summary(supervisor, roles)
        summary = finish_recording(supervisor, roles[2], {"steps": 7})
    assert time.monotonic() - began < LIMIT
    assert summary["error"].startswith("recorder: it did not finish the recording")
    assert all(has_exited(child.pid) for child in group.children)


def test_an_unforeseen_error_is_reported(tmp_path: Path, ros_environment: dict[str, str]) -> None:
    """An unforeseen error is reported as its exception's last line, and allows a restart."""
    with make_group(tmp_path, FAILING, ros_environment) as group:
        child = group.start("odd", "node", "a", {})
        listen_until(group, lambda: child.exited)
    assert child.fault == "it ended with exit code 1: OSError: [Errno 5] the bus is"
    assert not child.fatal


INTERRUPTED = """
import os, signal, sys

os.kill(os.getppid(), signal.SIGINT)  # while it and its fork start
os.kill(os.getpid(), signal.SIGINT)

def main():
    fd = next(int(word.partition(":=")[2]) for word in sys.argv if word.startswith("report_fd"))
    os.write(fd, b'{"event": "ready"}\\n')
    signal.pause()
"""


def test_an_interrupted_fork_server_goes_on(
    tmp_path: Path, ros_environment: dict[str, str], capfd: pytest.CaptureFixture[str]
) -> None:
    """SIGINT to the fork server alone, or a fork that imports its node, is ignored.

    The supervisor ends them.
    """
    with make_group(tmp_path, INTERRUPTED, ros_environment) as group:
        first = group.start("first", "node", "a", {})
        assert group._fork_server
        os.kill(group._fork_server.pid, signal.SIGINT)  # as it starts
        listen_until(group, lambda: first.ready)
        second = group.start("second", "node", "a", {})
        listen_until(group, lambda: second.ready)
        os.kill(second.pid, signal.SIGSTOP)
        wait_until(lambda: group.find_stopped() == {second.pid: "second"}, "the signal")
        os.kill(second.pid, signal.SIGCONT)
    assert "KeyboardInterrupt" not in capfd.readouterr().err


def make_forked_child(*events: dict[str, Any]) -> Child:
    """Return a forked child with these reports, whose pipe is then closed."""

    def start(_: int, report: int) -> None:
        for event in events:
            os.write(report, json.dumps(event).encode() + b"\n")

    child = Child("fork", start)
    while not child.exited:
        child.read()
    return child


def test_the_exit_of_a_fork_is_reported_or_unknown() -> None:
    """A fork that never reported its start could not be started.

    Without the fork server its exit code is unknown.
    """
    assert make_forked_child().fault == "it could not be started"
    started = {"event": "started", "pid": 2**22 + 1}  # beyond the largest process id
    assert make_forked_child(started).fault == "it ended, its exit code is unknown"
    assert (
        make_forked_child(started, {"event": "exited", "code": -9}).fault
        == "it was killed by SIGKILL"
    )
    assert (
        make_forked_child(started, {"event": "exited", "code": 0}).fault
        == "it ended with exit code 0"
    )


FORKED = """
import os, signal, sys

def main():
    name, report = (next(word for word in sys.argv if word.startswith(key)) for key in ("__node", "report_fd"))
    os.write(int(report.partition(":=")[2]), b'{"event": "ready"}\\n')
    if name.endswith("killed"):
        os.kill(os.getpid(), signal.SIGKILL)
    return 0 if name.endswith("ended") else signal.pause()
"""  # noqa: E501


def test_forks_exit_with_their_group(
    tmp_path: Path, ros_environment: dict[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Forks of a server are processes with own names and known exit codes, and all are reaped."""
    # s for the server to reap, on a busy machine
    monkeypatch.setattr(process, "_END_TIMEOUT", LIMIT)
    with make_group(tmp_path, FORKED, ros_environment) as group:
        children = {
            name: group.start(name, "node", "a", {}) for name in ("ended", "killed", "idle")
        }
        listen_until(
            group,
            lambda: (
                children["ended"].exited and children["killed"].exited and children["idle"].ready
            ),
        )
        pids = [child.pid for child in children.values()]
        assert Path(f"/proc/{children['idle'].pid}/comm").read_text() == "node\n"
    assert children["ended"].fault == "it ended with exit code 0"
    assert children["killed"].fault == "it was killed by SIGKILL"
    assert len(set(pids)) == 3 and not any(Path(f"/proc/{pid}").exists() for pid in pids)


def test_a_shutdown_before_the_first_fork_starts_none(
    tmp_path: Path, ros_environment: dict[str, str]
) -> None:
    """A group shut down while its fork server starts ends within its deadline, without a fork."""
    interrupts: list[int] = [signal.SIGINT]
    began = time.monotonic()
    with make_group(tmp_path, FORKED, ros_environment, interrupts) as group:
        child = group.start("idle", "node", "a", {})
    assert time.monotonic() - began < LIMIT
    assert child.pid == 0


PARENT = """
import os, time
from crane_sim.process_signals import set_parent_death_signal, clear_parent_death_signal
for cleared in (False, True):
    bind = set_parent_death_signal()
    if not os.fork():
        bind()
        if cleared:
            clear_parent_death_signal()
        # one write: lines never mix
        os.write(1, f"{'cleared' if cleared else 'bound'} {os.getpid()}\\n".encode())
        time.sleep(60)
        os._exit(0)
time.sleep(60)
"""


def test_a_parent_death_signal_kills_the_child() -> None:
    """When a process is killed, the kernel kills its child with a parent-death signal.

    It does not kill one that cleared the signal.
    """
    with started_program([sys.executable, "-c", PARENT], stdout=subprocess.PIPE) as parent:
        pids = dict(next_line(parent).split() for _ in range(2))
        bound, cleared = int(pids["bound"]), int(pids["cleared"])
        parent.kill()
        try:
            wait_exited(bound)
            assert not has_exited(cleared)
        finally:
            os.kill(cleared, signal.SIGKILL)


JOINING = """
import sys
from pathlib import Path
from crane_sim.recording.rerun import repair
repair.rerun_executable = lambda: Path(sys.argv[1])
repair.join_recordings([], Path(sys.argv[2]), repair.countdown(60.0))
"""


def test_joining_parts_has_a_time_limit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts that cannot be joined in time stay; a recorder killed in joining leaves no process."""
    slow, pid = tmp_path / "slow", tmp_path / "pid"
    slow.write_text(f"#!/bin/sh\necho $$ >{pid}\nexec sleep 60\n")
    slow.chmod(0o755)
    parts = [tmp_path / "run.rrd.part", tmp_path / "run.part2.rrd"]
    for part in parts:
        part.touch()
    monkeypatch.setattr(repair, "rerun_executable", lambda: slow)
    joint = Parts(tmp_path / "run.rrd", EarlierFiles(5, 5, (parts[0],)))
    assert joint.join(parts[1], time_limit=0.0) == parts and not pid.exists()

    def stays_in_parts() -> bool:
        assert joint.join(parts[1], time_limit=1.0) == parts and all(
            part.exists() for part in parts
        )
        return pid.exists() and bool(pid.read_text().strip())  # it had begun

    wait_until(stays_in_parts, "the program that joins")
    wait_exited(int(pid.read_text()))
    pid.unlink()
    with started_program(
        [sys.executable, "-c", JOINING, str(slow), str(tmp_path / "all.rrd")]
    ) as recorder:
        wait_until(lambda: pid.exists() and bool(pid.read_text().strip()), "the program that joins")
        recorder.kill()
        wait_exited(int(pid.read_text()))


def test_only_bags_of_this_run_are_listed(tmp_path: Path) -> None:
    """A bag of an earlier run is no part of this one, nor is a part without messages."""
    path, unlimited = str(tmp_path / "run.mcap"), repair.countdown(math.inf)
    Path(path).touch()
    os.utime(path, (1.0, 1.0))
    unfinished_name(part_of(path, 2)).touch()
    role: Any = SimpleNamespace(mcap=path, restarts=2, start_time=time.time() - 1.0)
    assert recover_bags(role, "last.mcap", unlimited) == {"mcap": "last.mcap"}
    part_of(path, 1).touch()
    assert recover_bags(role, "last.mcap", unlimited) == {
        "mcap": "last.mcap",
        "bag_parts": [path, "last.mcap"],
    }
    assert recover_bags(role, None, unlimited) == {"mcap": path}
