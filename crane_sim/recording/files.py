"""Names of a run's files while they are written, and where several recorders write them.

Files of a killed recorder: their locks, and their names when recovered. No Rerun, no bags here.
"""

from __future__ import annotations

import fcntl
import os
import re
from collections.abc import Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Iterator


def part_of(path: str, number: int) -> Path:
    """Return the name of a part of a file, counted from 1; the first one has the whole's."""
    whole = Path(path)
    return whole if number == 1 else whole.with_name(f"{whole.stem}.part{number}{whole.suffix}")


def temporary_name(path: Path) -> Path:
    """Return the name under which a file grows into which its parts are just being joined."""
    return path.with_name(path.name + ".tmp")


def unfinished_name(path: Path) -> Path:
    """Return the name under which a file, or the folder that becomes one, grows until it is complete."""
    return path.with_name(path.name + ".part")


def existing_parts(path: str, count: int, since: float) -> list[Path]:
    """Return the existing ones of the first `count` parts of a file, finished or not, in order.

    Files from before `since`, s of the system's clock, are another run's. Of one part there may be both: a recorder
    killed while joining all parts has left the first one and the whole, which has its name.
    """
    wholes = [part_of(path, number) for number in range(1, count + 1)]
    candidates = [file for whole in wholes for file in (unfinished_name(whole), whole)]
    return [file for file in candidates if file.exists() and file.stat().st_mtime >= since]


def files_before_resets(path: str, since: float) -> list[Path]:
    """Return what resets have set aside of a file and of its parts since an instant [s of the system's clock]."""
    whole = Path(path)
    name = re.compile(rf"{re.escape(whole.stem)}(\.part\d+)?\.before_reset_\d+{re.escape(whole.suffix)}")
    kept = [file for file in whole.parent.iterdir() if name.fullmatch(file.name)] if whole.parent.is_dir() else []
    return sorted((file for file in kept if file.stat().st_mtime >= since), key=lambda file: file.stat().st_mtime)


def before_reset(path: Path, number: int) -> Path:
    """Return `<name>.before_reset_<number>.<kind>`, or the next such name that is free, of an unfinished file, too."""
    while (kept := path.with_name(f"{path.stem}.before_reset_{number}{path.suffix}")).exists() or unfinished_name(
        kept
    ).exists():
        number += 1
    return kept


def set_aside(parts: Sequence[Path], whole: Path) -> None:
    """Rename the parts of a file, in order: the only one to the `whole`, several to the names that its parts have."""
    for number, part in enumerate(parts, start=1):
        kept = part_of(str(whole), number)
        part.replace(unfinished_name(kept) if part.name.endswith(".part") else kept)


def acquire_lock(path: Path) -> int | None:
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
def lock_file(path: Path) -> Iterator[bool]:
    """Lock a file or folder for the length of the block; yield whether that was possible."""
    descriptor = acquire_lock(path)
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
