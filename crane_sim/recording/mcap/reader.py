"""Messages of an MCAP file, of one that is cut or damaged those that are whole; its index is not used.

Checksums of chunks are compared, and the number of messages with that of the statistics at the end. Layout of records:
MCAP specification (mcap.dev/spec), "Records".
"""

from __future__ import annotations

import os
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from importlib import import_module
from typing import TYPE_CHECKING, BinaryIO, NamedTuple
from zlib import crc32

from crane_sim.recording.digest import DIGEST
from crane_sim.recording.mcap.metadata import METADATA, unpack_metadata
from crane_sim.recording.mcap.repair import CHANNEL, CHUNK, FOOTER, MAGIC, MESSAGE, SCHEMA, STATISTICS

if TYPE_CHECKING:
    from pathlib import Path

_HEAD, _ID, _SIZE, _TEXT = struct.Struct("<BQ"), struct.Struct("<H"), struct.Struct("<Q"), struct.Struct("<I")
_CHUNK = struct.Struct("<QQQI")  # first and last time [ns], uncompressed size, checksum
_MESSAGE = struct.Struct("<HIQQ")  # channel, sequence number, times [ns]
_LAST_OPCODE = 15
_DAMAGE = (ValueError, LookupError, struct.error, RuntimeError, EOFError, MemoryError)
"""What parsing a damaged record may raise."""


class StoredMessage(NamedTuple):
    """A message, serialized."""

    topic: str  # with its namespace
    kind: str  # "sensor_msgs/msg/JointState"
    time: int  # ns
    data: bytes


class McapContents(NamedTuple):
    """What is readable of a file."""

    messages: list[StoredMessage]  # of the wanted topics, in the order of their times
    metadata: dict[str, dict[str, str]]  # by name
    damage: str  # what is not as it was written, one phrase; empty for nothing
    is_checked: bool  # chunks have checksums


def mcap_file(path: Path) -> Path:
    """Return the file itself: of the folder of an unfinished bag that in it."""
    return next(iter(sorted(path.glob("*.mcap"))), path) if path.is_dir() else path


def read_mcap(path: Path, is_wanted: Callable[[str], bool]) -> McapContents:
    """Return what is readable of a file: messages of the topics that are wanted, damage of all.

    Args:
        path: of the file.
        is_wanted: whether a topic is, by its name with the namespace.

    Raises:
        ValueError: it does not begin as an MCAP file does; one phrase.
        ModuleNotFoundError: it is compressed, and rosbags is not installed.
        OSError: it cannot be read.
    """
    with path.open("rb") as file:
        if file.read(len(MAGIC)) != MAGIC:
            raise ValueError("it is no MCAP file")
        records = _Records(is_wanted)
        for opcode, content in _records(file):
            records.add(opcode, content)
            if opcode == FOOTER:
                break
        else:
            records.unreadable += _has_end(file)
        return records.contents()


def _records(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield (opcode, content) of the whole records."""
    rest = os.fstat(file.fileno()).st_size - len(MAGIC)
    while len(head := file.read(_HEAD.size)) == _HEAD.size:
        opcode, length = _HEAD.unpack(head)
        rest -= _HEAD.size + length
        if rest < 0:
            return
        yield opcode, file.read(length)


def _has_end(file: BinaryIO) -> bool:
    """Whether a file ends as a complete one does, though its records do not."""
    file.seek(-len(MAGIC), os.SEEK_END)
    return file.read() == MAGIC


class _Records:
    """The records of a file so far.

    Attributes:
        unreadable: number of those that are damaged.
    """

    def __init__(self, is_wanted: Callable[[str], bool]) -> None:
        self.unreadable, self._is_wanted = 0, is_wanted
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, tuple[int, str]] = {}  # (schema, topic)
        self._messages: list[tuple[int, int, bytes]] = []  # (time [ns], channel, data); not those of unwanted topics
        self._numbers = Counter[int]()  # of messages, by channel
        self._metadata: dict[str, dict[str, str]] = {}
        self._count: int | None = None  # of the statistics
        self._ended = self._is_checked = False

    def add(self, opcode: int, content: bytes) -> None:
        """Take a record; of a damaged chunk nothing."""
        try:
            if not 0 < opcode <= _LAST_OPCODE or (opcode == MESSAGE and self._is_checked):
                raise ValueError(f"record {opcode}")
            if opcode == CHUNK:
                checksum, records = _unpack_chunk(content, self._is_checked)
                self._is_checked = self._is_checked or checksum > 0
                for each in list(_parse(records)):
                    self._take(*each)
            else:
                self._take(opcode, content)
        except _DAMAGE:
            self.unreadable += 1

    def contents(self) -> McapContents:
        """Return what there is of the file."""
        known = {number for number, (schema, _) in self._channels.items() if schema in self._schemas}
        total, readable = self._numbers.total(), sum(self._numbers[number] for number in known)
        damage = []
        if lost := self.unreadable + (self._ended and self._count is None):
            damage.append(f"{lost} of its parts cannot be read")
        if self._count not in (None, readable) or readable < total:
            damage.append(f"{readable} of {max(self._count or 0, total)} messages are readable")
        wanted = [each for each in self._messages if each[1] in known and self._wants(each[1])]
        found = [self._named(*each) for each in sorted(wanted, key=lambda each: each[0])]
        return McapContents(found, self._metadata, "; ".join(damage), self._is_checked)

    def _take(self, opcode: int, content: bytes) -> None:
        if opcode == SCHEMA:  # repeated at the end, where no checksum protects them
            self._schemas.setdefault(_ID.unpack_from(content)[0], _text(content, _ID.size)[0])
        elif opcode == CHANNEL:
            number, schema = struct.unpack_from("<HH", content)
            self._channels.setdefault(number, (schema, _text(content, 2 * _ID.size)[0]))
        elif opcode == MESSAGE:
            channel, _, time, _ = _MESSAGE.unpack_from(content)
            self._numbers[channel] += 1
            if self._wants(channel):
                self._messages.append((time, channel, content[_MESSAGE.size :]))
        elif opcode == METADATA:
            name, values = unpack_metadata(content)
            self._metadata.setdefault(name, values)
            self._is_checked = self._is_checked or DIGEST in values
        elif opcode == STATISTICS:
            (self._count,) = _SIZE.unpack_from(content)
        self._ended = self._ended or opcode == FOOTER

    def _wants(self, channel: int) -> bool:
        """Whether messages of a channel are kept: those of one whose topic is not known yet are."""
        return channel not in self._channels or self._is_wanted(self._channels[channel][1])

    def _named(self, time: int, channel: int, data: bytes) -> StoredMessage:
        schema, topic = self._channels[channel]
        return StoredMessage(topic, self._schemas[schema], time, data)


def _unpack_chunk(content: bytes, is_checked: bool) -> tuple[int, bytes]:
    """Return (checksum, 0 for none; the records in a chunk); ValueError where the checksum does not agree."""
    _, _, size, checksum = _CHUNK.unpack_from(content)
    compression, at = _text(content, _CHUNK.size)
    (length,) = _SIZE.unpack_from(content, at)
    data = content[at + _SIZE.size :][:length]
    if compression:
        return checksum, _decompress(data, compression, size, checksum)
    if len(data) != size or ((checksum or is_checked) and crc32(data) != checksum):
        raise ValueError("checksum")
    return checksum, data


def _decompress(data: bytes, compression: str, size: int, checksum: int) -> bytes:
    storage = import_module("rosbags.rosbag2.storage_mcap")
    try:
        return storage.decompress(data, compression, size, checksum)
    except Exception as error:  # of a damaged chunk: each kind of compression raises its own
        raise ValueError("compression") from error


def _parse(data: bytes) -> Iterator[tuple[int, bytes]]:
    """Yield (opcode, content) of each record in a chunk; ValueError where one is longer than what is left."""
    at = 0
    while at < len(data):
        opcode, length = _HEAD.unpack_from(data, at)
        at += _HEAD.size + length
        if at > len(data):
            raise ValueError("length")
        yield opcode, data[at - length : at]


def _text(content: bytes, at: int) -> tuple[str, int]:
    """Return (text, offset behind it)."""
    begin = at + _TEXT.size
    end = begin + _TEXT.unpack_from(content, at)[0]
    if end > len(content):
        raise ValueError("length")
    return content[begin:end].decode(), end
