"""Publisher of the commands that were accepted, with the stamps of the states that they answer."""

from collections.abc import Sequence

from rclpy.node import Node
from sensor_msgs.msg import JointState

from crane_sim.ros.common import messages
from crane_sim.ros.common.command_codec import CommandCodec

ACCEPTED = "accepted_command"


class AcceptedCommands:
    """Publisher for recorders, where the stamp of a command does not identify the state that it answers."""

    def __init__(self, node: Node, codec: CommandCodec) -> None:
        """Create the publisher; `codec` encodes commands (nu,)."""
        self._publisher, self._codec = node.create_publisher(JointState, ACCEPTED, messages.STREAM_QOS), codec

    def publish(self, stamp: int, effort: Sequence[float]) -> None:
        """Publish an effort (nu,) that answers the state of a stamp [ns], if there are subscribers."""
        if self._publisher.get_subscription_count():
            self._publisher.publish(self._codec.encode(stamp, effort))
