"""A node beside a run that begins paused: hostile messages and requests, then it lets go.

They go to all topics and services.

Arguments: seed, number of messages, scene. Prints how many messages and requests it has sent as
JSON.
"""

import json
import random
import sys
import time
from contextlib import suppress
from typing import Any

import rclpy
from hostile_messages import TOPICS, HostileMessages
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rcl_interfaces.msg import Parameter, ParameterValue
from rcl_interfaces.srv import (
    DescribeParameters,
    GetParameters,
    GetParameterTypes,
    ListParameters,
    SetParameters,
    SetParametersAtomically,
)
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_srvs.srv import SetBool, Trigger

from crane_sim import load_scene

RCLError: type[Exception] = rclpy_implementation.RCLError
LIMIT = 60.0  # s for whatever it waits for
CHUNKS = 20  # of the messages: between them the run is paused
NODES = {"plant": True, "controller": True, "recorder": False}  # whether it is a lifecycle node
NAMES = (
    "",
    "scene",
    "step_count",
    "stop_time",
    "reset_positions",
    "use_sim_time",
    "ß",
    "a" * 1000,
    "no.such\0name",
)
TYPES = (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 77, 99, 255)


class HostileNode(Node):
    """A stranger in the crane's namespace."""

    def __init__(self, seed: int, scene_name: str) -> None:
        """Create clients of all services.

        There is no publisher so far: a plant does not start beside another one's.
        """
        scene = load_scene(scene_name)
        super().__init__("stranger", namespace=scene.crane)
        self._random, self.stamp, self.sent, self.requests = random.Random(seed), 0, 0, 0
        self._messages = HostileMessages(seed, scene.crane, scene.joint_names, scene.actuated)
        self._topics: dict[str, Any] = {}
        self.create_subscription(JointState, "joint_states", self._on_state, 10)
        self._period = scene.period_ns
        self._pause = self.create_client(SetBool, "plant/set_pause")
        self._hostile = [
            self._make_client(node, *each) for node in NODES for each in self._parameter_services()
        ]
        self._hostile += [
            self._make_client(node, ChangeState, "change_state", self._transition)
            for node, managed in NODES.items()
            if managed
        ]
        self._hostile += [
            self._make_client("plant", Trigger, "step_simulation", Trigger.Request),
            self._make_client("plant", SetBool, "set_brakes", lambda: SetBool.Request(data=False)),
        ]

    def send(self, number: int) -> None:
        """Send messages on all topics in turn, and a request for every fifty."""
        names = list(self._topics)
        for _ in range(number):
            name = names[self.sent % len(names)]
            with suppress(RCLError):  # longer than the middleware lets a message of this type be
                self._topics[name].publish(self._messages.generate(name, self.stamp))
            self.sent += 1
            if self.sent % 50 == 0:
                self._request()
            rclpy.spin_once(self, timeout_sec=0.0)

    def set_pause(self, paused: bool) -> None:
        """Pause or resume the run."""
        self._await(self._pause, SetBool.Request(data=paused))

    def wait_for_stamp(self, periods: int) -> None:
        """Wait for a state: at the second one the scene's own controller owns the crane.

        It has moved the crane by then.
        """
        deadline = time.monotonic() + LIMIT
        while self.stamp < periods * self._period:
            assert time.monotonic() < deadline, "the run has not begun"
            rclpy.spin_once(self, timeout_sec=0.1)

    def publish(self) -> None:
        """Create the publishers."""
        self._topics = {
            name: self.create_publisher(kind.message, name, kind.qos)
            for name, kind in TOPICS.items()
        }

    def _on_state(self, state: JointState) -> None:
        stamp = state.header.stamp.sec * 10**9 + state.header.stamp.nanosec
        self.stamp = (
            stamp if stamp % self._period == 0 and self.stamp <= stamp <= 10**13 else self.stamp
        )

    def _make_client(self, node: str, kind: Any, name: str, request: Any) -> Any:
        return self.create_client(kind, f"{node}/{name}"), request

    def _request(self) -> None:
        client, request = self._random.choice(self._hostile)
        self._await(client, request())
        self.requests += 1

    def _await(self, client: Any, request: Any) -> None:
        assert client.wait_for_service(LIMIT), f"{client.srv_name}: there is no such service"
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future, timeout_sec=LIMIT)
        assert future.done(), f"{client.srv_name}: no answer to {request}"

    def _parameter_services(self) -> list[tuple[Any, str, Any]]:
        def names(kind: Any) -> Any:
            return lambda: kind.Request(names=[self._random.choice(NAMES) for _ in range(3)])

        def values(kind: Any) -> Any:
            return lambda: kind.Request(parameters=[self._parameter() for _ in range(3)])

        prefixes = ListParameters.Request(prefixes=list(NAMES), depth=2**64 - 1)
        return [
            (SetParameters, "set_parameters", values(SetParameters)),
            (SetParametersAtomically, "set_parameters_atomically", values(SetParametersAtomically)),
            (GetParameters, "get_parameters", names(GetParameters)),
            (GetParameterTypes, "get_parameter_types", names(GetParameterTypes)),
            (DescribeParameters, "describe_parameters", names(DescribeParameters)),
            (ListParameters, "list_parameters", lambda: prefixes),
        ]

    def _parameter(self) -> Parameter:
        value = ParameterValue(
            type=self._random.choice(TYPES), double_value=float("nan"), string_value="ß" * 100
        )
        value.integer_value = self._random.choice((0, -1, 2**63 - 1))
        value.double_array_value = [float("inf")] * self._random.choice((0, 3))
        return Parameter(name=self._random.choice(NAMES), value=value)

    def _transition(self) -> ChangeState.Request:
        """Return a transition that there is not, or that an active node cannot make."""
        label = self._random.choice(("", "no such transition", "ß" * 100))
        return ChangeState.Request(
            transition=Transition(id=self._random.choice((0, 1, 3, 77, 255)), label=label)
        )


def main() -> None:
    """Send all messages in chunks, each while the run goes on; between them it is paused."""
    rclpy.init()
    node, number = HostileNode(int(sys.argv[1]), sys.argv[3]), int(sys.argv[2])
    node.wait_for_stamp(1)
    node.set_pause(False)
    node.wait_for_stamp(2)
    node.publish()
    for _ in range(CHUNKS):
        node.set_pause(True)
        node.send(number // CHUNKS)
        node.set_pause(False)
        node.send(number // CHUNKS // 10)
    print(json.dumps({"sent": node.sent, "requests": node.requests}), flush=True)
    sys.stdin.read()  # what it has sent stays where it was: a publisher that leaves takes it along


if __name__ == "__main__":
    main()
