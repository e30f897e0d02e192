"""Messages of a ROS 2 bag: FILE.mcap, or a folder of rosbag2, which needs the package rosbags."""

from __future__ import annotations

import logging
from typing import TYPE_CHECKING, Any, NamedTuple

from crane_sim.files.errors import shorten
from crane_sim.files.installation import MissingPackage, import_optional

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Sequence
    from pathlib import Path

    from crane_sim.recording.mcap.reader import McapContents, StoredMessage

    Decode = Callable[[bytes, str], Any]

_LOG = logging.getLogger(__name__)


class UnreadableBag(ValueError):
    """A bag that is damaged, or lacks a topic; one line without the name of its file."""


class Message(NamedTuple):
    """A message and its times."""

    topic: str  # without its namespace
    received: int  # ns, by the recorder's clock
    stamp: int  # ns, of its header; 0 where the sender left it out
    content: Any


class BagContents(NamedTuple):
    """What is readable of a bag."""

    messages: list[Message]  # in the order in which they were received
    malformed: int  # number of messages that are left out, since they cannot be decoded
    metadata: dict[str, dict[str, str]]  # by name, of MCAP files
    damage: str  # what is not as it was written, one phrase; empty for nothing
    is_checked: bool  # it has checksums


def read_messages(path: Path, required: Sequence[str], optional: Sequence[str] = ()) -> BagContents:
    """Return the messages of topics; a warning counts those that cannot be decoded.

    Args:
        path: the bag.
        required: topics without their namespaces; a bag has exactly one of each, with messages.
        optional: others that it may have.

    Raises:
        UnreadableBag: nothing of the bag is readable, or it lacks a required topic.
        MissingPackage: rosbags is not installed.
    """
    types = import_optional("rosbags.typesys", "a bag")
    store = types.get_typestore(types.Stores.ROS2_JAZZY)
    is_mcap = path.name.endswith(".mcap.part") or (path.suffix == ".mcap" and path.is_file())
    wanted = {*required, *optional}
    contents, decode = (_read_file if is_mcap else _read_folder)(
        path, store, lambda topic: _name(topic) in wanted
    )
    decoded = [(each.topic, _decode(each, decode)) for each in contents.messages]
    found = [(topic, message) for topic, message in decoded if message is not None]
    malformed = len(decoded) - len(found)
    if malformed:
        _LOG.warning("%s: %d messages cannot be decoded and are left out", path, malformed)
    _check_topics(required, {topic for topic, _ in found})
    messages = [message for _, message in found]
    return BagContents(messages, malformed, contents.metadata, contents.damage, contents.is_checked)


def _check_topics(required: Sequence[str], present: Collection[str]) -> None:
    """Raise UnreadableBag where a required topic is missing, or there are several of its name."""
    for name in required:
        topics = sorted(topic for topic in present if _name(topic) == name)
        if len(topics) != 1:
            why = (
                f"several topics, {', '.join(topics)}; give one"
                if topics
                else f"no messages of a topic {name}"
            )
            raise UnreadableBag(f"has {why}")


def _read_file(
    path: Path, store: Any, is_wanted: Callable[[str], bool]
) -> tuple[McapContents, Decode]:
    reader = import_optional("crane_sim.recording.mcap.reader", "a bag")
    try:
        return reader.read_mcap(reader.mcap_file(path), is_wanted), store.deserialize_cdr
    except (OSError, ValueError) as error:
        raise UnreadableBag(f"cannot be read: {error}") from None


def _read_folder(
    path: Path, store: Any, is_wanted: Callable[[str], bool]
) -> tuple[McapContents, Decode]:
    any_reader = import_optional("rosbags.highlevel", "a bag").AnyReader
    contents = import_optional("crane_sim.recording.mcap.reader", "a bag")
    try:
        with any_reader([path], default_typestore=store) as reader:
            chosen = [each for each in reader.connections if is_wanted(each.topic)]
            messages = reader.messages(chosen) if chosen else ()
            found = [
                contents.StoredMessage(each.topic, each.msgtype, time, data)
                for each, time, data in messages
            ]
            types = reader.typestore
            return contents.McapContents(
                found, {}, ""
            ), types.deserialize_cdr if reader.is2 else types.deserialize_ros1
    except MissingPackage:
        raise
    except Exception as error:  # of a damaged file: rosbags raises many kinds
        line = shorten(str(error).splitlines()[0] if str(error) else error)
        raise UnreadableBag(f"cannot be read: {line}") from None


def _decode(stored: StoredMessage, decode: Decode) -> Message | None:
    """Return a message, None for one that is none of its type: a topic may carry anything."""
    try:
        content = decode(stored.data, stored.kind)
        stamp = content.header.stamp
        return Message(_name(stored.topic), stored.time, stamp.sec * 10**9 + stamp.nanosec, content)
    except Exception:  # of wrong bytes: rosbags raises many kinds
        return None


def _name(topic: str) -> str:
    """Return the name of a topic without its namespace."""
    return topic.rpartition("/")[2]
