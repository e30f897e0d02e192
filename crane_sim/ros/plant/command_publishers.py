"""Publishers of what became of commands, for recorders; silent where there are no subscribers."""

from collections.abc import Sequence
from math import nan

from rclpy.node import Node
from sensor_msgs.msg import JointState

from crane_sim.ros.common import messages
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.scenes.scene import Scene


class AcceptedCommands:
    """Accepted commands, where a command's stamp does not identify the state that it answers."""

    def __init__(self, node: Node, codec: CommandCodec) -> None:
        """Create the publisher; `codec` encodes commands (nu,)."""
        self._publisher = node.create_publisher(JointState, "accepted_command", messages.STREAM_QOS)
        self._codec = codec

    def publish(self, stamp: int, effort: Sequence[float]) -> None:
        """Publish an effort (nu,) that answers the state of a stamp [ns]."""
        if self._publisher.get_subscription_count():
            self._publisher.publish(self._codec.encode(stamp, effort))


class HeldCommands:
    """Commands (nu,) of the periods, stamped like the state at each start; NaN while brakes act.

    A run can be repeated from them to the last bit: late commands, time-outs and emergency stops
    are visible, since it is the command that the drives followed; a recorder need not know whose
    commands the plant takes.
    """

    def __init__(self, node: Node, scene: Scene) -> None:
        """Create the publisher."""
        self._publisher = node.create_publisher(
            JointState, "held_command", messages.DEEP_STREAM_QOS
        )
        self._codec, self._braked = CommandCodec(scene), (nan,) * len(scene.actuated)
        self._subscribed = False

    def update_subscribers(self) -> None:
        """Update whether there are subscribers."""
        self._subscribed = self._publisher.get_subscription_count() > 0

    def publish(self, stamp: int, command: Sequence[float], braking: bool) -> None:
        """Publish the command (nu,) of the period that begins at a stamp [ns]."""
        if self._subscribed:
            self._publisher.publish(self._codec.encode(stamp, self._braked if braking else command))
