"""Chunks of a recording's file, decoded without Rerun, which aborts at some damaged files.

A file is a sequence of messages behind a head: kind, length, content, which is a message of
protobuf. The content of a chunk is an Arrow stream of one batch, compressed by LZ4. Of a file that
is cut the messages before that are whole; a message that is damaged is left out.
"""

from __future__ import annotations

import logging
import os
import shutil
import struct
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

import pyarrow as pa

from crane_sim.files.errors import SceneError

MAGIC = b"RRF2"
_HEAD_SIZE = 12  # magic, version, options
_MESSAGE = struct.Struct("<QQ")  # kind, length
_END, _STORE, _CHUNK, _ACTIVATION = range(4)  # kinds
_STORE_ID, _COMPRESSION, _SIZE, _PAYLOAD = 1, 2, 3, 5  # fields of a chunk
# values: of the compression, of the kind of a store; the other one is a blueprint
_LZ4, _RECORDING = 2, 1
_MAX_RATIO = 256  # of LZ4
_VARINT, _BYTES = 0, 2  # types of fields
_CODEC = pa.Codec("lz4_raw")
_DAMAGE = (
    pa.ArrowException,
    ValueError,
    LookupError,
    TypeError,
    OSError,
    MemoryError,
    StopIteration,
)
"""What decoding a damaged message may raise."""


class NoRecording(ValueError):
    """A file that has not even the head of a recording."""


class Chunk(NamedTuple):
    """Rows of an entity."""

    entity: str  # without the first slash
    is_static: bool
    batch: pa.RecordBatch


class Contents(NamedTuple):
    """What is readable of a file."""

    chunks: list[Chunk]
    unreadable: int  # number of damaged messages


def read_chunks(path: Path, prefixes: tuple[str, ...]) -> Contents:
    """Return the chunks of entities whose names begin with one of the prefixes.

    Raises:
        NoRecording: the file does not begin as a recording does.
        OSError: it cannot be read.
    """
    chunks, unreadable = list[Chunk](), 0
    with path.open("rb") as file:
        if file.read(_HEAD_SIZE)[: len(MAGIC)] != MAGIC:
            raise NoRecording("it holds no recording")
        for kind, content in _messages(file):
            try:
                chunk = _decode(kind, content)
            except _DAMAGE:
                unreadable += 1
                continue
            if chunk is not None and chunk.entity.startswith(prefixes):
                chunks.append(chunk)
    return Contents(chunks, unreadable)


def whole_size(path: Path) -> int | None:
    """Return where a cut recording's last whole message ends; None if it is whole or none."""
    with path.open("rb") as file:
        if file.read(_HEAD_SIZE)[: len(MAGIC)] != MAGIC:
            return None
        end, rest = _HEAD_SIZE, os.fstat(file.fileno()).st_size
        while len(head := file.read(_MESSAGE.size)) == _MESSAGE.size:
            kind, length = _MESSAGE.unpack(head)
            if end + _MESSAGE.size + length > rest:
                return end
            if kind == _END:
                return None
            end = file.seek(length, os.SEEK_CUR)
        return end


def _messages(file: BinaryIO) -> Iterator[tuple[int, bytes]]:
    """Yield (kind, content) of the whole messages, up to the end or to where the file is cut."""
    rest = os.fstat(file.fileno()).st_size - _HEAD_SIZE
    while len(head := file.read(_MESSAGE.size)) == _MESSAGE.size:
        kind, length = _MESSAGE.unpack(head)
        rest -= _MESSAGE.size + length
        if kind == _END or rest < 0:
            return
        yield kind, file.read(length)


def _decode(kind: int, content: bytes) -> Chunk | None:
    """Return the chunk in a message, None for one of another kind, or of a blueprint."""
    if kind not in (_STORE, _CHUNK, _ACTIVATION):
        raise ValueError(f"a message of the kind {kind}")
    if kind != _CHUNK:
        return None
    fields = dict(_fields(content))
    if dict(_fields(fields[_STORE_ID])).get(1) != _RECORDING:
        return None
    batch = _read_batch(fields)
    entity = batch.schema.metadata[b"rerun:entity_path"].decode().removeprefix("/")
    return Chunk(entity, not any(_is_index(field) for field in batch.schema), batch)


def _read_batch(fields: dict[int, Any]) -> pa.RecordBatch:
    """Return a chunk's batch, checked: wrong offsets would end the process."""
    payload, size = fields[_PAYLOAD], fields.get(_SIZE, 0)
    if fields.get(_COMPRESSION) == _LZ4:
        if size > _MAX_RATIO * len(payload):
            raise ValueError(f"{size} bytes in {len(payload)}")
        payload = _CODEC.decompress(payload, size)
    with pa.ipc.open_stream(payload) as stream:
        batch = stream.read_next_batch()
    batch.validate(full=True)
    for column in batch.columns:
        if pa.types.is_list(column.type) and pa.types.is_string(column.type.value_type):
            column.flatten().to_pylist()  # raises where it is no UTF-8, which validation leaves out
    return batch


def _is_index(field: pa.Field) -> bool:
    return (field.metadata or {}).get(b"rerun:kind") == b"index"


def _fields(data: bytes) -> Iterator[tuple[int, Any]]:
    """Yield (number, value) of a protobuf message's fields, those of fixed size as bytes."""
    at = 0
    while at < len(data):
        tag, at = _varint(data, at)
        kind = tag & 7
        if kind == _VARINT:
            value, at = _varint(data, at)
        else:
            size, at = _varint(data, at) if kind == _BYTES else ({1: 8, 5: 4}[kind], at)
            value, at = data[at : at + size], at + size
        yield tag >> 3, value


def _varint(data: bytes, at: int) -> tuple[int, int]:
    """Return (number, offset behind it)."""
    number = shift = 0
    while True:
        number |= (data[at] & 0x7F) << shift
        shift, at = shift + 7, at + 1
        if data[at - 1] < 0x80:
            return number, at


def open_viewable(recording: Path) -> BinaryIO | None:
    """Return a nameless file of what is whole of a cut recording; None of a whole one.

    The viewer does not end to load one that is cut.

    Raises:
        SceneError: it is an unfinished bag.
    """
    if recording.name.endswith(".mcap.part"):
        raise SceneError(
            f"{recording}: is an unfinished bag, which the viewer does not load; crane report "
            "draws it"
        )
    size = whole_size(recording)
    if size is None:
        return None
    logging.getLogger(__name__).warning("%s is cut off: what is whole of it is shown", recording)
    file = tempfile.TemporaryFile(prefix="crane_sim-")
    with recording.open("rb") as source:
        shutil.copyfileobj(source, file)
    file.truncate(size)
    file.seek(0)
    return file
