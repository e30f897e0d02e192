"""Pauses, steps, resets and resumes a run by the plant's services; prints the answers as JSON. Plain rclpy."""

import json
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt8
from std_srvs.srv import SetBool, Trigger

LIMIT = 300.0  # s for a service or a mode, on a busy machine
IDLE_TIMEOUT = 0.5  # s without a state after which the plant stands


class ServiceClient(Node):
    """A client of the plant's services, which records the stamps of its states."""

    def __init__(self) -> None:
        """Join the crane's namespace."""
        super().__init__("remote", namespace="knuckle")
        self.mode, self.stamp = -1, 0
        latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self.create_subscription(UInt8, "simulation_state", self._on_mode, latched)
        self.create_subscription(JointState, "joint_states", self._on_state, 1000)
        self._pause = self.create_client(SetBool, "plant/set_pause")
        self._step = self.create_client(Trigger, "plant/step_simulation")
        self._reset = self.create_client(Trigger, "plant/reset_simulation")

    def wait_for_mode(self, mode: int) -> None:
        """Spin until simulation_state is `mode`; fails after the limit."""
        deadline = time.monotonic() + LIMIT
        while self.mode != mode:
            assert time.monotonic() < deadline, f"simulation_state is {self.mode}, not {mode} within {LIMIT:g} s"
            rclpy.spin_once(self, timeout_sec=0.1)

    def wait_standing(self) -> int:
        """Return the stamp of the newest state, ns, once no other has come for a while; fails after the limit."""
        newest, since, deadline = -1, time.monotonic(), time.monotonic() + LIMIT
        while newest != self.stamp or time.monotonic() - since < IDLE_TIMEOUT:
            assert time.monotonic() < deadline, f"states still come after {LIMIT:g} s"
            if newest != self.stamp:
                newest, since = self.stamp, time.monotonic()
            rclpy.spin_once(self, timeout_sec=0.02)
        return self.stamp

    def pause(self, paused: bool) -> str:
        """Pause or resume; return the answer's message, "ok" where it succeeded."""
        return self._call(self._pause, SetBool.Request(data=paused))

    def step(self) -> str:
        """Take one step, as soon as the controller, which a busy machine may hold up, has answered."""
        deadline = time.monotonic() + LIMIT
        while (answer := self._call(self._step, Trigger.Request())).endswith("has not come yet"):
            assert time.monotonic() < deadline, answer
        return answer

    def reset(self) -> str:
        """Return to the initial state."""
        return self._call(self._reset, Trigger.Request())

    def _call(self, client, request) -> str:
        assert client.wait_for_service(LIMIT), f"{client.srv_name}: no such service within {LIMIT:g} s"
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future, timeout_sec=LIMIT)
        answer = future.result()
        assert answer is not None, f"{client.srv_name}: no answer within {LIMIT:g} s"
        return "ok" if answer.success else answer.message

    def _on_mode(self, message: UInt8) -> None:
        self.mode = message.data

    def _on_state(self, message: JointState) -> None:
        self.stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def main() -> None:
    """Call all services in one run."""
    rclpy.init(args=sys.argv)
    client, results = ServiceClient(), {}
    client.wait_for_mode(2)  # the run begins paused: however late this program is, it has not ended
    client.pause(False)
    results["step while playing"] = client.step()
    results["pause"], results["paused at"] = client.pause(True), client.wait_standing()
    results["mode"] = client.mode
    results["steps"], results["stepped to"] = [client.step() for _ in range(3)], 0
    results["stepped to"] = client.wait_standing()
    results["reset"], results["reset to"] = client.reset(), client.wait_standing()
    results["go on"] = client.pause(False)
    client.wait_for_mode(0)
    print(json.dumps(results))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
