"""Makes MCAP files readable that a killed recorder left in `.part` folders.

Records stand one after the other, each with its length in front; what was saved is a sequence of whole ones. A reader
needs no more than an end mark behind them: the index is optional (MCAP specification, "Summary Section").
"""

from __future__ import annotations

import shutil
import struct
from typing import TYPE_CHECKING, BinaryIO

from crane_sim.recording.leftover import free_name, held

if TYPE_CHECKING:
    from pathlib import Path

MAGIC = b"\x89MCAP0\r\n"
CHUNK, FOOTER, DATA_END = 0x06, 0x02, 0x0F  # kinds of records
_HEAD = struct.Struct("<BQ")  # kind and length of a record
_END = _HEAD.pack(DATA_END, 4) + bytes(4) + _HEAD.pack(FOOTER, 20) + bytes(20) + MAGIC  # no checksum, no index


def repair_folder(part: Path) -> Path | None:
    """Turn a leftover into `<name>.recovered.mcap`, and remove it.

    Returns None, and leaves it alone, where a recorder is still writing it; None, too, where nothing was saved in it.

    Raises:
        OSError: the disk is full or gone.
    """
    with held(part) as ours:
        if not ours:
            return None
        target = None
        for file in sorted(part.glob("*.mcap")):
            if _closed(file):
                target = free_name(part)
                file.replace(target)
        shutil.rmtree(part)
        return target


def _closed(path: Path) -> bool:
    """Cut a file behind its last whole record and put an end mark there; return whether it has messages."""
    with path.open("r+b") as file:
        end, chunks = _whole_records(file)
        if chunks:
            file.seek(end)
            file.truncate()
            file.write(_END)
        return chunks > 0


def _whole_records(file: BinaryIO) -> tuple[int, int]:
    """Return where the last whole record ends, and how many of them are chunks of messages."""
    size = file.seek(0, 2)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        return 0, 0
    end, chunks = len(MAGIC), 0
    while end + _HEAD.size <= size:
        file.seek(end)
        kind, length = _HEAD.unpack(file.read(_HEAD.size))
        if kind in (DATA_END, FOOTER) or end + _HEAD.size + length > size:
            break
        end += _HEAD.size + length
        chunks += kind == CHUNK
    return end, chunks
