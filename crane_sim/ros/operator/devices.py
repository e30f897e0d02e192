"""The devices of the node `operator`: a terminal's keys, a gamepad, or the topic of a joystick."""

import time
from typing import Protocol

from rclpy.node import Node
from sensor_msgs.msg import Joy

from crane_sim.files.errors import SceneError
from crane_sim.operator.desk import Desk
from crane_sim.operator.gamepad import Gamepad
from crane_sim.operator.inputs import Demand, Keyboard, Sample, demand_of
from crane_sim.operator.levers import Assignment
from crane_sim.ros.common import messages
from crane_sim.ros.common.messages import MalformedMessage

_REOPEN_PERIOD = 1.0  # s between two attempts to open a gamepad again


class Device(Protocol):
    """A device with levers.

    Attributes:
        name: for the operator.
    """

    name: str

    def demand(self, now: float, tail: float) -> Demand:
        """Return the demand at `now` [s]; report heartbeats or the loss to the desk.

        `tail`: see `Keyboard`.
        """
        ...


class KeyboardDevice:
    """The keys of the terminal, whose process sends them; where it ends, so does this node."""

    name = "keyboard"

    def __init__(self, desk: Desk, keyboard: Keyboard) -> None:
        """Take the keys of a keyboard."""
        self._desk, self._keyboard = desk, keyboard

    def demand(self, now: float, tail: float) -> Demand:
        """See `Device`."""
        self._desk.heartbeat(now)
        return self._keyboard.demand(now, tail)


class JoyDevice:
    """A joystick on the ROS graph."""

    def __init__(self, node: Node, topic: str, desk: Desk, assignment: Assignment) -> None:
        """Subscribe to sensor_msgs/Joy."""
        self.name, self._desk, self._assignment = topic, desk, assignment
        self._sample = Sample((), ())
        node.create_subscription(Joy, topic, self._on_message, messages.SENSOR_QOS, raw=True)

    def demand(self, now: float, tail: float) -> Demand:
        """See `Device`; the desk counts the time since the last message."""
        return demand_of(self._sample, self._assignment)

    def _on_message(self, data: bytes) -> None:
        try:
            message: Joy = messages.deserialize(data, Joy)
        except MalformedMessage:  # a topic may carry anything
            return
        self._sample = Sample(message.axes, message.buttons)
        self._desk.heartbeat(time.monotonic())


class GamepadDevice:
    """A gamepad of this machine; one that was unplugged is opened again when it is back."""

    def __init__(self, path: str, desk: Desk, assignment: Assignment) -> None:
        """Open it; raises SceneError where that is not possible."""
        self._path, self._desk, self._assignment = path, desk, assignment
        self._gamepad: Gamepad | None = Gamepad(path)
        self.name, self._next_attempt = self._gamepad.name, 0.0

    def demand(self, now: float, tail: float) -> Demand:
        """See `Device`."""
        if self._gamepad is None and now >= self._next_attempt:
            self._reopen(now)
        try:
            sample = self._gamepad.read() if self._gamepad else None
        except OSError:
            sample = self._lose(now)
        if sample is None:
            return Demand((0.0,) * len(self._assignment.levers), False)
        self._desk.heartbeat(now)
        return demand_of(sample, self._assignment)

    def _lose(self, now: float) -> None:
        if self._gamepad:
            self._gamepad.close()
        self._gamepad, self._next_attempt = None, now + _REOPEN_PERIOD
        self._desk.lose()

    def _reopen(self, now: float) -> None:
        self._next_attempt = now + _REOPEN_PERIOD
        try:
            self._gamepad = Gamepad(self._path)
        except SceneError:
            return
