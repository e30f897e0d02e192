"""One commander at a time: a second one is refused by name, and a dead one is replaced at once."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from bench_graph import PERIOD, NodeProcess, Remote, graph, remote, wait_until
from process_helpers import started_program

from crane_sim import load_scene
from crane_sim.ros.common.messages import LEASE
from crane_sim.ros.plant.command_arbiter import CommandLease

FOREIGN = Path(__file__).parents[1] / "programs" / "foreign_commander.py"
LONG = f"command_lease:={LEASE}"  # s: where others keep the cores busy, a process may well stand still for 0.3 s
A, B = b"a" * 16, b"b" * 16


def test_first_come_keeps_the_crane_until_he_is_silent() -> None:
    """Another one's command counts as soon as the commander was silent for longer than the lease, and not before."""
    helm = CommandLease(0.2)
    assert helm.accepts(A, 0.0)
    helm.follow(A, 0.0)
    assert not helm.accepts(B, 0.2)
    helm.follow(A, 0.2)
    assert not helm.accepts(B, 0.4)
    assert helm.accepts(B, 0.41)
    helm.follow(B, 0.41)
    assert not helm.accepts(A, 0.5)


def test_whoever_was_there_alone_is_the_commander() -> None:
    """Who had the topic for himself keeps the crane when a second one comes, from when his lease was renewed."""
    helm = CommandLease(0.2)
    helm.owner = A
    helm.renew(1.0)
    assert not helm.accepts(B, 1.1)
    assert helm.accepts(B, 1.3)


@contextmanager
def commander(env: dict[str, str], name: str, effort: float) -> Iterator[subprocess.Popen[bytes]]:
    """Yield a process that answers every state with one effort."""
    with started_program([sys.executable, FOREIGN, name, str(effort)], env=env) as process:
        yield process


@pytest.fixture(params=["lockstep", "realtime"])
def bench(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[tuple[Remote, dict[str, str]]]:
    """Yield a listener and the environment of nodes beside a running plant, which nobody commands so far."""
    scene = tmp_path / "endless.yaml"
    load_scene("knuckle_setpoint", {"duration": 1e5}).dump(scene)
    options = (f"scene:={scene}", "commanded:=true", f"mode:={request.param}", "expected_controllers:=0", LONG)
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as ours:
        ours.node.destroy_publisher(ours.commands)
        with NodeProcess("crane_sim.ros.plant_node", env, *options) as plant:
            plant.await_event("ready")
            plant.order("go")
            yield ours, env


def applied(ours: Remote, effort: float) -> bool:
    """Return whether this effort acts on the crane."""
    return bool(ours.efforts) and ours.efforts[-1][0] == effort


def test_two_commanders(bench: tuple[Remote, dict[str, str]]) -> None:
    """The second of two real processes is refused by name; when the first is killed it has the crane, lease over."""
    ours, env = bench
    with commander(env, "first", 1.0) as first:
        wait_until(lambda: applied(ours, 1.0))
        with commander(env, "second", 2.0):
            line = "command of /knuckle/second refused: /knuckle/first commands"
            wait_until(lambda: any(line in message for _, message in ours.warnings))
            reached = ours.states[-1]
            wait_until(lambda: ours.states[-1] > reached + 50 * PERIOD)
            assert {effort[0] for effort in ours.efforts} <= {0.0, 1.0}
            os.kill(first.pid, signal.SIGKILL)
            killed = time.monotonic()
            wait_until(lambda: applied(ours, 2.0))
            assert time.monotonic() - killed < 2.0 * LEASE  # s; the lease, and as much again on a busy machine
            wait_until(lambda: ours.warnings[-1][1] == "running")
