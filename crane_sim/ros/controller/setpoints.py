"""Setpoints from a law's outer loop to its inner loop, another process: the topic `tip_demand`."""

from collections import Counter
from collections.abc import Callable, Sequence
from math import isfinite
from typing import Any, NamedTuple, cast

from trajectory_msgs.msg import JointTrajectory, JointTrajectoryPoint

from crane_sim.laws import OuterLoop
from crane_sim.ros.common import messages
from crane_sim.ros.common.messages import MalformedMessage
from crane_sim.ros.common.nodes import ServingNode
from crane_sim.ros.common.served_subscription import SourceSubscription
from crane_sim.ros.controller.states import State

_WARNING_INTERVALS = 3.0  # intervals without a setpoint after which there is a warning


class _Setpoint(NamedTuple):
    stamp: int  # ns, of the state that it was made for
    values: tuple[float, ...]  # (3 n,) positions, velocities, accelerations


class Setpoints:
    """The newest setpoint: awaited in lockstep, held in real time until the next one comes.

    A setpoint is late when it misses the control step after the one that it was made for.
    """

    def __init__(
        self,
        node: ServingNode,
        names: Sequence[str],
        lockstep: bool,
        answer: Callable[[State], None],
    ) -> None:
        """Subscribe to the topic.

        Args:
            node: subscribes.
            names: of the setpoint's coordinates.
            lockstep: whether to wait for the setpoint of every state that requires one.
            answer: is called with the state that has waited, once its setpoint has come.
        """
        self._node, self._names, self._lockstep, self._answer = node, list(names), lockstep, answer
        self._newest: _Setpoint | None = None
        self._ahead_of_reset = False  # the newest is of a run whose states have not come yet
        self._waiting: State | None = None
        self._now = 0  # ns, of the newest state
        self._received = self._late = self._age = self._longest = 0
        self._subscription = SourceSubscription(
            node,
            JointTrajectory,
            "tip_demand",
            self._on_message,
            messages.STREAM_QOS,
            "tracker",
            standbys=True,
        )

    def missing(self) -> str:
        """Return one line on the peer still missing, empty when it is matched."""
        return self._subscription.missing()

    def refused(self) -> Counter[str]:
        """Return the numbers of messages refused, by topic and node."""
        return self._subscription.filter.refused

    def reset(self) -> None:
        """Drop a setpoint from before a reset of the plant; one of the new run stays."""
        if not self._ahead_of_reset:
            self._newest = None
        self._ahead_of_reset = False

    def apply_to(self, outer: OuterLoop, state: State) -> bool:
        """Give the outer loop a state's setpoint; False where the state waits for it."""
        self._now, self._waiting = state.stamp, None
        # stamps restart: a later one is older
        stamp, values = self._newest or _Setpoint(state.stamp + 1, ())
        if stamp > state.stamp or (self._lockstep and stamp < state.stamp and outer.due(state.t)):
            self._waiting = state
            return False
        self._age = state.stamp - stamp
        self._longest = max(self._longest, self._age)
        outer.take(values)
        return True

    def warning(self, outer: OuterLoop) -> str:
        """Return one line where setpoints fail to come, empty while they do."""
        holding_time = self._age / messages.NS_PER_S
        return (
            f"no setpoint for {holding_time:.3g} s: the last one holds"
            if holding_time > _WARNING_INTERVALS * outer.interval
            else ""
        )

    def metrics(self) -> dict[str, Any]:
        """Return the summary's entries: numbers of setpoints and of late ones, longest hold [s]."""
        return {
            "received": self._received,
            "late": self._late,
            "longest_hold": self._longest / messages.NS_PER_S,
        }

    def _on_message(self, data: bytes) -> None:
        try:
            setpoint = self._read(messages.deserialize(data, JointTrajectory))
        except MalformedMessage as error:
            self._node.get_logger().warning(f"setpoint {error}: ignored", throttle_duration_sec=1.0)
            return
        if self._newest and setpoint != self._newest and setpoint.stamp <= self._newest.stamp:
            # the outer loop has received the state after the reset first
            self._ahead_of_reset = True
        if setpoint != self._newest:  # else it answers a state that lockstep sent again
            self._newest = setpoint
            self._received += 1
            self._late += not self._ahead_of_reset and setpoint.stamp < self._now
        if self._waiting is not None:
            self._answer(self._waiting)

    def _read(self, message: JointTrajectory) -> _Setpoint:
        """Return the setpoint in a message; raises MalformedMessage, one line, if it is none."""
        points, stamp = (
            cast(Sequence[JointTrajectoryPoint], message.points),
            messages.nanoseconds(message.header.stamp),
        )
        vectors = [
            part
            for point in points
            for part in (point.positions, point.velocities, point.accelerations)
        ]
        numbers = tuple(number for part in vectors for number in part)
        fits = list(message.joint_names) == self._names and len(points) == 1
        if not (
            fits
            and all(len(part) == len(self._names) for part in vectors)
            and all(map(isfinite, numbers))
        ):
            raise MalformedMessage(
                f"for {list(message.joint_names)} is not one point of numbers for {self._names}"
            )
        return _Setpoint(stamp, numbers)
