"""Joint states as laws take them: in the scene's order of joints, at the plant's own time."""

from typing import NamedTuple

from rclpy.node import Node

from crane_sim.ros.wire import Frame, JointWire
from crane_sim.scene import Scene


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
        vectors = (frame.position, frame.velocity) if frame.names == self._names else self._sorted(frame)
        if vectors is None:
            return None
        return State(frame.stamp, (frame.stamp / self._scene.period_ns - 1.0) * self._scene.period, *vectors)

    def _sorted(self, frame: Frame) -> tuple[tuple[float, ...], tuple[float, ...]] | None:
        same = sorted(frame.names) == sorted(self._names)
        if not same or not len(frame.position) == len(frame.velocity) == len(self._names):
            line = f"joint state of {frame.names}, expected position and velocity of {self._names}: ignored"
            self._node.get_logger().warning(line, throttle_duration_sec=1.0)
            return None
        order = [frame.names.index(name) for name in self._names]
        return tuple(frame.position[i] for i in order), tuple(frame.velocity[i] for i in order)
