"""How children are ended and what is said of them: limits that add up to one, unforeseen errors, forks, helpers."""

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
from crew_helpers import LIMIT, STUBBORN, crew_of, listen_until
from process_helpers import ends_soon, gone, next_line, started_program, wait_until

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.process import ForkedProcess
from crane_sim.orchestration.recovery import recover_bags
from crane_sim.orchestration.shutdown import collect_controller_summary, finish_recording
from crane_sim.orchestration.supervisor import Supervisor
from crane_sim.recording.files import part_of, unfinished_name
from crane_sim.recording.rerun import repair
from crane_sim.recording.rerun.repair import Parts, Previous

FAILING = """
import sys
from crane_sim.ros.common import node_host as process

def body(host, settings):
    raise OSError(5, "the bus is\\ngone")

sys.exit(process.main("odd", {}, body))
"""


def test_all_limits_of_an_early_end_are_one(tmp_path: Path, ros_environment: dict[str, str]) -> None:
    """A plant, a law and a recorder that neither report nor end, and four more nodes, are gone within 3 s."""
    interrupts: list[int] = [signal.SIGINT]
    with crew_of(tmp_path, STUBBORN, ros_environment, interrupts) as crew:
        names = ("plant", "controller", "recorder", *("reserve",) * 4)
        posts: list[Any] = [SimpleNamespace(name=name, active=crew.start(name, "node", "a", {})) for name in names]
        vars(posts[2]).update(path=str(tmp_path / "run.rrd"), mcap="", restarts=0, began=0.0, failed="")
        listen_until(crew, lambda: all(child.ready for child in crew.children))
        nobody: Any = SimpleNamespace()
        conductor, began = Supervisor(crew, posts, interrupts, nobody, 0.0), time.monotonic()
        conductor.stop_early()
        collect_controller_summary(conductor, posts)
        summary = finish_recording(conductor, posts[2], {"steps": 7})
    assert time.monotonic() - began < LIMIT
    assert summary["error"].startswith("recorder: it did not finish the recording")
    assert all(gone(child.pid) for child in crew.children)


def test_an_unforeseen_error_is_named(tmp_path: Path, ros_environment: dict[str, str]) -> None:
    """What a node did not foresee is told in the last line of its exception; another node may yet replace it."""
    with crew_of(tmp_path, FAILING, ros_environment) as crew:
        child = crew.start("odd", "node", "a", {})
        listen_until(crew, lambda: child.gone)
    assert child.fault == "it ended with exit code 1: OSError: [Errno 5] the bus is"
    assert not child.fatal


def forked(*events: dict[str, Any]) -> Child:
    """Return a child of a nursery that reported this, and whose pipe is then closed."""

    def start(_: int, report: int) -> ForkedProcess:
        for event in events:
            os.write(report, json.dumps(event).encode() + b"\n")
        return ForkedProcess()

    child = Child("fork", start)
    while not child.gone:
        child.read()
    return child


def test_how_a_fork_ended_is_known_or_said_to_be_unknown() -> None:
    """A fork without a birth could not be started; one whose nursery is gone ended in a way that nobody knows."""
    assert forked().fault == "it could not be started"
    born = {"event": "born", "pid": 2**22 + 1}  # beyond the largest process id
    assert forked(born).fault == "it ended, nobody knows how"
    assert forked(born, {"event": "ended", "code": -9}).fault == "it was killed by SIGKILL"
    assert forked(born, {"event": "ended", "code": 0}).fault == "it ended with exit code 0"


TIED = """
import os, time
from crane_sim.process_signals import set_parent_death_signal, clear_parent_death_signal
for free in (False, True):
    bind = set_parent_death_signal()
    if not os.fork():
        bind()
        if free:
            clear_parent_death_signal()
        os.write(1, f"{'free' if free else 'tied'} {os.getpid()}\\n".encode())  # one write: never mixed with another
        time.sleep(60)
        os._exit(0)
time.sleep(60)
"""


def test_a_tied_process_ends_with_its_parent() -> None:
    """When a process is killed, the kernel ends the child that is tied to it, and not the one that was untied."""
    with started_program([sys.executable, "-c", TIED], stdout=subprocess.PIPE) as parent:
        told = dict(next_line(parent).split() for _ in range(2))
        tied, free = int(told["tied"]), int(told["free"])
        parent.kill()
        try:
            ends_soon(tied)
            assert not gone(free)
        finally:
            os.kill(free, signal.SIGKILL)


JOINING = """
import sys
from pathlib import Path
from crane_sim.recording.rerun import repair
repair.viewer_program = lambda: Path(sys.argv[1])
repair.optimize_recordings([], Path(sys.argv[2]), repair.countdown(60.0))
"""


def test_joining_takes_no_longer_than_it_may(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Parts that cannot be joined in time stay and are named; who is killed while joining leaves no helper behind."""
    slow, pid = tmp_path / "slow", tmp_path / "pid"
    slow.write_text(f"#!/bin/sh\necho $$ >{pid}\nexec sleep 60\n")
    slow.chmod(0o755)
    parts = [tmp_path / "run.rrd.part", tmp_path / "run.part2.rrd"]
    for part in parts:
        part.touch()
    monkeypatch.setattr(repair, "viewer_program", lambda: slow)
    joint = Parts(tmp_path / "run.rrd", Previous(5, 5, (parts[0],)))
    assert joint.join(parts[1], within=0.0) == parts and not pid.exists()
    assert joint.join(parts[1], within=1.0) == parts and all(part.exists() for part in parts)
    ends_soon(int(pid.read_text()))
    pid.unlink()
    with started_program([sys.executable, "-c", JOINING, str(slow), str(tmp_path / "all.rrd")]) as recorder:
        wait_until(lambda: pid.exists() and bool(pid.read_text().strip()), "the helper that joins")
        recorder.kill()
        ends_soon(int(pid.read_text()))


def test_only_bags_of_this_run_are_named(tmp_path: Path) -> None:
    """A bag of an earlier run is not taken for a part of this one; a part without messages is no part at all."""
    path, endless = str(tmp_path / "run.mcap"), repair.countdown(math.inf)
    Path(path).touch()
    os.utime(path, (1.0, 1.0))
    unfinished_name(part_of(path, 2)).mkdir()
    post: Any = SimpleNamespace(mcap=path, restarts=2, began=time.time() - 1.0)
    assert recover_bags(post, "last.mcap", endless) == {"mcap": "last.mcap"}
    part_of(path, 1).touch()
    assert recover_bags(post, "last.mcap", endless) == {"mcap": "last.mcap", "bag_parts": [path, "last.mcap"]}
    assert recover_bags(post, None, endless) == {"mcap": path}
