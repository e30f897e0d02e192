"""Metadata of a bag's topic, apart from its writer, which needs an optional package."""

import struct
from typing import NamedTuple

_SECOND = 1_000_000_000  # ns
_HEAD = 12  # bytes, of the encapsulation and a stamp


class Topic(NamedTuple):
    """A topic with the type and the quality of service that its publisher has."""

    name: str  # with its namespace
    kind: str  # "sensor_msgs/msg/JointState"
    stamped: bool  # its messages begin with a header, or with a time
    latched: bool  # late subscribers get the last message
    reliable: bool
    shared: bool = False  # of all nodes of the domain: its messages do not tell that this run goes
    # on


def has_stamp(data: bytes) -> bool:
    """Return whether a serialized message begins with a header whose stamp is possible."""
    if len(data) < _HEAD:
        return False
    seconds, nanoseconds = _read_time(data)
    return seconds >= 0 and nanoseconds < _SECOND


def stamp_of(data: bytes) -> int:
    """Return the stamp, ns, of a serialized message with a header; `has_stamp` must hold."""
    seconds, nanoseconds = _read_time(data)
    return seconds * _SECOND + nanoseconds


def _read_time(data: bytes) -> tuple[int, int]:
    return struct.unpack_from("<iI" if data[1] & 1 else ">iI", data, 4)
