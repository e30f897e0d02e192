"""Repair of MCAP files that a killed recorder left in `.part` folders, unclosed and without an index.

A file is a sequence of records: an opcode, the length of the content, the content. What was saved are complete records
and perhaps the beginning of one; the index (the summary section) is built from the complete ones, and so are the
indices of the messages of the last chunk where it was cut behind that. A reader without an
index takes the messages in the order of the file, which is not that of their stamps, since the effort of a step is
published after the state that it led to. Layout of records: MCAP specification (mcap.dev/spec), "Records".
"""

from __future__ import annotations

import shutil
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from math import inf
from typing import TYPE_CHECKING, BinaryIO, NamedTuple

from crane_sim.recording.files import lock_file, recovered_name

if TYPE_CHECKING:
    from pathlib import Path


MAGIC = b"\x89MCAP0\r\n"
FOOTER, SCHEMA, CHANNEL, MESSAGE, CHUNK, MESSAGE_INDEX, CHUNK_INDEX, STATISTICS = 2, 3, 4, 5, 6, 7, 8, 11
DATA_END = 15
"""Opcodes of records."""
_UINT16, _UINT32, _UINT64 = struct.Struct("<H"), struct.Struct("<I"), struct.Struct("<Q")
_RECORD_HEAD = struct.Struct("<BQ")  # opcode, length of the content
_CHUNK_HEAD = struct.Struct("<QQQI")  # first and last time [ns], uncompressed size, checksum
_MESSAGE_HEAD = struct.Struct("<HIQ")  # channel, sequence number, time [ns]
_BEFORE_RECORDS = _CHUNK_HEAD.size + _UINT32.size + _UINT64.size
"""Bytes of a chunk's content before its records: the head, an empty string (no compression), their size."""
_STATISTICS_HEAD = struct.Struct("<QHIIIIQQ")  # counts of messages, schemas, channels, ..., first and last time [ns]


class Chunk(NamedTuple):
    """A chunk of messages, uncompressed, and its position in the file."""

    offset: int  # of its record in the file, bytes
    length: int  # of this record, bytes
    time_range: tuple[int, int]  # times of the first message and the last, ns
    index_offsets: dict[int, int]  # of the index of each channel's messages, bytes
    index_length: int  # of all these indices, bytes

    @property
    def end(self) -> int:
        """End of its record in the file, bytes; the indices of its messages follow."""
        return self.offset + self.length

    @property
    def size(self) -> int:
        """Size of the records in it, bytes."""
        return self.length - _RECORD_HEAD.size - _BEFORE_RECORDS

    def read_records(self, file: BinaryIO) -> bytes:
        """Return the records in it."""
        file.seek(self.offset + _RECORD_HEAD.size + _BEFORE_RECORDS)
        return file.read(self.size)


def scan_file(file: BinaryIO) -> tuple[int, list[Chunk]]:
    """Return (end of the last complete record of a file, bytes; its chunks); (0, []) where it is no MCAP file."""
    size = file.seek(0, 2)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        return 0, []
    end, chunks = len(MAGIC), list[Chunk]()
    while end + _RECORD_HEAD.size <= size:
        file.seek(end)
        opcode, length = _RECORD_HEAD.unpack(file.read(_RECORD_HEAD.size))
        next_end = end + _RECORD_HEAD.size + length
        if opcode in (DATA_END, FOOTER) or next_end > size:
            break
        if opcode == CHUNK:
            first, last, _, _ = _CHUNK_HEAD.unpack(file.read(_CHUNK_HEAD.size))
            chunks.append(Chunk(end, next_end - end, (first, last), {}, 0))
        elif opcode == MESSAGE_INDEX and chunks:
            (channel,) = _UINT16.unpack(file.read(_UINT16.size))
            chunks[-1].index_offsets[channel] = end
            chunks[-1] = chunks[-1]._replace(index_length=chunks[-1].index_length + next_end - end)
        end = next_end
    return end, chunks


def build_summary_section(file: BinaryIO, end: int, chunks: list[Chunk], time_left: Callable[[], float]) -> bytes:
    """Return what ends a file whose records end at offset `end`: end of the data, summary section (index), footer.

    There are no checksums. At least one of the chunks has messages; they are read one at a time.

    Raises:
        TimeoutError: `time_left` is zero before all are read.
    """
    definitions = {SCHEMA: dict[int, bytes](), CHANNEL: dict[int, bytes]()}
    counts = Counter[int]()
    for chunk in chunks:
        if time_left() <= 0.0:
            raise TimeoutError("no time is left to read all messages")
        for _, opcode, content in _parse_records(chunk.read_records(file)):
            (identifier,) = _UINT16.unpack_from(content)
            if opcode == MESSAGE:
                counts[identifier] += 1
            else:
                definitions[opcode][identifier] = _pack_record(opcode, content)
    data_end = _pack_record(DATA_END, bytes(_UINT32.size))
    summary = b"".join([*definitions[SCHEMA].values(), *definitions[CHANNEL].values()])
    indexed = [chunk for chunk in chunks if chunk.index_offsets]  # the first one may hold nothing but definitions
    summary += _pack_statistics(definitions, counts, indexed) + b"".join(map(_pack_chunk_index, indexed))
    return data_end + summary + _pack_record(FOOTER, struct.pack("<QQI", end + len(data_end), 0, 0)) + MAGIC


def _complete_indices(file: BinaryIO, chunk: Chunk) -> tuple[Chunk, bytes]:
    """Return (the last chunk with the indices of all messages in it, these indices); empty ones where none is missing.

    The indices follow their chunk, so those of the last one are missing where the file was cut right behind it.
    """
    entries: dict[int, list[bytes]] = {}
    for offset, opcode, content in _parse_records(chunk.read_records(file)):
        if opcode == MESSAGE:
            channel, _, time = _MESSAGE_HEAD.unpack_from(content)
            entries.setdefault(channel, []).append(struct.pack("<QQ", time, offset))
    if entries.keys() <= chunk.index_offsets.keys():
        return chunk, b""
    indices, index_offsets = b"", dict[int, int]()
    for channel, each in entries.items():
        index_offsets[channel] = chunk.end + len(indices)
        pairs = b"".join(each)
        indices += _pack_record(MESSAGE_INDEX, _UINT16.pack(channel) + _UINT32.pack(len(pairs)) + pairs)
    return chunk._replace(index_offsets=index_offsets, index_length=len(indices)), indices


def _parse_records(data: bytes) -> Iterator[tuple[int, int, bytes]]:
    """Yield (offset, opcode, content) of each record."""
    offset = 0
    while offset < len(data):
        opcode, length = _RECORD_HEAD.unpack_from(data, offset)
        begin = offset + _RECORD_HEAD.size
        yield offset, opcode, data[begin : begin + length]
        offset = begin + length


def _pack_record(opcode: int, content: bytes) -> bytes:
    return _RECORD_HEAD.pack(opcode, len(content)) + content


def _pack_statistics(definitions: dict[int, dict[int, bytes]], counts: Counter[int], chunks: list[Chunk]) -> bytes:
    first, last = min(chunk.time_range[0] for chunk in chunks), max(chunk.time_range[1] for chunk in chunks)
    numbers = len(definitions[SCHEMA]), len(definitions[CHANNEL]), 0, 0, len(chunks)
    return _pack_record(STATISTICS, _STATISTICS_HEAD.pack(counts.total(), *numbers, first, last) + _pack_map(counts))


def _pack_chunk_index(chunk: Chunk) -> bytes:
    location = struct.pack("<QQQQ", *chunk.time_range, chunk.offset, chunk.length)
    indices = _pack_map(chunk.index_offsets) + _UINT64.pack(chunk.index_length)
    sizes = _UINT32.pack(0) + struct.pack("<QQ", chunk.size, chunk.size)  # no compression; its size twice
    return _pack_record(CHUNK_INDEX, location + indices + sizes)


def _pack_map(values: dict[int, int]) -> bytes:
    pairs = b"".join(struct.pack("<HQ", *item) for item in values.items())
    return _UINT32.pack(len(pairs)) + pairs


def repair_folder(part: Path, time_left: Callable[[], float] = lambda: inf) -> Path | None:
    """Turn the folder of a killed recorder into `<name>.recovered.mcap`, and remove it.

    Returns None, and leaves it alone, where a recorder is still writing it; None, too, where it has no messages.

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
                target = recovered_name(part)
                file.replace(target)
        shutil.rmtree(part)
        return target


def _close_file(path: Path, time_left: Callable[[], float]) -> bool:
    """Cut a file behind its last complete record and write its index there; return whether it has messages."""
    with path.open("r+b") as file:
        end, chunks = scan_file(file)
        indices = b""
        if chunks:
            chunks[-1], indices = _complete_indices(file, chunks[-1])
        readable = any(chunk.index_offsets for chunk in chunks)
        if readable:
            begin = chunks[-1].end if indices else end
            tail = indices + build_summary_section(file, begin + len(indices), chunks, time_left)
            file.seek(begin)
            file.truncate()
            file.write(tail)
        return readable
