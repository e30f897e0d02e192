"""Records and messages of MCAP files; of a cut or damaged one, what is whole, without the index."""

from __future__ import annotations

import os
import struct
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import BinaryIO, NamedTuple

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import Channel, Chunk, Footer, McapRecord, Message, Metadata, Schema, Statistics
from mcap.stream_reader import breakup_chunk
from mcap.writer import MCAP0_MAGIC as MAGIC

from crane_sim.recording.digest import DIGEST

RUN, END = "crane_sim.run", "crane_sim.end"
"""Names of metadata: before the messages of a run's bag, its properties; behind them, how it
ended."""
_HEAD = struct.Struct("<BQ")  # opcode of a record, length of its content
_KINDS = {
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.METADATA: Metadata,
    Opcode.STATISTICS: Statistics,
    Opcode.FOOTER: Footer,
}


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

    @property
    def is_checked(self) -> bool:
        """Whether its metadata have digests, as those of older versions have not."""
        return any(DIGEST in values for values in self.metadata.values())


def mcap_file(path: Path) -> Path:
    """Return the file itself: of the folder of an unfinished bag by an older version that in it."""
    return next(iter(sorted(path.glob("*.mcap"))), path) if path.is_dir() else path


def records(file: BinaryIO) -> Iterator[McapRecord | None]:
    """Yield the whole records of a file, of a chunk those in it; None for each that is damaged.

    Raises:
        ValueError: it does not begin as an MCAP file does; one phrase.
    """
    rest = os.fstat(file.fileno()).st_size - len(MAGIC)
    if file.read(len(MAGIC)) != MAGIC:
        raise ValueError("it is no MCAP file")
    opcode = 0
    while opcode != Opcode.FOOTER and len(head := file.read(_HEAD.size)) == _HEAD.size:
        opcode, length = _HEAD.unpack(head)
        rest -= _HEAD.size + length
        if rest < 0:
            break
        yield from _parse(opcode, file.read(length))
    file.seek(-len(MAGIC), os.SEEK_END)
    if opcode != Opcode.FOOTER and file.read() == MAGIC:  # it has its end, but not all before that
        yield None


def _parse(opcode: int, content: bytes) -> list[McapRecord | None]:
    """Return the records in one, none of a kind that is not needed here."""
    stream = ReadDataStream(BytesIO(content))
    try:
        if opcode == Opcode.CHUNK:
            return [*breakup_chunk(Chunk.read(stream), validate_crc=True)]
        if opcode == Opcode.MESSAGE:
            return [Message.read(stream, len(content))]
        if opcode in _KINDS:
            return [_KINDS[Opcode(opcode)].read(stream)]
    except Exception:  # of a damaged record: each kind of compression raises its own
        return [None]
    return [] if 0 < opcode <= Opcode.DATA_END else [None]


def read_metadata(path: Path, name: str) -> dict[str, str]:
    """Return the metadata of a name before a file's messages, with their digest; empty without."""
    with path.open("rb") as file, suppress(ValueError):
        for record in records(file):
            if not isinstance(record, Metadata):
                break
            if record.name == name:
                return record.metadata
    return {}


def read_mcap(path: Path, is_wanted: Callable[[str], bool]) -> McapContents:
    """Return what is readable of a file: messages of the topics that are wanted, damage of all.

    Args:
        path: of the file.
        is_wanted: whether a topic is, by its name with the namespace.

    Raises:
        ValueError: it does not begin as an MCAP file does; one phrase.
        OSError: it cannot be read.
    """
    found = _Contents(is_wanted)
    with path.open("rb") as file:
        for record in records(file):
            found.add(record)
    return found.summarise()


class _Contents:
    """The records of a file so far."""

    def __init__(self, is_wanted: Callable[[str], bool]) -> None:
        self._is_wanted = is_wanted
        self._schemas: dict[int, str] = {}
        self._topics: dict[int, tuple[int, str]] = {}  # (schema, name) by channel
        self._messages: list[Message] = []  # of wanted topics, or of ones that are not known yet
        self._numbers = Counter[int]()  # of messages, by channel
        self._metadata: dict[str, dict[str, str]] = {}
        self._count: int | None = None  # of messages, by the statistics
        self._unreadable = 0
        self._ended = False

    def add(self, record: McapRecord | None) -> None:
        match record:
            case None:
                self._unreadable += 1
            case Schema():  # repeated at the end, where no checksum protects them
                self._schemas.setdefault(record.id, record.name)
            case Channel():
                self._topics.setdefault(record.id, (record.schema_id, record.topic))
            case Message():
                self._numbers[record.channel_id] += 1
                if self._wants(record.channel_id):
                    self._messages.append(record)
            case Metadata():
                self._metadata.setdefault(record.name, record.metadata)
            case Statistics():
                self._count = record.message_count
            case _:
                self._ended = True

    def summarise(self) -> McapContents:
        known = {
            channel for channel, (schema, _) in self._topics.items() if schema in self._schemas
        }
        messages = [
            each
            for each in self._messages
            if each.channel_id in known and self._wants(each.channel_id)
        ]
        messages.sort(key=lambda each: each.log_time)
        return McapContents(
            [self._named(each) for each in messages], self._metadata, self._damage(known)
        )

    def _damage(self, known: set[int]) -> str:
        total, readable = self._numbers.total(), sum(self._numbers[channel] for channel in known)
        damage = []
        if lost := self._unreadable + (self._ended and self._count is None):
            damage.append(f"{lost} of its parts cannot be read")
        if self._count not in (None, readable) or readable < total:
            damage.append(f"{readable} of {max(self._count or 0, total)} messages are readable")
        return "; ".join(damage)

    def _wants(self, channel: int) -> bool:
        return channel not in self._topics or self._is_wanted(self._topics[channel][1])

    def _named(self, message: Message) -> StoredMessage:
        schema, topic = self._topics[message.channel_id]
        return StoredMessage(topic, self._schemas[schema], message.log_time, message.data)
