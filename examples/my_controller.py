"""A controller of your own in plain rclpy: `./crane run --no-controller --domain-id 7`.

In lockstep the plant waits for the command that carries its state's stamp: answer every state, and
echo the stamp. In real time the same node works; there the newest command holds until the next one
comes.
"""

from my_law import TARGET, effort
from rclpy.node import Node
from sensor_msgs.msg import JointState
from until_stopped import spin_until_stopped


class MyController(Node):
    """Answers every state."""

    def __init__(self) -> None:
        """Join the crane's namespace."""
        super().__init__("my_controller", namespace="knuckle")
        self._commands = self.create_publisher(JointState, "joint_commands", 10)
        self.create_subscription(JointState, "joint_states", self._on_state, 10)

    def _on_state(self, state: JointState) -> None:
        efforts = effort(state.name, state.position, state.velocity)
        self._commands.publish(JointState(header=state.header, name=list(TARGET), effort=efforts))


if __name__ == "__main__":
    spin_until_stopped(MyController)  # Ctrl-C ends it
