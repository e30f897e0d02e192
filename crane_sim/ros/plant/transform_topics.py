"""The topics `/tf` and `/tf_static`: the frames of the crane, where tf2_msgs is installed.

They are those of robot_state_publisher, and `world` to `base_link` where the base moves, and the
turn of a load that rotates: neither is a joint of the URDF. Beside a robot_state_publisher the
parameter `publish_tf` is `base`, since one frame has one publisher.
"""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

from geometry_msgs.msg import TransformStamped
from rclpy.node import Node

from crane_sim.description import urdf
from crane_sim.description.transforms import WORLD, Transform, TransformTree, base_transform
from crane_sim.ros.common import messages
from crane_sim.ros.common.choices import TransformScope
from crane_sim.ros.common.messages import LATCHED_QOS, TRANSFORM_QOS, TFMessage
from crane_sim.ros.plant.state_publisher import StatePublisher, set_quaternion, set_vector
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.base_state import base_state
from crane_sim.simulation.plant import Plant


def missing_package(scope: str) -> str:
    """Return one line on why wanted transforms are off, empty where they are not."""
    if scope == TransformScope.OFF or TFMessage is not None:
        return ""
    return messages.describe_missing("tf2_msgs")


class TransformTopics(StatePublisher):
    """Publisher of the transforms of a crane, `tf_rate` times per second of the scene."""

    def __init__(self, node: Node, scene: Scene, settings: SimpleNamespace) -> None:
        """Create the publishers, and publish what never changes, latched; tf2_msgs is there."""
        super().__init__(node.create_publisher(TFMessage, "/tf", TRANSFORM_QOS))
        self._tree = TransformTree(urdf(scene), scene.joint_names)
        self._all, self._prefix = settings.publish_tf == TransformScope.ALL, settings.frame_prefix
        self._moves = getattr(scene.model, "base", None) is not None
        self._every = max(1, round(1.0 / (settings.tf_rate * scene.period)))
        self._static = node.create_publisher(TFMessage, "/tf_static", LATCHED_QOS)
        if self._all and self._tree.fixed:
            self._static.publish(self._message(0, self._tree.fixed))

    def publish(self, stamp: int, plant: Plant) -> None:
        """See `StatePublisher`; states in between are left out."""
        if self._subscribers and plant.k % self._every == 0:
            transforms = [base_transform(base_state(plant.scene, plant.t))] if self._moves else []
            transforms += self._tree.moving(plant.q) if self._all else []
            if transforms:
                self._publisher.publish(self._message(stamp, transforms))

    def _message(self, stamp: int, transforms: Sequence[Transform]) -> Any:
        return TFMessage(transforms=[self._stamped(stamp, transform) for transform in transforms])

    def _stamped(self, stamp: int, transform: Transform) -> TransformStamped:
        message = TransformStamped(child_frame_id=self._prefix + transform.child)
        message.header.frame_id = (
            transform.parent if transform.parent == WORLD else self._prefix + transform.parent
        )
        messages.set_stamp(message.header.stamp, stamp)
        set_vector(message.transform.translation, transform.translation)
        set_quaternion(message.transform.rotation, transform.rotation)
        return message
