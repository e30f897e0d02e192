"""Messages read field by field from bytes that may be anything: what does not fit is a ValueError, and costs nothing.

The generated classes take lengths at their word, and a length that is garbage may ask for gigabytes.
"""

import struct

_ORDERS = {b"\x00\x00": ">", b"\x00\x01": "<"}  # plain CDR, the only encapsulation that ROS 2 sends


class CdrReader:
    """Reads one message from its begin; every method raises ValueError where the bytes end too early."""

    def __init__(self, data: bytes) -> None:
        """Look at the encapsulation."""
        order = _ORDERS.get(data[:2])
        if order is None or len(data) < 4:
            raise ValueError(f"not a message in plain CDR: {len(data)} bytes")
        self._data, self._order, self._at = data, order, 4

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
        self._at += size
        return self._data[self._at - size : self._at].rstrip(b"\0").decode()

    def strings(self) -> list[str]:
        """Return a sequence of strings."""
        return [self.string() for _ in range(self._count(4))]

    def _count(self, least: int) -> int:
        """Return the length of a sequence whose elements have at least so many bytes each."""
        (number,) = self.integers("I")
        if number * least > len(self._data) - self._at:
            raise ValueError(f"a message of {len(self._data)} bytes that has {number} elements at byte {self._at}")
        return number

    def _numbers(self, code: str, size: int, number: int) -> tuple:
        self._at += -(self._at - 4) % size  # alignment counts from behind the encapsulation
        end = self._at + size * number
        if end > len(self._data):
            raise ValueError(f"a message of {len(self._data)} bytes that ends too early")
        found = struct.unpack_from(self._order + code, self._data, self._at)
        self._at = end
        return found
