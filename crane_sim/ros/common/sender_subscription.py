"""Subscriptions with senders, which rclpy lacks, and the publishers of a topic in the ROS graph.

No executor serves such a subscription: its owner takes messages one by one.
"""

import ctypes
import os
from collections.abc import Iterator
from typing import Any, NamedTuple

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rclpy.type_support import check_for_type_support

_UNKNOWN = "_NODE_NAME_UNKNOWN_"  # of rmw
UNNAMED = "a node without a name"
"""Name of a node that is none of ROS, or whose name has not arrived yet."""
GONE = "a node no longer in the graph"
_OK = 0  # return code of rcl
_CAPACITY = 4096  # bytes of a message at first; rcl reallocates for larger ones


class Publisher(NamedTuple):
    """A publisher in the ROS graph."""

    gid: bytes  # identifier
    node: str  # full name
    reliable: bool  # else a reliable subscription is not matched with it


def publishers(node: Node, topic: str) -> Iterator[Publisher]:
    """Yield every publisher of a topic in the graph."""
    for info in node.get_publishers_info_by_topic(topic):
        reliable = info.qos_profile.reliability == ReliabilityPolicy.RELIABLE
        yield Publisher(bytes(info.endpoint_gid), full_name(info), reliable)


def full_name(info: TopicEndpointInfo) -> str:
    """Return the full name of the node with this end of a topic."""
    return (
        UNNAMED
        if info.node_name == _UNKNOWN
        else f"{info.node_namespace.rstrip('/')}/{info.node_name}"
    )


class MessageWithSender(NamedTuple):
    """A serialized message, the identifier of its publisher, and when that sent it."""

    data: bytes
    sender: bytes
    sent: int = 0  # ns of the publisher's clock


class _Allocator(ctypes.Structure):
    _fields_ = [
        (name, ctypes.c_void_p)
        for name in ("allocate", "deallocate", "reallocate", "zero_allocate", "state")
    ]


class _SerializedMessage(ctypes.Structure):
    _fields_ = [
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", _Allocator),
    ]


class _MessageInfo(ctypes.Structure):
    _fields_ = [
        ("sent", ctypes.c_int64),
        ("received", ctypes.c_int64),
        ("number_sent", ctypes.c_uint64),
        ("number_received", ctypes.c_uint64),
        ("implementation", ctypes.c_void_p),
        ("sender", ctypes.c_uint8 * 16),
        ("within_process", ctypes.c_bool),
    ]


class SenderSubscription:
    """A subscription that takes the messages of one topic with their senders.

    Attributes:
        handle: of rclpy.
        topic: its name with the namespace.
    """

    def __init__(self, node: Node, kind: Any, topic: str, qos: QoSProfile) -> None:
        """Subscribe; arguments: see `Node.create_subscription`."""
        check_for_type_support(kind)  # loads it, too
        with node.handle:
            self.handle = rclpy_implementation.Subscription(
                node.handle, kind, topic, qos.get_c_qos_profile()
            )
        self.topic: str = self.handle.get_topic_name()
        self._take_message = ctypes.CDLL("librcl.so").rcl_take_serialized_message
        self._pointer = ctypes.c_void_p(self.handle.pointer)
        self._message, self._info = _allocate_message(), _MessageInfo()
        self._arguments = (
            self._pointer,
            ctypes.byref(self._message),
            ctypes.byref(self._info),
            None,
        )

    def count_publishers(self) -> int:
        """Return the number of publishers that it is matched with."""
        return self.handle.get_publisher_count()

    def take(self) -> MessageWithSender | None:
        """Take the oldest message, None where there is none."""
        if self._take_message(*self._arguments) != _OK:
            return None
        data = ctypes.string_at(self._message.buffer, self._message.length)
        return MessageWithSender(data, bytes(self._info.sender), self._info.sent)

    def count_arrivals(self) -> int:
        """Return an eventfd that counts the messages that have come, and new ones as they come."""
        arrivals = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_CLOEXEC)
        rcl, libc = ctypes.CDLL("librcl.so"), ctypes.CDLL(None)
        # the middleware calls it with the descriptor and the number: no Python runs in its thread
        write = ctypes.cast(libc.eventfd_write, ctypes.c_void_p)
        rcl.rcl_subscription_set_on_new_message_callback(
            self._pointer, write, ctypes.c_void_p(arrivals)
        )
        return arrivals


def _allocate_message() -> _SerializedMessage:
    """Return an array of bytes that rcl can reallocate."""
    rcutils, message = ctypes.CDLL("librcutils.so"), _SerializedMessage()
    rcutils.rcutils_get_default_allocator.restype = _Allocator
    allocator = rcutils.rcutils_get_default_allocator()
    arguments = ctypes.byref(message), ctypes.c_size_t(_CAPACITY), ctypes.byref(allocator)
    if rcutils.rcutils_uint8_array_init(*arguments) != _OK:
        raise MemoryError("no room for a message")
    return message
