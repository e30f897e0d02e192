"""A stock ros2_control set-up, emulated; its arguments are below.

SCENE sim|wall actuated|all single|events [reliable [ITERATIONS]].

Written from the behaviour of controller_manager's ros2_control_node and of JointStateTopicSystem
(Jazzy): the loop waits for the first time that its clock reads, then for a period, and then calls
read(), the controllers' update() and write() once in each period of this clock, the wall clock or
simulated time. The hardware interface has a node of its own, whose messages read() takes; it writes
the names of all joints of its tag, and the efforts of those that have a command interface, stamped
with its clock; before there is a state, the initial commands of its tag.

The real one subscribes with best effort. Asked to be reliable, this one loses no state on a busy
machine. After the given number of iterations it leaves the graph in order, and starts anew.
"""

import sys
from math import inf
from xml.etree import ElementTree

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
from crane_sim.ros.common.ros2_control import urdf_with_ros2_control
from crane_sim.scenes.scene import Scene


class Tag:
    """A `<ros2_control>` tag: its topics, joints, and commands before a controller is active."""

    def __init__(self, urdf: str, passive: bool) -> None:
        """Read it; without `passive`, as a user may do, joints with states only are left out."""
        tag = ElementTree.fromstring(urdf).find("ros2_control")
        assert tag is not None
        parameters = {each.get("name"): str(each.text) for each in tag.findall("hardware/param")}
        self.states_topic, self.commands_topic = (
            parameters["joint_states_topic"],
            parameters["joint_commands_topic"],
        )
        # else a command like the state is not sent
        assert float(parameters["trigger_joint_command_threshold"]) < 0.0
        joints = [
            each
            for each in tag.findall("joint")
            if passive or each.find("command_interface") is not None
        ]
        self.joints = [str(each.get("name")) for each in joints]
        values = {
            each.get("name"): each.find("command_interface/param[@name='initial_value']")
            for each in joints
        }
        self.initial = {
            str(name): float(str(value.text)) for name, value in values.items() if value is not None
        }


class HardwareInterface:
    """The interface and its node; its threshold of changes is negative, so it always sends."""

    def __init__(self, tag: Tag, clock: Parameter, reliable: bool) -> None:
        """Subscribe and publish as the interface does."""
        self._node, self._tag = Node("hardware", parameter_overrides=[clock]), tag
        qos = QoSProfile(depth=10) if reliable else qos_profile_sensor_data
        self._states = self._node.create_subscription(
            JointState, tag.states_topic, lambda _: None, qos
        )
        self._commands = self._node.create_publisher(JointState, tag.commands_topic, 1)
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
        joints = self._tag.joints
        command = JointState(
            name=joints, effort=[efforts[joint] for joint in joints if joint in efforts]
        )
        command.header.stamp = stamp
        self._commands.publish(command)


class Manager:
    """The controller manager's clock and loop."""

    def __init__(self, namespace: str, clock: Parameter, executor_name: str, period: float) -> None:
        """Create its node, and begin as ros2_control_node does: with a time, and a period later."""
        self._simulated, self._period = bool(clock.value), round(period * 1e9)
        self._node = Node("controller_manager", namespace=namespace, parameter_overrides=[clock])
        self._executor = EventsExecutor() if executor_name == "events" else SingleThreadedExecutor()
        self._executor.add_node(self._node)
        self._sleep_until(1)
        self._began = self._now()
        self.sleep()

    def sleep(self) -> None:
        """Sleep until a period after the last iteration began, by the clock."""
        self._sleep_until(self._began + self._period)
        self._began = self._now()

    def stamp(self) -> Time:
        """Return the time as a message."""
        return self._node.get_clock().now().to_msg()

    def _now(self) -> int:
        return self._node.get_clock().now().nanoseconds

    def _sleep_until(self, due: int) -> None:
        while (left := due - self._now()) > 0:
            self._executor.spin_once(timeout_sec=0.05 if self._simulated else left * 1e-9)


def main(
    file: str,
    clock: str,
    tag: str,
    executor_name: str,
    reliability: str = "",
    iterations: str = "inf",
) -> None:
    """Loop until the process is killed."""
    scene = load_scene(file)
    control = Tag(urdf_with_ros2_control(scene), passive=tag == "all")
    for number in (float(iterations), inf):
        loop(
            scene,
            control,
            Parameter("use_sim_time", value=clock == "sim"),
            executor_name,
            reliability,
            number,
        )


def loop(
    scene: Scene,
    control: Tag,
    simulated: Parameter,
    executor_name: str,
    reliability: str,
    iterations: float,
) -> None:
    """Start a manager with its interface, and leave the graph after some iterations."""
    law = PdLaw(scene)
    rclpy.init()
    hardware = HardwareInterface(control, simulated, reliability == "reliable")
    manager = Manager(scene.crane, simulated, executor_name, scene.period)
    while rclpy.ok() and iterations > 0.0:
        iterations -= 1.0
        hardware.read()
        efforts = control.initial
        if hardware.states:
            q, v = zip(*(hardware.states[name] for name in scene.joint_names), strict=True)
            efforts = dict(zip(scene.actuated, law(0.0, q, v), strict=True))
        hardware.write(manager.stamp(), efforts)
        manager.sleep()
    rclpy.shutdown()


if __name__ == "__main__":
    main(*sys.argv[1:])
