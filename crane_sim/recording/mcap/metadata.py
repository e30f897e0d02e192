"""Metadata of a run in a bag: a record behind the file's header, which a killed recorder leaves, and one at the end.

Layout: MCAP specification, "Metadata": a name, and a map of strings.
"""

from __future__ import annotations

import struct
from typing import TYPE_CHECKING

from crane_sim.recording.digest import with_digest
from crane_sim.recording.mcap.repair import MAGIC

if TYPE_CHECKING:
    from collections.abc import Mapping
    from pathlib import Path

RUN = "crane_sim.run"
"""Name of the record with the properties that the run's recording has: its scene, the versions, ..."""
END = "crane_sim.end"
"""Name of the record at the end of a complete file: how many steps it has, and how the run ended."""
METADATA, HEADER = 0x0C, 0x01
_HEAD, _LENGTH = struct.Struct("<BQ"), struct.Struct("<I")


def pack_metadata(name: str, values: Mapping[str, str]) -> bytes:
    """Return the record, in which the values have a digest."""
    pairs = b"".join(_pack_string(text) for item in with_digest(values).items() for text in item)
    body = _pack_string(name) + _LENGTH.pack(len(pairs)) + pairs
    return _HEAD.pack(METADATA, len(body)) + body


def read_metadata(path: Path, name: str) -> dict[str, str]:
    """Return the values of the record of this name before a file's messages, with their digest; empty without one."""
    with path.open("rb") as file:
        size = file.seek(0, 2)
        file.seek(0)
        if file.read(len(MAGIC)) != MAGIC:
            return {}
        while len(head := file.read(_HEAD.size)) == _HEAD.size:
            kind, length = _HEAD.unpack(head)
            if kind not in (HEADER, METADATA) or file.tell() + length > size:
                return {}
            found, values = unpack_metadata(file.read(length)) if kind == METADATA else ("", {})
            if found == name:
                return values
            if kind == HEADER:
                file.seek(length, 1)
    return {}


def _pack_string(text: str) -> bytes:
    data = text.encode()
    return _LENGTH.pack(len(data)) + data


def unpack_metadata(body: bytes) -> tuple[str, dict[str, str]]:
    """Return the name and the values of a record's body; none where it is damaged."""
    at, texts = 0, list[str]()
    while at + _LENGTH.size <= len(body):
        (size,) = _LENGTH.unpack_from(body, at)
        at += _LENGTH.size
        if len(texts) == 1 and size == len(body) - at:  # of the map, behind the name
            texts.append("")
            continue
        texts.append(body[at : at + size].decode(errors="replace"))
        at += size
    return texts[0] if texts else "", dict(zip(texts[2::2], texts[3::2], strict=False))
