"""A subscription that says who sent a message: rclpy takes messages without their publisher's identifier, rcl with it.

No executor serves it: whoever owns it waits for messages, and takes them one by one.

Who publishes a topic, as the graph knows it.
"""

import ctypes
from collections.abc import Iterator
from typing import Any, NamedTuple

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.node import Node
from rclpy.qos import QoSProfile, ReliabilityPolicy
from rclpy.topic_endpoint_info import TopicEndpointInfo
from rclpy.type_support import check_for_type_support

_UNKNOWN = "_NODE_NAME_UNKNOWN_"  # rmw's word


_UNNAMED = "a node without a name"  # none of ROS, or one whose name is still on its way


def publishers(node: Node, topic: str) -> Iterator[tuple[bytes, str]]:
    """Yield identifier and full node name of every publisher that a reliable subscription hears."""
    for info in node.get_publishers_info_by_topic(topic):
        if info.qos_profile.reliability == ReliabilityPolicy.RELIABLE:
            yield bytes(info.endpoint_gid), _full_name(info)


def _full_name(info: TopicEndpointInfo) -> str:
    return _UNNAMED if info.node_name == _UNKNOWN else f"{info.node_namespace.rstrip('/')}/{info.node_name}"


_OK = 0  # return code of rcl


_ROOM = 4096  # bytes for a message at first; rcl makes more where it needs more


class MessageWithSender(NamedTuple):
    """A message as it came over the wire, and the identifier of its publisher."""

    data: bytes
    sender: bytes


class _Allocator(ctypes.Structure):
    _fields_ = [(name, ctypes.c_void_p) for name in ("allocate", "deallocate", "reallocate", "zero_allocate", "state")]


class _Bytes(ctypes.Structure):
    _fields_ = [
        ("buffer", ctypes.c_void_p),
        ("length", ctypes.c_size_t),
        ("capacity", ctypes.c_size_t),
        ("allocator", _Allocator),
    ]


class _About(ctypes.Structure):
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
    """The messages of one topic, each with its sender."""

    def __init__(self, node: Node, kind: Any, topic: str, qos: QoSProfile) -> None:
        """Subscribe; arguments as of `Node.create_subscription`."""
        check_for_type_support(kind)  # loads it, too
        with node.handle:
            self._handle = rclpy_implementation.Subscription(node.handle, kind, topic, qos.get_c_qos_profile())
        context: Any = node.context.handle
        with context:
            self._set = rclpy_implementation.WaitSet(1, 0, 0, 0, 0, 0, context)
        self._take = ctypes.CDLL("librcl.so").rcl_take_serialized_message
        self._pointer = ctypes.c_void_p(self._handle.pointer)
        self._bytes, self._about = _room(), _About()
        self._arguments = (self._pointer, ctypes.byref(self._bytes), ctypes.byref(self._about), None)

    def take(self) -> MessageWithSender | None:
        """Return the oldest message that waits, None where there is none."""
        if self._take(*self._arguments) != _OK:
            return None
        return MessageWithSender(ctypes.string_at(self._bytes.buffer, self._bytes.length), bytes(self._about.sender))

    def close(self) -> None:
        """Unsubscribe; what still waits is lost."""
        self._handle.destroy_when_not_in_use()
        ctypes.CDLL("librcutils.so").rcutils_uint8_array_fini(ctypes.byref(self._bytes))

    def wait(self, seconds: float) -> None:
        """Return as soon as a message waits, or after so many seconds."""
        self._set.clear_entities()
        self._set.add_subscription(self._handle)
        self._set.wait(int(seconds * 1e9))


def _room() -> _Bytes:
    """Return an array of bytes that rcl lets grow."""
    rcutils, found = ctypes.CDLL("librcutils.so"), _Bytes()
    rcutils.rcutils_get_default_allocator.restype = _Allocator
    allocator = rcutils.rcutils_get_default_allocator()
    if rcutils.rcutils_uint8_array_init(ctypes.byref(found), ctypes.c_size_t(_ROOM), ctypes.byref(allocator)) != _OK:
        raise MemoryError("no room for a message")
    return found
