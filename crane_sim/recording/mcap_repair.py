"""Makes MCAP files readable that a killed recorder left in `.part` folders.

Records stand one after the other, each with its length in front; what was saved is a sequence of whole ones.
"""

from __future__ import annotations

import shutil
from math import inf
from typing import TYPE_CHECKING

from crane_sim.recording.leftover import free_name, held
from crane_sim.recording.mcap_index import ending, scanned

if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path


def repair_folder(part: Path, left: Callable[[], float] = lambda: inf) -> Path | None:
    """Turn a leftover into `<name>.recovered.mcap`, and remove it.

    Returns None, and leaves it alone, where a recorder is still writing it; None, too, where nothing was saved in it.

    Args:
        part: the folder.
        left: returns the seconds that are left.

    Raises:
        OSError: the disk is full or gone, or no time is left.
    """
    with held(part) as ours:
        if not ours:
            return None
        target = None
        for file in sorted(part.glob("*.mcap")):
            if _closed(file, left):
                target = free_name(part)
                file.replace(target)
        shutil.rmtree(part)
        return target


def _closed(path: Path, left: Callable[[], float]) -> bool:
    """Cut a file behind its last whole record and write its index there; return whether it has messages."""
    with path.open("r+b") as file:
        end, chunks = scanned(file)
        found = any(chunk.indices for chunk in chunks)
        if found:
            behind = ending(file, end, chunks, left)
            file.seek(end)
            file.truncate()
            file.write(behind)
        return found
