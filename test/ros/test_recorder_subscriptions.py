"""What a recorder hears of a run: every message, in the order of sending, although nothing wakes it up."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path

import pytest
import rclpy
from bench_graph import graph
from burst import COUNT, TOPICS
from process_helpers import started_program
from rclpy.context import Context
from rclpy.node import Node

from crane_sim import load_scene
from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.recorder.subscriptions import RecorderSubscriptions

BURST = Path(__file__).parents[1] / "programs" / "burst.py"
SCENE = load_scene("knuckle_setpoint")
PATIENCE = 60.0  # s, only so that a failure ends


@contextmanager
def listener(domain: int) -> Iterator[Node]:
    """Yield a node of this process that only listens."""
    context = Context()
    context.init(domain_id=domain)
    node = rclpy.create_node("listener", context=context)
    try:
        yield node
    finally:
        node.destroy_node()
        context.shutdown()


def test_what_waits_is_heard_whole_and_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of messages on three topics come out complete and in the order of sending, however rarely fetched."""
    wire = JointWire(SCENE.actuated, effort=True)
    heard: list[tuple[str, int]] = []

    def note(name: str, data: bytes) -> None:
        heard.append((name, wire.decode(data).stamp))

    said = [(name, k) for k in range(1, COUNT + 1) for name in TOPICS]
    with graph(tmp_path, monkeypatch) as (domain, env), listener(domain) as node:
        hearing = RecorderSubscriptions(node, [{name: partial(note, name) for name in TOPICS}])
        with started_program([sys.executable, BURST], env=env, stdin=subprocess.PIPE):
            deadline = time.monotonic() + PATIENCE
            while len(heard) < len(said) and time.monotonic() < deadline:
                time.sleep(0.15)  # hundreds of steps: some end in the midst of one
                hearing.dispatch()
    assert heard == said
