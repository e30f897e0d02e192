"""The watchdog of real time, without ROS and with a plant that only notes its efforts."""

import time
from types import SimpleNamespace
from typing import Any

import pytest
from rclpy.serialization import serialize_message
from realtime_doubles import JOINTS, Handle, NotingStepper, settings
from std_msgs.msg import Float64MultiArray

from crane_sim.ros.common.serialization import JointWire
from crane_sim.ros.plant.realtime import Realtime

ONE = ("joint_commands",)  # has a publisher


class OneCommandHost:
    """A host whose only controller sends one command, and then no more."""

    def __init__(self) -> None:
        """Keep the callbacks that are subscribed."""
        self.stopping = self.brake = ""
        self.callbacks: dict[str, Any] = {}
        self.node = SimpleNamespace(create_subscription=self._subscribe, get_publishers_info_by_topic=lambda _topic: [])
        self.accept_effort: list[bytes] = []
        publisher = SimpleNamespace(get_subscription_count=lambda: 1, publish=self.accept_effort.append)
        self.node.create_publisher = lambda *_: publisher
        self.sent: list[float] = []  # s, just before and just after the command

    def spin(self, timeout: float) -> None:
        """Deliver the command the first time, then only let time pass."""
        if not self.sent:
            self.sent.append(time.monotonic())
            self.callbacks["joint_commands"](JointWire(JOINTS, effort=True).encode(10_000_000, (3.0, 4.0)))
            self.sent.append(time.monotonic())
        time.sleep(timeout)

    def poll(self) -> None:
        """Hear of no order."""

    def _subscribe(self, _type: type, topic: str, callback: Any, _qos: Any, **_options: Any) -> Any:
        self.callbacks[topic] = callback
        return SimpleNamespace(topic_name=topic, handle=Handle(topic in ONE))


@pytest.mark.parametrize(
    ("timeout", "on_silence", "last", "warned"),
    [
        (0.4, "zero", (0.0, 0.0), "no valid command for 0.4 s: zero effort"),
        (0.4, "hold", (3.0, 4.0), "no valid command for 0.4 s: the last effort holds"),
        (0.4, "brake", (3.0, 4.0), "no valid command for 0.4 s: the brakes act"),
        (0.0, "zero", (3.0, 4.0), ""),
    ],
)
def test_a_silent_controller_loses_the_crane(
    timeout: float, on_silence: str, last: tuple[float, ...], warned: str
) -> None:
    """The last command holds until the time-out, then comes what was chosen, with a warning; 0: it holds for ever."""
    host, stepper = OneCommandHost(), NotingStepper()
    realtime = Realtime(host, stepper, settings(timeout, on_silence))  # type: ignore[arg-type]
    realtime.run()
    assert stepper.efforts[0] == (3.0, 4.0)
    assert stepper.efforts[-1] == last
    assert stepper.warning == warned
    if warned:  # told with the first step after the time-out, not with the one before
        assert stepper.times[stepper.warned - 2] - host.sent[1] <= timeout
        assert stepper.times[stepper.warned] - host.sent[0] > timeout
    assert stepper.plant.braking == (on_silence == "brake")
    assert realtime.figures()["silences"] == bool(warned)


def array(numbers: list[float]) -> bytes:
    """Return a bare array as it comes over the wire."""
    return serialize_message(Float64MultiArray(data=numbers))


def test_an_array_of_the_wrong_size_is_refused() -> None:
    """A bare array takes effect in joint order when it has one effort per joint, and is counted when it has not."""
    host, stepper = OneCommandHost(), NotingStepper()
    realtime = Realtime(host, stepper, settings(0.0))  # type: ignore[arg-type]
    host.spin(0.0)
    host.callbacks["effort_controller/commands"](array([1.0, 2.0, 3.0]))
    realtime.step_once()
    host.callbacks["effort_controller/commands"](array([5.0, 6.0]))
    realtime.step_once()
    assert stepper.efforts == [(3.0, 4.0), (5.0, 6.0)]
    assert stepper.gate.summary() == {"received": 3, "rejected": 1, "late": 0, "duplicate": 0}


@pytest.mark.parametrize(("late", "counts"), [(1.5, True), (1.7, False)])
def test_a_command_is_stale_by_wall_time(late: float, counts: bool) -> None:
    """At four times real time a command may answer a state that is four time-outs old in the simulation's own time."""
    host, stepper = OneCommandHost(), NotingStepper()
    realtime = Realtime(host, stepper, settings(0.4, rate=4.0))  # type: ignore[arg-type]
    stepper.stamp = 10_000_000_000
    stamp = stepper.stamp - round(late * 1e9)
    host.callbacks["joint_commands"](JointWire(JOINTS, effort=True).encode(stamp, (3.0, 4.0)))
    realtime.step_once()
    assert stepper.efforts == [(3.0, 4.0) if counts else (0.0, 0.0)]
    assert stepper.gate.refused == ({} if counts else {"stale": 1})
