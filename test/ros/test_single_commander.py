"""Command lease over DDS: a second publisher is refused by name, until the owner is killed.

It then takes over.
"""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from bench_graph import PERIOD, NodeProcess, Remote, graph, remote, wait_until
from process_helpers import started_program

from crane_sim import load_scene
from crane_sim.ros.common.messages import LIVELINESS_LEASE

COMMANDER = Path(__file__).parents[1] / "programs" / "constant_controller.py"
LONG = f"command_lease:={LIVELINESS_LEASE}"  # s: on a busy machine a process may stall for 0.3 s
SLOWLY = "rate:=0.2"  # in real time: twenty states a second are enough


@contextmanager
def started_commander(
    env: dict[str, str], name: str, effort: float
) -> Iterator[subprocess.Popen[bytes]]:
    """Yield a process that answers every state with one effort."""
    with started_program([sys.executable, COMMANDER, name, str(effort)], env=env) as process:
        yield process


@pytest.fixture(params=["lockstep", "realtime"])
def bench(
    request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[tuple[Remote, dict[str, str]]]:
    """Yield a node and the environment of nodes, beside a running plant without a controller."""
    scene = tmp_path / "endless.yaml"
    load_scene("knuckle_setpoint", {"duration": 1e5}).dump(scene)
    options = (
        f"scene:={scene}",
        "commanded:=true",
        f"mode:={request.param}",
        "expected_controllers:=0",
        LONG,
        SLOWLY,
    )
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        client.node.destroy_publisher(client.commands)
        with NodeProcess("crane_sim.ros.plant_node", env, *options) as plant:
            plant.await_event("ready")
            plant.send("go")
            yield client, env


def is_applied(client: Remote, effort: float) -> bool:
    """Return whether this effort acts on the crane."""
    return bool(client.efforts) and client.efforts[-1][0] == effort


@pytest.mark.long(cases=["lockstep"])
def test_a_second_publisher_waits_for_the_lease(bench: tuple[Remote, dict[str, str]]) -> None:
    """The second of two processes is refused by name, and takes over when the first is killed."""
    client, env = bench
    with started_commander(env, "first", 1.0) as first:
        wait_until(lambda: is_applied(client, 1.0))
        with started_commander(env, "second", 2.0):
            line = "command of /knuckle/second refused: /knuckle/first owns the crane"
            wait_until(lambda: any(line in message for _, message in client.warnings))
            reached = client.states[-1]
            wait_until(lambda: client.states[-1] > reached + 20 * PERIOD)
            assert {effort[0] for effort in client.efforts} <= {0.0, 1.0}
            os.kill(first.pid, signal.SIGKILL)
            wait_until(lambda: is_applied(client, 2.0))
            wait_until(lambda: client.warnings[-1][1] == "running")
