"""Messages of a bag of ROS 2: FILE.mcap, or a folder of rosbag2. Only reading needs the package rosbags."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

from crane_sim.files.errors import shorten
from crane_sim.files.installation import import_optional

if TYPE_CHECKING:
    from collections.abc import Iterator, Sequence
    from pathlib import Path


class UnreadableBag(ValueError):
    """A bag that is damaged, or lacks a topic; one line without the name of its file."""


class Message(NamedTuple):
    """A message and its times."""

    topic: str  # without its namespace
    received: int  # ns, by the recorder's clock
    stamp: int  # ns, of its header; 0 where the sender left it out
    content: Any


def read_messages(path: Path, required: Sequence[str], optional: Sequence[str] = ()) -> list[Message]:
    """Return the messages of topics in the order in which they were received.

    Args:
        path: the bag.
        required: topics without their namespaces; a bag has exactly one of each, with messages.
        optional: others that it may have.

    Raises:
        UnreadableBag: the bag is damaged, or lacks a required topic.
        MissingPackage: rosbags is not installed.
    """
    any_reader = import_optional("rosbags.highlevel", "a bag").AnyReader
    types = import_optional("rosbags.typesys", "a bag")
    try:
        with any_reader([path], default_typestore=types.get_typestore(types.Stores.ROS2_JAZZY)) as reader:
            return list(_messages(reader, required, optional))
    except UnreadableBag:
        raise
    except Exception as error:  # of a damaged file: rosbags raises many kinds
        line = shorten(str(error).splitlines()[0] if str(error) else error)
        raise UnreadableBag(f"cannot be read: {line}") from None


def _messages(reader: Any, required: Sequence[str], optional: Sequence[str]) -> Iterator[Message]:
    wanted = {*required, *optional}
    chosen = [each for each in reader.connections if _name(each.topic) in wanted and each.msgcount]
    for name in required:
        topics = sorted({each.topic for each in chosen if _name(each.topic) == name})
        if len(topics) != 1:
            why = f"several topics, {', '.join(topics)}; give one" if topics else f"no messages of a topic {name}"
            raise UnreadableBag(f"has {why}")
    for connection, received, data in reader.messages(chosen) if chosen else ():
        content = reader.deserialize(data, connection.msgtype)
        stamp = content.header.stamp
        yield Message(_name(connection.topic), received, stamp.sec * 10**9 + stamp.nanosec, content)


def _name(topic: str) -> str:
    """Return the name of a topic without its namespace."""
    return topic.rpartition("/")[2]
