"""Files that a killed recorder left: who holds them, what they are called when recovered. No Rerun, no bags here."""

from __future__ import annotations

import fcntl
import os
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator
    from pathlib import Path


def hold(path: Path) -> int | None:
    """Lock a file or folder until the descriptor returned is closed, or this process ends, however that happens.

    Returns None where a living process has it.
    """
    descriptor = os.open(path, os.O_RDONLY)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        return None
    return descriptor


@contextmanager
def held(path: Path) -> Iterator[bool]:
    """Lock a file or folder for the length of the block; yield whether that was possible."""
    descriptor = hold(path)
    try:
        yield descriptor is not None
    finally:
        if descriptor is not None:
            os.close(descriptor)


def free_name(part: Path) -> Path:
    """Return `<name>.recovered.<kind>` for `<name>.<kind>.part`, or the first numbered one that is free."""
    whole = part.with_name(part.name.removesuffix(".part"))
    number, path = 1, whole.with_name(f"{whole.stem}.recovered{whole.suffix}")
    while path.exists():
        number += 1
        path = whole.with_name(f"{whole.stem}.recovered-{number}{whole.suffix}")
    return path
