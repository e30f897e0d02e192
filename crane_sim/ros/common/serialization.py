"""Serialization of joint states: only the numbers that change in a run are packed and unpacked.

The generated message class takes 11 µs to read a joint state and 5 µs to write one, several times
that with cold caches, and lockstep does both twice per step. Here a message of the expected layout
is packed and unpacked by one `struct.Struct` (CDR, little endian, as every ROS 2 middleware sends
it); any other is read field by field.

Reading field by field checks every length against the bytes that are there, and raises
MalformedMessage: the generated classes allocate any encoded length, and a corrupt one may be
gigabytes.
"""

import struct
from collections.abc import Sequence
from math import isfinite
from operator import itemgetter
from typing import NamedTuple

from crane_sim.ros.common.messages import NS_PER_S, MalformedMessage

# plain CDR, the only encapsulation that ROS 2 sends
_BYTE_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}


class CdrReader:
    """Sequential reader of one message; raises MalformedMessage where the bytes end too early."""

    def __init__(self, data: bytes) -> None:
        """Read the encapsulation."""
        order = _BYTE_ORDERS.get(data[:2])
        if order is None or len(data) < 4:
            raise MalformedMessage(f"not a message in plain CDR: {len(data)} bytes")
        self._data, self._order, self._offset = data, order, 4

    def integers(self, code: str) -> tuple[int, ...]:
        """Return 4-byte integers, as many as letters in `code`: i signed, I unsigned."""
        return self._numbers(code, 4, len(code))

    def doubles(self) -> tuple[float, ...]:
        """Return a sequence of doubles."""
        number = self._count(8)
        return self._numbers(f"{number}d", 8, number) if number else ()

    def string(self) -> str:
        """Return a string."""
        size = self._count(1)
        self._offset += size
        return self._data[self._offset - size : self._offset].rstrip(b"\0").decode(errors="replace")

    def strings(self) -> list[str]:
        """Return a sequence of strings."""
        return [self.string() for _ in range(self._count(4))]

    def _count(self, min_size: int) -> int:
        """Return the length of a sequence whose elements have at least `min_size` bytes each."""
        (number,) = self.integers("I")
        if number * min_size > len(self._data) - self._offset:
            elements = f"{number} elements at byte {self._offset}"
            raise MalformedMessage(f"a message of {len(self._data)} bytes that has {elements}")
        return number

    def _numbers(self, code: str, size: int, number: int) -> tuple:
        # alignment counts from the end of the encapsulation
        self._offset += -(self._offset - 4) % size
        end = self._offset + size * number
        if end > len(self._data):
            raise MalformedMessage(f"a message of {len(self._data)} bytes that ends too early")
        numbers = struct.unpack_from(self._order + code, self._data, self._offset)
        self._offset = end
        return numbers


_HEAD = b"\x00\x01\x00\x00"  # encapsulation: plain CDR, little endian


STATE = ("position", "velocity", "effort")
"""Fields of a joint state that the plant publishes: all that the message has, in its order."""
EFFORT = ("effort",)
"""Fields of a command, and of the efforts applied."""


class DecodedJointState(NamedTuple):
    """A joint state: stamp in ns; the three fields have as many numbers as the message has.

    Neither the sign of the stamp nor the numbers have been checked.
    """

    stamp: int
    names: list[str]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    effort: tuple[float, ...]

    def sort_by_joint(
        self, names: list[str], *fields: tuple[float, ...]
    ) -> tuple[tuple[float, ...], ...] | None:
        """Return `fields` of this state in the order of `names`.

        None where they have other joints or lengths, numbers that are not finite, or a stamp before
        zero.
        """
        if self.stamp < 0:
            return None
        for field in fields:
            # no comprehension: it costs lockstep half a microsecond at every state
            if len(field) != len(names) or not all(map(isfinite, field)):
                return None
        if self.names == names:
            return fields
        if sorted(self.names) != sorted(names):
            return None
        order = [self.names.index(name) for name in names]
        return tuple(tuple(field[i] for i in order) for field in fields)


class JointStateCodec:
    """Encoder and decoder of joint states of fixed names and fields."""

    def __init__(self, names: Sequence[str], fields: Sequence[str]) -> None:
        """Lay the message out for `names` (n,) with the given ones of its three fields (n,)."""
        self._names, self._n = list(names), len(names)
        layout = _Layout()
        layout.strings([""])  # frame_id
        layout.count(len(names))
        layout.strings(names)
        self._head = (_HEAD, *layout.constants[3:])
        self._spans: list[slice] = []  # of the three fields in the message's values
        for field in STATE:
            number = len(names) if field in fields else 0
            first = len(layout.constants) + 1  # behind the length
            layout.doubles(number)
            self._spans.append(slice(first, first + number))
        self._present = [field in fields for field in STATE]
        constant_indices = [i for i, value in enumerate(layout.constants) if value is not None]
        self._struct = struct.Struct(layout.format)
        self._constants_of = itemgetter(*constant_indices)
        self._constants = tuple(layout.constants[i] for i in constant_indices)

    def encode(self, stamp: int, *vectors: Sequence[float]) -> bytes:
        """Return the message with `stamp`, ns, and one vector (n,) per field, in their order."""
        head, *rest = self._head
        numbers: list[float] = []
        remaining = iter(vectors)
        for present in self._present:
            numbers += (self._n, *next(remaining)) if present else (0,)
        return self._struct.pack(head, *divmod(stamp, NS_PER_S), *rest, *numbers)

    def decode(self, data: bytes) -> DecodedJointState:
        """Return the content of a message of any layout; raises MalformedMessage if it is none."""
        try:
            values = self._struct.unpack_from(data)
        except struct.error:
            return _decode_any(data)
        if self._constants_of(values) != self._constants:
            return _decode_any(data)
        if values[2] >= NS_PER_S:
            raise MalformedMessage(_describe_stamp(values[1], values[2]))
        position, velocity, effort = self._spans
        return DecodedJointState(
            values[1] * NS_PER_S + values[2],
            self._names,
            values[position],
            values[velocity],
            values[effort],
        )


class _Layout:
    """Builder of a struct format with CDR's alignment, and the message's constants.

    The constants have None in place of every number.
    """

    def __init__(self) -> None:
        self.format = "<4siI"
        self.constants: list[object] = [_HEAD, None, None]
        self._size = 8  # alignment counts from the end of the encapsulation

    def strings(self, texts: Sequence[str]) -> None:
        for text in texts:
            encoded = text.encode() + b"\0"
            self.count(len(encoded))
            self._add(f"{len(encoded)}s", 1, len(encoded), [encoded])

    def count(self, number: int) -> None:
        self._add("I", 4, 4, [number])

    def doubles(self, number: int) -> None:
        self.count(number)
        if number:
            self._add(f"{number}d", 8, 8 * number, [None] * number)

    def _add(self, code: str, alignment: int, size: int, values: Sequence[object]) -> None:
        padding = -self._size % alignment
        self.format += f"{padding}x{code}"
        self.constants += values
        self._size += padding + size


def _describe_stamp(seconds: int, nanoseconds: int) -> str:
    return f"with the stamp {seconds} s and {nanoseconds} ns, which are more than a second"


def _decode_any(data: bytes) -> DecodedJointState:
    reader = CdrReader(data)
    seconds, rest = reader.integers("iI")
    if rest >= NS_PER_S:
        raise MalformedMessage(_describe_stamp(seconds, rest))
    reader.string()  # frame_id
    names = reader.strings()
    return DecodedJointState(
        seconds * NS_PER_S + rest, names, reader.doubles(), reader.doubles(), reader.doubles()
    )


def decode_array(data: bytes) -> tuple[float, ...]:
    """Return the numbers of a std_msgs/Float64MultiArray; raises MalformedMessage if it is none."""
    reader = CdrReader(data)
    for _ in range(*reader.integers("I")):  # dimensions, which are ignored
        reader.string()
        reader.integers("II")
    reader.integers("I")
    return reader.doubles()
