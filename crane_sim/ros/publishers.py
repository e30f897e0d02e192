"""Who publishes a topic, as the graph knows it."""

from collections.abc import Iterator

from rclpy.node import Node
from rclpy.qos import ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo

_UNKNOWN = "_NODE_NAME_UNKNOWN_"  # rmw's word
_UNNAMED = "a node without a name"  # none of ROS, or one whose name is still on its way


def publishers(node: Node, topic: str) -> Iterator[tuple[bytes, str]]:
    """Yield identifier and full node name of every publisher that a reliable subscription hears."""
    for info in node.get_publishers_info_by_topic(topic):
        if info.qos_profile.reliability == ReliabilityPolicy.RELIABLE:
            yield bytes(info.endpoint_gid), _full_name(info)


def _full_name(info: TopicEndpointInfo) -> str:
    return _UNNAMED if info.node_name == _UNKNOWN else f"{info.node_namespace.rstrip('/')}/{info.node_name}"
