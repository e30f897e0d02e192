"""The watchdog of real time, without ROS and with a plant that only notes its efforts."""

import time
from types import SimpleNamespace
from typing import Any

import pytest

from crane_sim.ros.gate import CommandGate
from crane_sim.ros.realtime import Realtime
from crane_sim.ros.wire import JointWire

JOINTS = ("slew", "boom")
PERIOD = 0.01  # s
STEPS = 80


class NotingStepper:
    """A stepper that moves nothing."""

    def __init__(self) -> None:
        """Begin at the first state."""
        self.scene = SimpleNamespace(actuated=JOINTS, period=PERIOD, sampled=True)
        self.gate = CommandGate(JOINTS)
        self.efforts: list[tuple[float, ...]] = []
        self.stamp, self.warning, self.paused, self.deadline_misses = 10_000_000, "", False, 0

    @property
    def running(self) -> bool:
        """Whether steps are left."""
        return len(self.efforts) < STEPS

    def step(self, effort: tuple[float, ...]) -> None:
        """Note the effort."""
        self.efforts.append(effort)

    def begin(self) -> None:
        """Publish nothing."""

    def heartbeat(self) -> None:
        """Report nothing."""


class OneCommandHost:
    """A host whose controller sends one command, and then no more."""

    def __init__(self) -> None:
        """Keep the callbacks that are subscribed."""
        self.stopping = ""
        self.callbacks: dict[str, Any] = {}
        self.node = SimpleNamespace(create_subscription=self._subscribe)
        self._sent = False

    def spin(self, timeout: float) -> None:
        """Deliver the command the first time, then only let time pass."""
        if not self._sent:
            self._sent = True
            self.callbacks["joint_commands"](JointWire(JOINTS, effort=True).encode(10_000_000, (3.0, 4.0)))
        time.sleep(timeout)

    def _subscribe(self, _type: type, topic: str, callback: Any, _qos: Any, **_options: Any) -> None:
        self.callbacks[topic] = callback


@pytest.mark.parametrize(("timeout", "last", "warned"), [(0.4, (0.0, 0.0), True), (0.0, (3.0, 4.0), False)])
def test_a_silent_controller_loses_the_crane(timeout: float, last: tuple[float, ...], warned: bool) -> None:
    """Without a new command the last one holds until the time-out, then zero effort with a warning; 0: for ever."""
    host, stepper = OneCommandHost(), NotingStepper()
    realtime = Realtime(host, stepper, SimpleNamespace(rate=1.0, command_timeout=timeout))  # type: ignore[arg-type]
    realtime.run()
    assert stepper.efforts[0] == (3.0, 4.0)
    assert stepper.efforts[-1] == last
    assert bool(stepper.warning) == warned


def test_an_array_of_the_wrong_size_is_refused() -> None:
    """A bare array takes effect in joint order when it has one effort per joint, and is counted when it has not."""
    host, stepper = OneCommandHost(), NotingStepper()
    realtime = Realtime(host, stepper, SimpleNamespace(rate=1.0, command_timeout=0.0))  # type: ignore[arg-type]
    host.spin(0.0)
    host.callbacks["effort_controller/commands"](SimpleNamespace(data=[1.0, 2.0, 3.0]))
    realtime.step_once()
    host.callbacks["effort_controller/commands"](SimpleNamespace(data=[5.0, 6.0]))
    realtime.step_once()
    assert stepper.efforts == [(3.0, 4.0), (5.0, 6.0)]
    assert stepper.gate.summary() == {"received": 3, "rejected": 1, "late": 0, "duplicate": 0}
