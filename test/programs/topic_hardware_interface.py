"""A stock ros2_control set-up, emulated: SCENE sim|wall actuated|all single|events [reliable].

A controller manager's loop calls read(), the controllers' update() and write() once in each period of its clock, the
wall clock or simulated time. The hardware interface has a node of its own, whose messages read() takes; it writes the
names of all joints of its tag, and the efforts of those that have a command interface, stamped with the clock.
It subscribes with best effort, unless it is asked to be reliable: then no state is lost on a busy machine.
"""

import sys
import time

import rclpy
from builtin_interfaces.msg import Time
from pd_law import PdLaw
from rclpy.executors import SingleThreadedExecutor
from rclpy.experimental import EventsExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, qos_profile_sensor_data
from sensor_msgs.msg import JointState

from crane_sim import load_scene


class HardwareInterface:
    """The interface with its node; its threshold of changes is -1, so that it always sends."""

    def __init__(self, namespace: str, joints: list[str], reliable: bool) -> None:
        """Subscribe and publish as the interface does."""
        self._node, self._joints = Node("hardware", namespace=namespace), joints
        qos = QoSProfile(depth=10) if reliable else qos_profile_sensor_data
        self._states = self._node.create_subscription(JointState, "joint_states", lambda _: None, qos)
        self._commands = self._node.create_publisher(JointState, "joint_commands", 1)
        self.states: dict[str, tuple[float, float]] = {}

    def read(self) -> None:
        """Take the states that have come."""
        with self._states.handle:
            while (taken := self._states.handle.take_message(JointState, False)) is not None:
                state = taken[0]
                rows = zip(state.position, state.velocity, strict=True)
                self.states = dict(zip(state.name, rows, strict=True))

    def write(self, stamp: Time, efforts: dict[str, float]) -> None:
        """Publish."""
        command = JointState(name=self._joints, effort=[efforts[joint] for joint in self._joints if joint in efforts])
        command.header.stamp = stamp
        self._commands.publish(command)


class Manager:
    """The controller manager's clock."""

    def __init__(self, namespace: str, clock: str, executor_name: str, period: float) -> None:
        """Create its node; `clock`: sim or wall."""
        self._simulated, self._period = clock == "sim", period
        simulated = Parameter("use_sim_time", value=self._simulated)
        self._node = Node("controller_manager", namespace=namespace, parameter_overrides=[simulated])
        self._executor = EventsExecutor() if executor_name == "events" else SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._last, self._due = self._node.get_clock().now().nanoseconds, time.monotonic()

    def sleep(self) -> None:
        """Return with the next period of the clock, or the next time that it reads."""
        self._due += self._period
        while not self._is_due():
            self._executor.spin_once(timeout_sec=0.05 if self._simulated else max(self._due - time.monotonic(), 0.0))

    def now(self) -> Time:
        """Return the time as a message."""
        return self._node.get_clock().now().to_msg()

    def _is_due(self) -> bool:
        if not self._simulated:
            return time.monotonic() >= self._due
        last, self._last = self._last, self._node.get_clock().now().nanoseconds
        return self._last != last


def main(file: str, clock: str, tag: str, executor_name: str, reliability: str = "") -> None:
    """Loop until the process is killed."""
    scene = load_scene(file)
    law = PdLaw(scene)
    rclpy.init()
    manager = Manager(scene.crane, clock, executor_name, scene.period)
    joints = [name for name in scene.joint_names if tag == "all" or name in scene.actuated]
    hardware = HardwareInterface(scene.crane, joints, reliability == "reliable")
    while rclpy.ok():
        manager.sleep()
        hardware.read()
        if hardware.states:
            q, v = zip(*(hardware.states[name] for name in scene.joint_names), strict=True)
            hardware.write(manager.now(), dict(zip(scene.actuated, law(0.0, q, v), strict=True)))


if __name__ == "__main__":
    main(*sys.argv[1:])
