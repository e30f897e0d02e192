"""Joint states as laws take them: in the scene's order of joints, at the plant's own time.

How long a law takes for a step, measured in its node.
"""

import time
from collections.abc import Mapping
from typing import NamedTuple

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.node import Node

from crane_sim.laws import Law, ask_law
from crane_sim.ros.common import messages
from crane_sim.ros.common.serialization import Frame, JointWire
from crane_sim.ros.common.timing import Errors
from crane_sim.scenes.scene import Scene


class State(NamedTuple):
    """What a law is asked about."""

    stamp: int  # ns
    t: float  # s, exactly the plant's own time
    q: tuple[float, ...]
    v: tuple[float, ...]


class StateReader:
    """Reads the messages of the topic `joint_states`, in whatever order they name the joints."""

    def __init__(self, node: Node, scene: Scene) -> None:
        """Expect the joints of a scene; `node` logs what does not fit."""
        self._node, self._scene = node, scene
        self._names = list(scene.joint_names)
        self._wire = JointWire(scene.joint_names, effort=False)

    def read(self, data: bytes) -> State | None:
        """Return what a message says, None where joints are missing or it is no such message."""
        try:
            frame = self._wire.decode(data)
        except ValueError as error:
            self._node.get_logger().warning(f"joint state that cannot be read: {error}", throttle_duration_sec=1.0)
            return None
        vectors = (frame.position, frame.velocity) if frame.names == self._names else self._sort_by_joint(frame)
        if vectors is None:
            return None
        return State(frame.stamp, (frame.stamp / self._scene.period_ns - 1.0) * self._scene.period, *vectors)

    def _sort_by_joint(self, frame: Frame) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        same = sorted(frame.names) == sorted(self._names)
        if not same or not len(frame.position) == len(frame.velocity) == len(self._names):
            line = f"joint state of {frame.names}, expected position and velocity of {self._names}: ignored"
            self._node.get_logger().warning(line, throttle_duration_sec=1.0)
            return None
        order = [frame.names.index(name) for name in self._names]
        return tuple(frame.position[i] for i in order), tuple(frame.velocity[i] for i in order)


_DIAGNOSTICS = 1.0  # s of wall time between two diagnostic messages


class ExecutionTime:
    """Asks a law, takes the time, and tells the diagnostics."""

    def __init__(self, node: Node) -> None:
        """Begin with no step."""
        self._diagnostics = node.create_publisher(DiagnosticArray, "/diagnostics", messages.STREAM)
        self._source = f"{node.get_namespace().strip('/')}/{node.get_name()}"
        self._durations, self._told, self._stamp = Errors(), 0.0, 0

    def asked(self, law: Law, state: State, nu: int) -> tuple[float, ...]:
        """Return the efforts (nu,) that the law demands.

        Raises:
            LawError: as `laws.asked`.
        """
        began = time.perf_counter()
        effort = ask_law(law, state.t, state.q, state.v, nu)
        self._durations.add(time.perf_counter() - began)
        self._stamp = state.stamp
        return effort

    def silent(self) -> bool:
        """Return whether the last diagnostics are a second old."""
        return time.monotonic() - self._told >= _DIAGNOSTICS

    def tell(self, warning: str, values: Mapping[str, object]) -> None:
        """Publish diagnostics: what the law takes, and `values` besides; a warning where there is one."""
        self._told = time.monotonic()
        taken = {f"law {name} [us]": f"{value:.1f}" for name, value in self.figures().items()}
        message = messages.diagnostics(self._source, warning, taken | dict(values))
        messages.set_stamp(message.header.stamp, self._stamp)
        self._diagnostics.publish(message)

    def figures(self) -> dict[str, float]:
        """Return median, 99 % quantile and largest time of a step, µs."""
        return self._durations.figures()
