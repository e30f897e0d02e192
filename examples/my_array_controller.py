"""The controller of my_controller.py in real time, by bare efforts in joint order.

For `./crane run --mode realtime --no-controller --domain-id 7`. No stamp, no names: the newest
array holds.
"""

from my_law import effort
from rclpy.node import Node
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from until_stopped import spin_until_stopped


class MyArrayController(Node):
    """Commands every 20 ms, independent of the rate of the states."""

    def __init__(self) -> None:
        """Join the crane's namespace."""
        super().__init__("my_array_controller", namespace="knuckle")
        self._state = JointState()
        self._commands = self.create_publisher(Float64MultiArray, "effort_controller/commands", 10)
        self.create_subscription(JointState, "joint_states", self._on_state, 10)
        self.create_timer(0.02, self._command)

    def _on_state(self, state: JointState) -> None:
        self._state = state

    def _command(self) -> None:
        if (state := self._state).name:
            self._commands.publish(
                Float64MultiArray(data=effort(state.name, state.position, state.velocity))
            )


if __name__ == "__main__":
    spin_until_stopped(MyArrayController)  # Ctrl-C ends it
