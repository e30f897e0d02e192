"""Publisher of the command that each period takes, from which a run can be repeated to the last bit."""

from collections.abc import Sequence
from math import nan

from rclpy.node import Node
from sensor_msgs.msg import JointState

from crane_sim.ros.common import messages
from crane_sim.ros.common.command_codec import CommandCodec
from crane_sim.scenes.scene import Scene

HELD = "held_command"


class HeldCommands:
    """Publisher of held commands (nu,), each stamped like the state at the start of its period; NaN while brakes act.

    Late commands, time-outs and emergency stops are visible in it, since it is the command that the drives followed; a
    recorder need not know whose commands the plant takes.
    """

    def __init__(self, node: Node, scene: Scene) -> None:
        """Create the publisher."""
        self._publisher = node.create_publisher(JointState, HELD, messages.DEEP_STREAM_QOS)
        self._codec, self._braked = CommandCodec(scene), (nan,) * len(scene.actuated)
        self._subscribed = False

    def update_subscribers(self) -> None:
        """Update whether there are subscribers."""
        self._subscribed = self._publisher.get_subscription_count() > 0

    def publish(self, stamp: int, command: Sequence[float], braking: bool) -> None:
        """Publish the command (nu,) of the period that begins at a stamp [ns], if there are subscribers."""
        if self._subscribed:
            self._publisher.publish(self._codec.encode(stamp, self._braked if braking else command))
