"""Polled subscriptions of a recorder: every message, in the order of sending."""

import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from threading import Thread
from typing import Any

import pytest
import rclpy
from bench_graph import graph
from message_burst import COUNT, TOPICS
from process_helpers import started_program, wait_until
from rclpy.context import Context
from rclpy.node import Node

from crane_sim import load_scene
from crane_sim.ros.common.serialization import EFFORT, JointStateCodec
from crane_sim.ros.plant.topics import PlantTopics
from crane_sim.ros.recorder import subscriptions
from crane_sim.ros.recorder.subscriptions import NAMES, PolledSubscription, RecorderSubscriptions

BURST = Path(__file__).parents[1] / "programs" / "message_burst.py"
SCENE = load_scene("knuckle_setpoint")


@contextmanager
def subscriber_node(domain: int) -> Iterator[Node]:
    """Yield a node of this process."""
    context = Context()
    context.init(domain_id=domain)
    node = rclpy.create_node("subscriber", context=context)
    try:
        yield node
    finally:
        node.destroy_node()
        context.shutdown()


def test_pending_messages_are_complete_and_in_order(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Thousands of messages on three topics are dispatched completely, in order, however rarely."""
    codec = JointStateCodec(SCENE.actuated, EFFORT)
    received: list[tuple[str, int]] = []

    def record(name: str, data: bytes) -> None:
        received.append((name, codec.decode(data).stamp))

    sent = [(name, k) for k in range(1, COUNT + 1) for name in TOPICS]
    with graph(tmp_path, monkeypatch) as (domain, env), subscriber_node(domain) as node:
        recorder = RecorderSubscriptions(node, [{name: partial(record, name) for name in TOPICS}])
        with started_program([sys.executable, BURST], env=env, stdin=subprocess.PIPE):

            def complete() -> bool:
                time.sleep(0.15)  # hundreds of steps: some polls are in the middle of one
                recorder.dispatch()
                return len(received) >= len(sent)

            wait_until(complete, f"{len(sent)} messages")
    assert received == sent


def test_a_plant_that_has_discovered_a_recorder_has_discovered_all_of_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A plant waits for a recorder's last subscriptions: then /clock and poses are matched, too.

    Else transforms of the first steps are missing in a bag, of a short run all of them.
    """

    class SlowSubscription(PolledSubscription):
        def __init__(self, *arguments: Any) -> None:
            time.sleep(0.1)  # longer than a discovery in this process
            super().__init__(*arguments)

    monkeypatch.setattr(subscriptions, "PolledSubscription", SlowSubscription)
    with (
        graph(tmp_path, monkeypatch) as (domain, _),
        subscriber_node(domain) as node,
        subscriber_node(domain) as other,
    ):
        topics = PlantTopics(other, SCENE.joint_names, SCENE.actuated, sensed=True)
        recorder = Thread(target=RecorderSubscriptions, args=(node, [dict.fromkeys(NAMES, bytes)]))
        recorder.start()
        try:
            wait_until(lambda: not topics.missing(1, 1), "the recorder")
            topics.update_subscribers()
        finally:
            recorder.join()
    assert topics.clock_subscribed and topics.payload_subscribed and topics.effort_subscribed
