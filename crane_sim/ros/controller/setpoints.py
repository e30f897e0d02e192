"""What the fast half of a law hears of the slow half, which is a process of its own: the topic `tip_demand`."""

from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, cast

from rclpy.node import Node
from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from crane_sim.laws import SlowHalf
from crane_sim.ros.common import messages
from crane_sim.ros.controller.states import State

_MISSED = 3.0  # intervals without a demand that call for a warning


class Setpoints:
    """The newest demand: waited for in lockstep, in real time held until the next one comes, however late.

    A demand is late when it misses the control step after the one that it was made for.
    """

    def __init__(self, node: Node, names: Sequence[str], patient: bool, answer: Callable[[State], None]) -> None:
        """Listen.

        Args:
            node: whose topic it is.
            names: the coordinates that demands are of.
            patient: wait for the demand of every state that asks for one.
            answer: is called with the state that has waited, once its demand is there.
        """
        self._node, self._names, self._patient, self._answer = node, list(names), patient, answer
        self._newest: tuple[int, tuple[float, ...]] | None = None
        self._anew = False  # the newest one is of a run whose states have not come yet
        self._waiting: State | None = None
        self._now = 0  # ns, of the newest state
        self._received = self._late = self._held = self._longest = 0
        self._ear = node.create_subscription(JointTrajectory, "tip_demand", self._on_message, messages.STREAM)

    def missing(self) -> str:
        """Return one line on the peer still missing, empty when it is there."""
        return "" if self._ear.get_publisher_count() else f"a publisher of {self._ear.topic_name}"

    def forget(self) -> None:
        """Drop the demand of a run that is over: the plant began anew; one that is of the new run stays."""
        if not self._anew:
            self._newest = None
        self._anew = False

    def given_to(self, half: SlowHalf, state: State) -> bool:
        """Give the half what holds at a state; False where that is still to come, and the state waits."""
        self._now, self._waiting = state.stamp, None
        stamp, demand = self._newest or (state.stamp + 1, ())  # one from the future is from before a reset
        if stamp > state.stamp or (self._patient and stamp < state.stamp and half.due(state.t)):
            self._waiting = state
            return False
        self._held = state.stamp - stamp
        self._longest = max(self._longest, self._held)
        half.take(demand)
        return True

    def warning(self, half: SlowHalf) -> str:
        """Return one line where demands fail to come, empty while they do."""
        held = self._held / messages.SECOND
        return f"no demand for {held:.3g} s: the last one holds" if held > _MISSED * half.interval else ""

    def figures(self) -> dict[str, Any]:
        """Return what a run's summary says: demands that came and came late, the longest that one held [s]."""
        return {"received": self._received, "late": self._late, "longest_hold": self._longest / messages.SECOND}

    def _on_message(self, message: JointTrajectory) -> None:
        demand = self._read(message)
        if demand is None:
            line = f"demand for {list(message.joint_names)} is not one point of numbers for {self._names}: ignored"
            self._node.get_logger().warning(line, throttle_duration_sec=1.0)
            return
        stamp = messages.nanoseconds(message.header.stamp)
        if self._newest and (stamp, demand) != self._newest and stamp <= self._newest[0]:
            self._anew = True  # the slow half saw it first
        if (stamp, demand) != self._newest:  # else it answers a state that lockstep sent again
            self._newest = stamp, demand
            self._received += 1
            self._late += stamp < self._now
        if self._waiting is not None:
            self._answer(self._waiting)

    def _read(self, message: JointTrajectory) -> tuple[float, ...] | None:
        points = cast(Sequence[JointTrajectoryPoint], message.points)
        if list(message.joint_names) != self._names or len(points) != 1:
            return None
        parts = (points[0].positions, points[0].velocities, points[0].accelerations)
        numbers = tuple(number for part in parts for number in part)
        fits = all(len(part) == len(self._names) for part in parts) and all(map(isfinite, numbers))
        return numbers if fits else None
