"""Watchdog of commands in real time, without ROS and with a plant that only records its efforts."""

import ctypes
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.serialization import serialize_message
from realtime_doubles import JOINTS, FakeSimulation, deliver_to, fake_subscription, settings
from std_msgs.msg import Float64MultiArray

from crane_sim.ros.common.serialization import EFFORT, JointStateCodec
from crane_sim.ros.plant.realtime import Realtime

ONE = ("joint_commands",)  # has a publisher


class OneCommandHost:
    """A host whose only controller sends one command, and then no more."""

    def __init__(self) -> None:
        """Create it without subscriptions."""
        self.stop_reason = self.brake_reason = ""
        self.callbacks: dict[str, Any] = {}
        self.node = SimpleNamespace(get_publishers_info_by_topic=lambda _topic: [])
        self.accepted: list[bytes] = []
        publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=self.accepted.append)
        self.node.create_publisher = lambda *_: publisher
        self.sent: list[float] = []  # s, just before and just after the command

    def spin(self, timeout: float) -> None:
        """Pass the command on the first time, then only let time pass."""
        if not self.sent:
            self.sent.append(time.monotonic())
            self.callbacks["joint_commands"](JointStateCodec(JOINTS, EFFORT).encode(10_000_000, (3.0, 4.0)))
            self.sent.append(time.monotonic())
        time.sleep(timeout)

    def poll(self) -> None:
        """Read no orders."""

    def subscribe_with_sender(self, _type: type, topic: str, callback: Any, *_: Any) -> Any:
        """Return a subscription."""
        self.callbacks[topic] = deliver_to(callback)
        return fake_subscription(topic, topic in ONE)


@pytest.mark.usefixtures("stepped_clock")
@pytest.mark.parametrize(
    ("timeout", "on_silence", "last", "warned"),
    [
        (0.4, "zero", (0.0, 0.0), "no valid command for 0.4 s: zero effort"),
        (0.4, "hold", (3.0, 4.0), "no valid command for 0.4 s: the last effort holds"),
        (0.4, "brake", (3.0, 4.0), "no valid command for 0.4 s: the brakes act"),
        (0.0, "zero", (3.0, 4.0), ""),
    ],
)
def test_the_timeout_action_follows_a_silent_controller(
    timeout: float, on_silence: str, last: tuple[float, ...], warned: str
) -> None:
    """The last command holds until the time-out, then the chosen action follows, with a warning; 0: no time-out."""
    host, simulation = OneCommandHost(), FakeSimulation()
    realtime = Realtime(host, simulation, settings(timeout, on_silence))  # type: ignore[arg-type]
    realtime.run()
    assert simulation.efforts[0] == (3.0, 4.0)
    assert simulation.efforts[-1] == last
    assert simulation.warning == warned
    if warned:  # with the first step after the time-out, not with the one before
        assert simulation.times[simulation.warned - 2] - host.sent[1] <= timeout
        assert simulation.times[simulation.warned] - host.sent[0] > timeout
    assert simulation.plant.braking == (on_silence == "brake")
    assert realtime.metrics()["silences"] == bool(warned)


def array_message(numbers: list[float]) -> bytes:
    """Return the serialized message of an array."""
    return serialize_message(Float64MultiArray(data=numbers))


def test_an_array_of_the_wrong_size_is_refused() -> None:
    """An array takes effect in joint order when it has one effort per joint, and is refused when it has not."""
    host, simulation = OneCommandHost(), FakeSimulation()
    realtime = Realtime(host, simulation, settings(0.0))  # type: ignore[arg-type]
    host.spin(0.0)
    host.callbacks["effort_controller/commands"](array_message([1.0, 2.0, 3.0]))
    realtime.step_once()
    host.callbacks["effort_controller/commands"](array_message([5.0, 6.0]))
    realtime.step_once()
    assert simulation.efforts == [(3.0, 4.0), (5.0, 6.0)]
    assert simulation.validator.summary() == {"received": 3, "rejected": 1, "late": 0, "duplicate": 0}


@pytest.mark.usefixtures("stepped_clock")
@pytest.mark.parametrize(("late", "counts"), [(1.5, True), (1.7, False)])
def test_a_command_is_stale_by_wall_time(late: float, counts: bool) -> None:
    """At four times real time a command may answer a state that is four time-outs old in simulated time."""
    host, simulation = OneCommandHost(), FakeSimulation()
    realtime = Realtime(host, simulation, settings(0.4, rate=4.0))  # type: ignore[arg-type]
    simulation.stamp = 10_000_000_000
    stamp = simulation.stamp - round(late * 1e9)
    host.callbacks["joint_commands"](JointStateCodec(JOINTS, EFFORT).encode(stamp, (3.0, 4.0)))
    realtime.step_once()
    assert simulation.efforts == [(3.0, 4.0) if counts else (0.0, 0.0)]
    assert simulation.validator.refused == ({} if counts else {"stale": 1})


@pytest.mark.skipif(sys.platform != "linux", reason="timer slack is Linux's")
def test_a_run_sleeps_without_timer_slack() -> None:
    """A real-time run sets the least timer slack, 1 ns, of its thread, here after Linux's default of 50 us."""
    prctl = ctypes.CDLL(None).prctl
    set_slack, get_slack = 29, 30

    def timer_slacks() -> list[int]:
        prctl(set_slack, ctypes.c_ulong(50_000))
        before = prctl(get_slack)
        Realtime(OneCommandHost(), FakeSimulation(3), settings(0.0)).run()  # type: ignore[arg-type]
        return [before, prctl(get_slack)]

    if prctl(get_slack) < 0:
        pytest.skip("this system does not allow to set it")
    with ThreadPoolExecutor(1) as thread:  # its slack is its own
        assert thread.submit(timer_slacks).result(timeout=60.0) == [50_000, 1]
