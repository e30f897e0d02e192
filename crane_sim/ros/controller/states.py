"""States for laws, in the scene's joint order and plant time, and the execution time of a law."""

import time
from collections.abc import Mapping
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from crane_sim.laws import Law, evaluate_law
from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import STATE, DecodedJointState, JointStateCodec
from crane_sim.ros.common.timing import DurationHistogram
from crane_sim.scenes.scene import Scene

_DIAGNOSTICS_PERIOD = 1.0  # s of wall time between two diagnostic messages


class State(NamedTuple):
    """The state at which a law is evaluated."""

    stamp: int  # ns
    t: float  # s, exactly the plant's own time
    q: tuple[float, ...]
    v: tuple[float, ...]


class StateReader:
    """Decoder of the topic `joint_states`, with joints in any order."""

    def __init__(self, node: Node, scene: Scene) -> None:
        """Expect the joints of a scene; `node` logs messages that do not fit."""
        self._node, self._scene = node, scene
        self._names = list(scene.joint_names)
        self._codec = JointStateCodec(scene.joint_names, STATE)

    def read(self, data: bytes) -> State | None:
        """Return a decoded state; None if joints or numbers are missing or it is no message."""
        try:
            decoded = self._codec.decode(data)
        except ValueError as error:
            self._node.get_logger().warning(
                f"joint state that cannot be read: {error}", throttle_duration_sec=1.0
            )
            return None
        vectors = decoded.sort_by_joint(self._names, decoded.position, decoded.velocity)
        if vectors is None:
            self._warn_of(decoded)
            return None
        q, v = vectors
        return State(
            decoded.stamp, (decoded.stamp / self._scene.period_ns - 1.0) * self._scene.period, q, v
        )

    def _warn_of(self, decoded: DecodedJointState) -> None:
        line = f"joint state {self._describe_misfit(decoded)}: ignored"
        self._node.get_logger().warning(line, throttle_duration_sec=1.0)

    def _describe_misfit(self, decoded: DecodedJointState) -> str:
        """Return why a message is no state of the scene: its stamp, joints, lengths or numbers."""
        if decoded.stamp < 0:
            return f"with the stamp {decoded.stamp} ns, which is before zero"
        positions, velocities, joints = (
            len(decoded.position),
            len(decoded.velocity),
            len(self._names),
        )
        if positions == velocities == joints and sorted(decoded.names) == sorted(self._names):
            return f"with numbers that are not finite: {[*decoded.position, *decoded.velocity]}"
        numbers = f"{positions} positions and {velocities} velocities"
        return f"of {decoded.names} with {numbers}, expected position and velocity of {self._names}"


class ExecutionTime:
    """The execution time of a law, measured at each evaluation and published as diagnostics."""

    def __init__(self, node: Node) -> None:
        """Create the publisher of diagnostics."""
        self._diagnostics = node.create_publisher(
            DiagnosticArray, "/diagnostics", messages.STREAM_QOS
        )
        self._source = f"{node.get_namespace().strip('/')}/{node.get_name()}"
        self._durations, self._last_published, self._stamp = DurationHistogram(), 0.0, 0

    def evaluate(self, law: Law, state: State, nu: int) -> tuple[float, ...]:
        """Return the efforts (nu,) of the law at a state, and record the time.

        Raises:
            LawError: as `laws.evaluate_law`.
        """
        start = time.perf_counter()
        effort = evaluate_law(law, state.t, state.q, state.v, nu)
        self._durations.add(time.perf_counter() - start)
        self._stamp = state.stamp
        return effort

    def is_due(self) -> bool:
        """Return whether the last diagnostics are a second old."""
        return time.monotonic() - self._last_published >= _DIAGNOSTICS_PERIOD

    def publish(self, warning: str, values: Mapping[str, object]) -> None:
        """Publish diagnostics: execution time, further `values`, and a warning if there is one."""
        self._last_published = time.monotonic()
        durations = {f"law {name} [us]": f"{value:.1f}" for name, value in self.metrics().items()}
        message = messages.diagnostics(self._source, warning, durations | dict(values))
        messages.set_stamp(message.header.stamp, self._stamp)
        self._diagnostics.publish(message)

    def metrics(self) -> dict[str, float]:
        """Return median, 99 % quantile and largest execution time, µs."""
        return self._durations.metrics()
