"""An MCAP file in the making: small chunks in a folder beside it, one file where the user asked for it when complete."""

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from rosbags.interfaces import Connection, Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import Writer
from rosbags.rosbag2.enums import StoragePlugin
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.typesys import Stores, get_typestore

_NEVER = QosTime(9_223_372_036, 854_775_807)  # what rosbag2 writes for a deadline that nobody set


class Channel(NamedTuple):
    """What the file says of a topic."""

    topic: str  # with its namespace
    kind: str  # "sensor_msgs/msg/JointState"
    stamped: bool  # its messages begin with a header
    latched: bool  # late subscribers get the last message, too
    reliable: bool


class McapFile:
    """A ROS 2 bag of one MCAP file; every method raises OSError when the disk is full or gone.

    Attributes:
        path: the complete file.
        part: the folder that holds what there is of it until then.
    """

    def __init__(self, path: Path, channels: Sequence[Channel]) -> None:
        """Start a file with the given channels; raises FileExistsError where `part` is there already."""
        self.path, self.part = path, part_of(path)
        path.parent.mkdir(parents=True, exist_ok=True)
        if self.part.exists():
            raise FileExistsError(17, f"{self.part.name} is in the way: what a killed run left, or of one that runs")
        self._writer = Writer(self.part, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        types = get_typestore(Stores.ROS2_JAZZY)
        self._connections: list[Connection] = [
            self._writer.add_connection(channel.topic, channel.kind, typestore=types, offered_qos_profiles=[_qos(channel)])
            for channel in channels
        ]

    def write(self, channel: int, time: int, data: bytes) -> None:
        """Append a serialized message of a channel, by its number, at a time, ns."""
        self._writer.write(self._connections[channel], time, data)

    def save(self) -> None:
        """Hand what there is over to the system: a whole chunk that survives the end of this process."""
        storage = self._writer.storage
        if isinstance(storage, McapWriter):
            if storage.chunk.bio.tell():
                storage.close_chunk()
            storage.bio.flush()

    def close(self) -> None:
        """Write the index and give the file its place; what was there before is replaced."""
        self._writer.close()
        (self.part / f"{self.part.name}.mcap").replace(self.path)
        shutil.rmtree(self.part)

    def abandon(self) -> None:
        """Remove the unfinished file."""
        self._writer.abort()
        shutil.rmtree(self.part)


def part_of(path: Path) -> Path:
    """Return the folder in which the file of this path grows."""
    return path.with_name(path.name + ".part")


def _qos(channel: Channel) -> Qos:
    reliability = QosReliability.RELIABLE if channel.reliable else QosReliability.BEST_EFFORT
    durability = QosDurability.TRANSIENT_LOCAL if channel.latched else QosDurability.VOLATILE
    depth = 1 if channel.latched else 10
    alive = QosLiveliness.AUTOMATIC
    return Qos(QosHistory.KEEP_LAST, depth, reliability, durability, _NEVER, _NEVER, alive, _NEVER, False)
