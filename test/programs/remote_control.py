"""Pauses a run, steps it, resets it, lets it go on; prints what it saw as one JSON object. Plain rclpy."""

import json
import sys
import time

import rclpy
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile
from sensor_msgs.msg import JointState
from std_msgs.msg import UInt8
from std_srvs.srv import SetBool, Trigger

PATIENCE = 30.0  # s, only so that a failure ends
QUIET = 0.5  # s without a state: a paused plant has no more of them


class RemoteControl(Node):
    """Calls the plant's services and follows the stamps of its states."""

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
        """Spin until the simulation is in `mode`."""
        deadline = time.monotonic() + PATIENCE
        while self.mode != mode and time.monotonic() < deadline:
            rclpy.spin_once(self, timeout_sec=0.1)

    def rest(self) -> int:
        """Return the stamp of the newest state, ns, once nothing has come for a while."""
        before, since = -1, time.monotonic()
        while before != self.stamp or time.monotonic() - since < QUIET:
            if before != self.stamp:
                before, since = self.stamp, time.monotonic()
            rclpy.spin_once(self, timeout_sec=0.02)
        return self.stamp

    def pause(self, paused: bool) -> str:
        """Pause or go on; returns the answer's message, "ok" where it succeeded."""
        return self._call(self._pause, SetBool.Request(data=paused))

    def step(self) -> str:
        """Take one step."""
        return self._call(self._step, Trigger.Request())

    def reset(self) -> str:
        """Return to the initial state."""
        return self._call(self._reset, Trigger.Request())

    def _call(self, client, request) -> str:
        client.wait_for_service(PATIENCE)
        future = client.call_async(request)
        rclpy.spin_until_future_complete(self, future, timeout_sec=PATIENCE)
        answer = future.result()
        return "ok" if answer.success else answer.message

    def _on_mode(self, message: UInt8) -> None:
        self.mode = message.data

    def _on_state(self, message: JointState) -> None:
        self.stamp = message.header.stamp.sec * 10**9 + message.header.stamp.nanosec


def main() -> None:
    """Take one run through everything."""
    rclpy.init(args=sys.argv)
    remote, seen = RemoteControl(), {}
    remote.wait_for_mode(1)
    seen["step while playing"] = remote.step()
    seen["pause"], seen["paused at"] = remote.pause(True), remote.rest()
    seen["mode"] = remote.mode
    seen["steps"], seen["stepped to"] = [remote.step() for _ in range(3)], 0
    seen["stepped to"] = remote.rest()
    seen["reset"], seen["reset to"] = remote.reset(), remote.rest()
    seen["go on"] = remote.pause(False)
    remote.wait_for_mode(0)
    print(json.dumps(seen))
    rclpy.shutdown()


if __name__ == "__main__":
    main()
