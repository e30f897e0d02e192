"""What a recorder hears of a run: every message, in the order of sending, although nothing wakes it up."""

import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import pytest
import rclpy
from rclpy.context import Context
from sensor_msgs.msg import JointState

from crane_sim import load_scene
from crane_sim.orchestration.children import environment, reserved_domain
from crane_sim.ros import messages
from crane_sim.ros.hearing import Hearing
from crane_sim.ros.wire import JointWire

SCENE = load_scene("knuckle_setpoint")


def wait_until(done: Callable[[], bool]) -> None:
    """Return when it is done, or after ten seconds in any case."""
    deadline = time.monotonic() + 10.0
    while not done() and time.monotonic() < deadline:
        time.sleep(0.01)


def test_what_waits_is_heard_whole_and_in_order(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thousands of messages on three topics come out complete and in the order of sending, however rarely fetched."""
    with reserved_domain() as domain:
        for key, value in environment(domain, tmp_path).items():
            monkeypatch.setenv(key, value)
        context = Context()
        context.init(domain_id=domain)
        node, wire = rclpy.create_node("burst", context=context), JointWire(SCENE.actuated, effort=True)
        heard: list[tuple[str, int]] = []
        topics = ("joint_states", "joint_commands", "applied_effort")
        speakers = {name: node.create_publisher(JointState, name, messages.DEEP_STREAM) for name in topics}

        def note(name: str, data: bytes) -> None:
            heard.append((name, wire.decode(data).stamp))

        takers = {name: partial(note, name) for name in topics}
        hearing = Hearing(node, [takers])
        wait_until(lambda: not hearing.missing() and all(topic.get_subscription_count() for topic in speakers.values()))
        said = [(name, k) for k in range(1, 4001) for name in topics]
        for number, (name, k) in enumerate(said):
            speakers[name].publish(wire.encode(k, (0.0,) * len(SCENE.actuated)))
            if number % 5000 == 1:  # in the midst of a step
                hearing.pass_on()
        wait_until(lambda: hearing.pass_on() or len(heard) >= len(said))
        node.destroy_node()
        context.shutdown()
    assert heard == said
