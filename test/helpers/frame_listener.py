"""A node's view of frames, bases and payloads in a ROS domain."""

from collections.abc import Sequence
from importlib.util import find_spec
from typing import Any

import numpy as np
from geometry_msgs.msg import PoseStamped
from graph_messages import vector
from nav_msgs.msg import Odometry
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, qos_profile_sensor_data
from scipy.spatial.transform import Rotation

from crane_sim.ros.common.messages import nanoseconds


class FrameListener:
    """What a node has received of a crane, by stamp [ns], and of the frames of all cranes.

    Attributes:
        odometry, poses: messages of the crane's topics.
        fixed, moving: transforms by child frame, of /tf_static and of each stamp of /tf.
        contested: frames that had two different transforms for one stamp; the same may come again
            for a new subscriber.
    """

    def __init__(self, node: Node, namespace: str) -> None:
        """Subscribe to the topics of the crane in a namespace."""
        self.odometry: dict[int, Odometry] = {}
        self.poses: dict[int, PoseStamped] = {}
        self.fixed: dict[str, Any] = {}
        self.moving: dict[int, dict[str, Any]] = {}
        self.contested: set[str] = set()
        node.create_subscription(Odometry, f"/{namespace}/base/odometry", self._on_odometry, 100)
        node.create_subscription(
            PoseStamped, f"/{namespace}/payload_pose", self._on_pose, qos_profile_sensor_data
        )
        if find_spec("tf2_msgs"):
            from tf2_msgs.msg import TFMessage  # pyright: ignore[reportMissingImports]

            latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
            node.create_subscription(TFMessage, "/tf_static", self._on_fixed, latched)
            node.create_subscription(TFMessage, "/tf", self._on_moving, 1000)

    def pose(self, stamp: int, frame: str) -> tuple[np.ndarray, Rotation]:
        """Return place (3,) and turn of a frame in `world`, by the transforms of a stamp."""
        if frame == "world":
            return np.zeros(3), Rotation.identity()
        transform = (self.fixed | self.moving[stamp])[frame]
        place, turn = self.pose(stamp, transform.header.frame_id)
        own = transform.transform.rotation
        here = place + turn.apply(vector(transform.transform.translation))
        return here, turn * Rotation.from_quat([own.x, own.y, own.z, own.w])

    def _on_odometry(self, message: Odometry) -> None:
        self.odometry[nanoseconds(message.header.stamp)] = message

    def _on_pose(self, message: PoseStamped) -> None:
        self.poses[nanoseconds(message.header.stamp)] = message

    def _on_fixed(self, message: Any) -> None:
        self._add(self.fixed, message.transforms)

    def _on_moving(self, message: Any) -> None:
        for stamp in {nanoseconds(transform.header.stamp) for transform in message.transforms}:
            known = dict(self.moving.get(stamp, {}))
            self._add(
                known,
                [each for each in message.transforms if nanoseconds(each.header.stamp) == stamp],
            )
            self.moving[stamp] = known  # a whole message at once: another thread reads

    def _add(self, known: dict[str, Any], transforms: Sequence[Any]) -> None:
        for transform in transforms:
            if known.setdefault(transform.child_frame_id, transform) != transform:
                self.contested.add(transform.child_frame_id)
