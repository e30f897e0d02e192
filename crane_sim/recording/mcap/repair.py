"""Repair of MCAP files that a killed recorder left in `.part` folders, unclosed and without an index.

Records follow each other, each with its length in front; what was saved is a sequence of whole ones, from which the
index is made. A reader without an index takes the messages in the order of the file, which is not that of their
stamps, since the effort of a step is published after the state that it led to. Layout of records: MCAP
specification, "Records".
"""

from __future__ import annotations

import shutil
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from math import inf
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

from crane_sim.recording.files import free_name, lock_file

if TYPE_CHECKING:
    from pathlib import Path


MAGIC = b"\x89MCAP0\r\n"


FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, STATISTICS = 2, 3, 4, 5, 6, 7, 8, 11


DATA_END = 15


_HEAD = struct.Struct("<BQ")  # kind and length of a record


_TIMES = struct.Struct("<QQQI")  # of a chunk: first and last time [ns], size and checksum of what is in it


_LENGTH, _SIZE, _NUMBER = struct.Struct("<I"), struct.Struct("<Q"), struct.Struct("<H")


_FRONT = (
    _TIMES.size + _LENGTH.size + _SIZE.size
)  # of a chunk's records: times, an empty string for no compression, size


_COUNTS = struct.Struct("<QHIIIIQQ")  # of the statistics


class Chunk(NamedTuple):
    """A chunk of messages and its position in the file."""

    at: int
    length: int
    span: tuple[int, int]  # times of the first message and the last, ns
    indices: dict[int, int]  # offsets of the index of each channel's messages
    indices_length: int

    @property
    def size(self) -> int:
        """Size of its records, which are not compressed, in bytes."""
        return self.length - _HEAD.size - _FRONT

    def records(self, file: BinaryIO) -> bytes:
        """Return its records."""
        file.seek(self.at + _HEAD.size + _FRONT)
        return file.read(self.size)


def scan_file(file: BinaryIO) -> tuple[int, list[Chunk]]:
    """Return where the last whole record of a file ends, and its chunks; without chunks where it is no MCAP file."""
    size = file.seek(0, 2)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        return 0, []
    end, chunks = len(MAGIC), list[Chunk]()
    while end + _HEAD.size <= size:
        file.seek(end)
        kind, length = _HEAD.unpack(file.read(_HEAD.size))
        next_end = end + _HEAD.size + length
        if kind in (DATA_END, FOOTER) or next_end > size:
            break
        if kind == CHUNK:
            first, last, _, _ = _TIMES.unpack(file.read(_TIMES.size))
            chunks.append(Chunk(end, next_end - end, (first, last), {}, 0))
        elif kind == MESSAGE_INDEX and chunks:
            (channel,) = _NUMBER.unpack(file.read(_NUMBER.size))
            chunks[-1].indices[channel] = end
            chunks[-1] = chunks[-1]._replace(indices_length=chunks[-1].indices_length + next_end - end)
        end = next_end
    return end, chunks


def index_and_footer(file: BinaryIO, end: int, chunks: list[Chunk], time_left: Callable[[], float]) -> bytes:
    """Return index and footer, without checksums, of a file whose records end at `end`.

    The chunks are not compressed, and one of them has messages; one is read at a time.

    Raises:
        TimeoutError: `time_left` is zero before all are read.
    """
    definitions = {SCHEMA: dict[int, bytes](), CHANNEL: dict[int, bytes]()}
    counts = Counter[int]()
    for chunk in chunks:
        if time_left() <= 0.0:
            raise TimeoutError("no time is left to read all messages")
        for kind, body in _records(chunk.records(file)):
            (number,) = _NUMBER.unpack_from(body)
            if kind == MESSAGE:
                counts[number] += 1
            else:
                definitions[kind][number] = _pack_record(kind, body)
    data_end = _pack_record(DATA_END, bytes(_LENGTH.size))
    summary = b"".join([*definitions[SCHEMA].values(), *definitions[CHANNEL].values()])
    indexed = [chunk for chunk in chunks if chunk.indices]  # the first one may hold nothing but definitions
    summary += _statistics(definitions, counts, indexed) + b"".join(map(_chunk_index, indexed))
    return data_end + summary + _pack_record(FOOTER, struct.pack("<QQI", end + len(data_end), 0, 0)) + MAGIC


def _records(data: bytes) -> Iterator[tuple[int, bytes]]:
    at = 0
    while at < len(data):
        kind, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size
        yield kind, data[at : at + length]
        at += length


def _pack_record(kind: int, body: bytes) -> bytes:
    return _HEAD.pack(kind, len(body)) + body


def _statistics(definitions: dict[int, dict[int, bytes]], counts: Counter[int], chunks: list[Chunk]) -> bytes:
    first, last = min(chunk.span[0] for chunk in chunks), max(chunk.span[1] for chunk in chunks)
    numbers = len(definitions[SCHEMA]), len(definitions[CHANNEL]), 0, 0, len(chunks)
    return _pack_record(STATISTICS, _COUNTS.pack(counts.total(), *numbers, first, last) + _map(counts))


def _chunk_index(chunk: Chunk) -> bytes:
    index_entry = struct.pack("<QQQQ", *chunk.span, chunk.at, chunk.length)
    sizes = _LENGTH.pack(0) + struct.pack("<QQ", chunk.size, chunk.size)
    return _pack_record(CHUNK_INDEX, index_entry + _map(chunk.indices) + _SIZE.pack(chunk.indices_length) + sizes)


def _map(values: dict[int, int]) -> bytes:
    pairs = b"".join(struct.pack("<HQ", *item) for item in values.items())
    return _LENGTH.pack(len(pairs)) + pairs


def repair_folder(part: Path, time_left: Callable[[], float] = lambda: inf) -> Path | None:
    """Turn the folder of a killed recorder into `<name>.recovered.mcap`, and remove it.

    Returns None, and leaves it alone, where a recorder is still writing it; None, too, where nothing was saved in it.

    Args:
        part: the folder.
        time_left: returns the seconds that are left.

    Raises:
        OSError: the disk is full or gone, or no time is left.
    """
    with lock_file(part) as acquired:
        if not acquired:
            return None
        target = None
        for file in sorted(part.glob("*.mcap")):
            if _close_file(file, time_left):
                target = free_name(part)
                file.replace(target)
        shutil.rmtree(part)
        return target


def _close_file(path: Path, time_left: Callable[[], float]) -> bool:
    """Cut a file behind its last whole record and write its index there; return whether it has messages."""
    with path.open("r+b") as file:
        end, chunks = scan_file(file)
        readable = any(chunk.indices for chunk in chunks)
        if readable:
            tail = index_and_footer(file, end, chunks, time_left)
            file.seek(end)
            file.truncate()
            file.write(tail)
        return readable
