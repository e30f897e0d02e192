"""ROS bags of a rig: `joint_states` positions and `joint_commands` values, in any namespace."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.files.errors import SceneError
from crane_sim.recording.bag_messages import BagContents, Message, UnreadableBag, read_messages

Array = npt.NDArray[np.float64]
STATES, COMMANDS = "joint_states", "joint_commands"
_WIDE = 1.5  # of the median distance of commands, which senders keep within half of it


class Track(NamedTuple):
    """Values of some joints over time."""

    nanoseconds: npt.NDArray[np.int64]  # (K,), which increase
    names: tuple[str, ...]  # (m,)
    values: Array  # (K, m)


class Bag(NamedTuple):
    """What of a bag counts."""

    states: Track  # positions, m or rad
    commands: Track  # in what the drives are commanded


def read_bag(
    path: Path, joints: tuple[str, ...], driven: tuple[str, ...], kinds: tuple[str, ...]
) -> Bag:
    """Return the positions and the commands in a bag: FILE.mcap, or a folder of rosbag2.

    It needs the package rosbags.

    Time is that of the stamps; where a topic has none, the time at which messages were received.

    Args:
        path: the bag.
        joints: names that are wanted.
        driven: names (nu,) of those that are actuated.
        kinds: what each of their drives is commanded (nu,): effort, velocity or position.

    Raises:
        SceneError: there is no such bag, it is damaged, or topics or joints are missing.
    """
    if not path.exists():
        raise SceneError(f"{path}: there is no such file")
    if len(set(kinds)) > 1:
        raise SceneError(
            f"{path}: drives of several kinds, {', '.join(sorted(set(kinds)))}, cannot be read "
            "from a bag"
        )
    contents = _read_contents(path)
    topics = {
        name: [each for each in contents.messages if each.topic == name]
        for name in (STATES, COMMANDS)
    }
    stamped = all(any(message.stamp for message in messages) for messages in topics.values())
    states = _track(path, topics[STATES], "position", joints, stamped)
    # what a drive is commanded is the name of the message's field, too
    field = kinds[0] if kinds else "effort"
    commands = _track(path, topics[COMMANDS], field, driven, stamped)
    if contents.damage or contents.malformed:
        _check_gaps(path, commands, states.nanoseconds[0])
    return Bag(states, commands)


def _read_contents(path: Path) -> BagContents:
    """Return the messages of both topics; a warning says where the bag is damaged."""
    try:
        contents = read_messages(path, (STATES, COMMANDS))
    except UnreadableBag as error:
        raise SceneError(f"{path}: {error}") from None
    if contents.damage:
        logging.getLogger(__name__).warning(
            "%s is damaged: %s; what is whole of it is used", path, contents.damage
        )
    return contents


def _check_gaps(path: Path, commands: Track, start: int) -> None:
    """Raise SceneError where a gap of a damaged bag may hide a lost command.

    Such a gap is longer than most distances between commands.

    `start`: instant from which times count, ns.
    """
    steps = np.diff(commands.nanoseconds)
    if steps.size and (wide := np.flatnonzero(steps > _WIDE * np.median(steps))).size:
        at = 1e-9 * (commands.nanoseconds[wide[0]] - start)
        raise SceneError(
            f"{path}: is damaged: commands after t = {at:g} s are missing, and what was held is "
            "not known"
        )


def _track(
    path: Path, messages: list[Message], field: str, wanted: tuple[str, ...], stamped: bool
) -> Track:
    """Return the values of wanted joints that are in the messages."""
    nanoseconds = np.array([each.stamp if stamped else each.received for each in messages])
    steps = np.diff(nanoseconds)
    if (back := np.flatnonzero(steps < 0)).size:
        at = 1e-9 * nanoseconds[back[0]]
        raise SceneError(f"{path}: times go back after {at:g} s: give one pass, without a reset")
    # of messages with the same stamp the first one counts
    fresh = np.concatenate([[True], steps > 0])
    present = {name for each in messages for name in each.content.name}
    names = tuple(name for name in wanted if name in present)
    rows = [
        _values(path, each.content, field, names)
        for each, new in zip(messages, fresh, strict=True)
        if new
    ]
    return Track(nanoseconds[fresh], names, np.array(rows).reshape(len(rows), len(names)))


def _values(path: Path, content: Any, field: str, names: tuple[str, ...]) -> list[float]:
    """Return the values of some joints in a message, in any order; NaN for a missing one."""
    values, present = getattr(content, field), list(content.name)
    if len(values) != len(present):
        raise SceneError(
            f"{path}: a message has {len(values)} values of {field} for {', '.join(present)}"
        )
    return [
        float(values[present.index(name)]) if name in present else float("nan") for name in names
    ]
