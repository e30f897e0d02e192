"""An unfinished MCAP file: chunks in a folder beside it, joined into one file at the requested path when complete."""

import errno
import logging
import os
import shutil
import struct
from collections.abc import Mapping, Sequence
from pathlib import Path
from zlib import crc32

from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
from rosbags.rosbag2 import Writer
from rosbags.rosbag2.enums import StoragePlugin
from rosbags.rosbag2.storage_mcap import McapWriter
from rosbags.typesys import Stores, get_typestore

from crane_sim.recording.files import acquire_lock, unfinished_name
from crane_sim.recording.mcap.metadata import END, RUN, pack_metadata
from crane_sim.recording.mcap.repair import repair_folder
from crane_sim.recording.mcap.topic import Topic

_BEFORE_CHECKSUM = 33  # bytes of a chunk's record before its checksum: opcode, length, three numbers of 64 bits
_NEVER = QosTime(9_223_372_036, 854_775_807)  # ROS 2's infinite duration


class _CheckedStorage(McapWriter):
    """Writer of chunks with checksums, which that of rosbags leaves out."""

    def close_chunk(self) -> None:
        """Write the chunk, then its checksum in its place."""
        checksum, place = crc32(self.chunk.bio.getbuffer()), self.bio.tell() + _BEFORE_CHECKSUM
        super().close_chunk()
        end = self.bio.tell()
        self.bio.seek(place)
        self.bio.write(struct.pack("<I", checksum))
        self.bio.seek(end)


class _CheckedWriter(Writer):
    STORAGE_PLUGINS = {StoragePlugin.MCAP: _CheckedStorage}  # noqa: RUF012


class McapFile:
    """A ROS 2 bag of one MCAP file; every method raises OSError when the disk is full or gone.

    Attributes:
        path: the complete file.
        part: the folder that holds what there is of it until then.
    """

    def __init__(self, path: Path, topics: Sequence[Topic], properties: Mapping[str, str] | None = None) -> None:
        """Start a file of these topics and properties of the run, after recovering a killed recorder's of that name.

        Raises:
            FileExistsError: another recorder is writing it.
        """
        self.path, self.part = path, unfinished_name(path)
        _make_room(self.part)
        self._writer = _CheckedWriter(self.part, version=9, storage_plugin=StoragePlugin.MCAP)
        self._writer.open()
        self._lock = acquire_lock(self.part)
        if properties:
            self._write_metadata(RUN, properties)
        types = get_typestore(Stores.ROS2_JAZZY)
        self._connections = [
            self._writer.add_connection(topic.name, topic.kind, typestore=types, offered_qos_profiles=[_qos(topic)])
            for topic in topics
        ]

    def write(self, topic: int, time: int, data: bytes) -> None:
        """Append a serialized message of a topic, given by its number, at a time, ns."""
        self._writer.write(self._connections[topic], time, data)

    def save(self) -> None:
        """Hand what there is over to the system, as a whole chunk: it survives this process."""
        storage = self._writer.storage
        if isinstance(storage, McapWriter):
            if storage.chunk.bio.tell():
                storage.close_chunk()
            storage.bio.flush()

    def close(self, end: Mapping[str, str]) -> None:
        """Write how the run ended and the index, and move the file to its path, replacing an existing one."""
        self.save()
        self._write_metadata(END, end)
        self._writer.close()
        (self.part / f"{self.part.name}.mcap").replace(self.path)
        self._remove()

    def abandon(self) -> None:
        """Remove the unfinished file."""
        self._writer.abort()
        self._remove()

    def _write_metadata(self, name: str, values: Mapping[str, str]) -> None:
        if isinstance(self._writer.storage, McapWriter):
            self._writer.storage.bio.write(pack_metadata(name, values))

    def _remove(self) -> None:
        shutil.rmtree(self.part)
        if self._lock is not None:
            os.close(self._lock)


def _make_room(part: Path) -> None:
    if not part.exists():
        return
    recovered = repair_folder(part)
    if part.exists():
        raise FileExistsError(errno.EEXIST, "is there already, and another run is writing it")
    result = f"recovered as {recovered}" if recovered else "removed, nothing was saved in it"
    logging.getLogger(__name__).warning("%s was left by a killed run: %s", part, result)


def _qos(topic: Topic) -> Qos:
    return Qos(
        history=QosHistory.KEEP_LAST,
        depth=1 if topic.latched else 10,
        reliability=QosReliability.RELIABLE if topic.reliable else QosReliability.BEST_EFFORT,
        durability=QosDurability.TRANSIENT_LOCAL if topic.latched else QosDurability.VOLATILE,
        deadline=_NEVER,
        lifespan=_NEVER,
        liveliness=QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=_NEVER,
        avoid_ros_namespace_conventions=False,
    )
