"""An MCAP file written in chunks, which survive a killed recorder, and their recovery."""

from __future__ import annotations

import logging
import shutil
from contextlib import suppress
from io import BufferedWriter
from math import inf
from typing import IO, TYPE_CHECKING, Any

import yaml
from mcap.records import Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer
from rosbags.typesys import Stores, get_typestore

from crane_sim.recording.digest import with_digest
from crane_sim.recording.files import (
    claim,
    lock_file,
    recovered_name,
    temporary_name,
    unfinished_name,
)
from crane_sim.recording.mcap.reader import END, RUN, mcap_file, records

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence
    from pathlib import Path

    from crane_sim.recording.mcap.topic import Topic


class McapFile:
    """A ROS 2 bag of one MCAP file; every method raises OSError when the disk is full or gone.

    Attributes:
        path: the complete file.
        part: the file until then.
    """

    def __init__(
        self, path: Path, topics: Sequence[Topic], properties: Mapping[str, str] | None = None
    ) -> None:
        """Start a file of these topics and run properties; recover a killed recorder's first.

        The recovered file is the one of the same name.

        Raises:
            FileExistsError: another recorder is writing it.
        """
        self.path, self.part = path, unfinished_name(path)
        _make_room(self.part)
        self._file = claim(self.part)
        self._stream = BufferedWriter(self._file)
        self._writer = _start(self._stream)
        if properties:
            self._writer.add_metadata(RUN, with_digest(properties))
        schemas = {
            kind: self._register_kind(kind)
            for kind in dict.fromkeys(topic.kind for topic in topics)
        }
        self._channels = [
            self._writer.register_channel(
                topic.name, "cdr", schemas[topic.kind], {"offered_qos_profiles": _qos(topic)}
            )
            for topic in topics
        ]

    def write(self, topic: int, time: int, data: bytes) -> None:
        """Append a serialized message of a topic, given by its number, at a time, ns."""
        self._writer.add_message(self._channels[topic], time, data, time)

    def save(self) -> None:
        """Hand what there is over to the system, as a whole chunk: it survives this process."""
        self._writer.flush()

    def close(self, end: Mapping[str, str]) -> None:
        """Write the run's end and the index, and move the file to its path, replacing another."""
        self.save()
        self._writer.add_metadata(END, with_digest(end))
        self._writer.finish()
        self._stream.flush()
        self.part.replace(self.path)
        self._file.close()

    def abandon(self) -> None:
        """Remove the unfinished file."""
        self.part.unlink()
        self._file.close()

    def _register_kind(self, kind: str) -> int:
        definition, _ = get_typestore(Stores.ROS2_JAZZY).generate_msgdef(kind, ros_version=2)
        return self._writer.register_schema(kind, "ros2msg", definition.encode())


def _start(stream: IO[Any]) -> Writer:
    writer = Writer(stream, compression=CompressionType.NONE)
    writer.start("ros2", "crane_sim")
    return writer


def _qos(topic: Topic) -> str:
    """Return the quality of service as rosbag2 writes it."""
    never = {"sec": 9_223_372_036, "nsec": 854_775_807}  # ROS 2's infinite duration
    profile = {
        "history": "keep_last",
        "depth": 1 if topic.latched else 10,
        "reliability": "reliable" if topic.reliable else "best_effort",
        "durability": "transient_local" if topic.latched else "volatile",
        "deadline": {**never},
        "lifespan": {**never},
        "liveliness": "automatic",
        "liveliness_lease_duration": {**never},
        "avoid_ros_namespace_conventions": False,
    }
    return yaml.safe_dump([profile])


def _make_room(part: Path) -> None:
    if not part.exists():
        return
    recovered = recover_bag(part)
    if not part.exists():  # else another recorder is writing it
        result = f"recovered as {recovered}" if recovered else "removed, nothing was saved in it"
        logging.getLogger(__name__).warning("%s was left by a killed run: %s", part, result)


def recover_bag(part: Path, time_left: Callable[[], float] = lambda: inf) -> Path | None:
    """Write a killed recorder's messages into `<name>.recovered.mcap`, and remove its file.

    Returns None, and leaves it alone, where a recorder is still writing it; None, too, where it has
    no messages.

    Args:
        part: the unfinished file, by older versions a folder with it.
        time_left: returns the seconds that are left.

    Raises:
        OSError: the disk is full or gone, or no time is left; all is as it was.
    """
    with lock_file(part) as acquired:
        if not acquired:
            return None
        target = recovered_name(part)
        temporary = temporary_name(target)
        try:
            left = mcap_file(part)
            found = left.is_file() and _copy_messages(left, temporary, time_left)
            if found:
                temporary.replace(target)
        finally:
            temporary.unlink(missing_ok=True)
        shutil.rmtree(part) if part.is_dir() else part.unlink()
        return target if found else None


def _copy_messages(source: Path, target: Path, time_left: Callable[[], float]) -> bool:
    """Write a file with all that is whole of another one; return whether that has messages."""
    found = False
    with source.open("rb") as left, target.open("wb") as file, suppress(ValueError):  # no MCAP file
        copier = _Copier(_start(file))
        for record in records(left):
            if time_left() <= 0.0:
                raise TimeoutError("no time is left to read all messages")
            found |= copier.copy(record)
        copier.writer.finish()
    return found


class _Copier:
    """Copies records of another file, each schema and channel once."""

    def __init__(self, writer: Writer) -> None:
        self.writer = writer
        self._schemas: dict[int, int] = {}
        self._channels: dict[int, int] = {}

    def copy(self, record: Any) -> bool:
        """Copy a record; return whether it is a message."""
        writer, schemas, channels = self.writer, self._schemas, self._channels
        match record:
            case Metadata():
                writer.add_metadata(record.name, record.metadata)
            case Schema() if record.id not in schemas:
                about = (record.name, record.encoding, record.data)
                schemas[record.id] = writer.register_schema(*about)
            case Channel() if record.id not in channels and record.schema_id in schemas:
                schema = schemas[record.schema_id]
                about = (record.topic, record.message_encoding, schema, record.metadata)
                channels[record.id] = writer.register_channel(*about)
            case Message() if record.channel_id in channels:
                channel, time = channels[record.channel_id], record.log_time
                writer.add_message(channel, time, record.data, record.publish_time, record.sequence)
                return True
        return False
