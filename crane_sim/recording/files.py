"""Names of a run's files while they are written, and where several recorders write them.

Files of a killed recorder: their locks, and their names when recovered. No Rerun, no bags here.
"""

from __future__ import annotations

import errno
import fcntl
import itertools
import os
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from io import FileIO
from pathlib import Path


def describe_gaps(recorded: int, steps: int, lost_commands: int = 0) -> str:
    """Return one line on a recording's missing steps and commands, empty if none are missing."""
    if recorded == steps and not lost_commands:
        return ""
    without = f", {lost_commands} of them without their command" if lost_commands else ""
    return f"recorder: the recording is incomplete, it has {recorded} of {steps} steps{without}"


def describe_failure(recorded: int, steps: int, before_reset: int) -> str:
    """Return a phrase on the steps in a file that could not be written further.

    Steps from before a reset are counted apart.
    """
    suffix = f" since the last reset, and {before_reset} from before it" if before_reset else ""
    return f"it has {recorded} of {steps} steps{suffix}"


def part_of(path: str, number: int) -> Path:
    """Return the name of a file's part, counted from 1; the first has the complete file's name."""
    file = Path(path)
    return file if number == 1 else file.with_name(f"{file.stem}.part{number}{file.suffix}")


def temporary_name(path: Path) -> Path:
    """Return the name of a file while its parts are being joined into it."""
    return path.with_name(path.name + ".tmp")


def unfinished_name(path: Path) -> Path:
    """Return the name of a file, or of the folder that becomes one, until it is complete."""
    return path.with_name(path.name + ".part")


def existing_parts(path: str, count: int, since: float) -> list[Path]:
    """Return the existing ones of the first `count` parts of a file, finished or not, in order.

    Files from before `since`, s of the system's clock, are another run's. Of one part there may be
    both: a recorder killed while joining the parts leaves the first one and the complete file,
    which have the same name.
    """
    names = [part_of(path, number) for number in range(1, count + 1)]
    candidates = [file for name in names for file in (unfinished_name(name), name)]
    return [file for file in candidates if file.exists() and file.stat().st_mtime >= since]


def files_before_resets(path: str, since: float) -> list[Path]:
    """Return the renamed predecessors of a file and its parts.

    They were renamed at resets since `since` [s of the system's clock].
    """
    folder, stem, suffix = (
        Path(path).parent,
        re.escape(Path(path).stem),
        re.escape(Path(path).suffix),
    )
    name = re.compile(rf"{stem}(\.part\d+)?\.before_reset_\d+{suffix}")
    matching = (
        [file for file in folder.iterdir() if name.fullmatch(file.name)] if folder.is_dir() else []
    )
    return sorted(
        (file for file in matching if file.stat().st_mtime >= since),
        key=lambda file: file.stat().st_mtime,
    )


def before_reset(path: Path, number: int) -> Path:
    """Return the first free `<name>.before_reset_<number>.<kind>`, also for an unfinished file."""
    names = (
        path.with_name(f"{path.stem}.before_reset_{n}{path.suffix}")
        for n in itertools.count(number)
    )
    return next(name for name in names if not (name.exists() or unfinished_name(name).exists()))


def set_aside(parts: Sequence[Path], complete_file: Path) -> None:
    """Rename a file's parts, in order: a single one to `complete_file`, several to part names."""
    for number, part in enumerate(parts, start=1):
        target = part_of(str(complete_file), number)
        part.replace(unfinished_name(target) if part.name.endswith(".part") else target)


def claim(part: Path) -> FileIO:
    """Make an empty unfinished file, locked until it is closed or this process ends.

    Raises:
        OSError: it cannot be made; FileExistsError: another process has it.
    """
    part.parent.mkdir(parents=True, exist_ok=True)
    file = part.open("ab", buffering=0)  # not emptied: it may be another recorder's
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.close()
        raise FileExistsError(
            errno.EEXIST, "is there already, and another run is writing it"
        ) from None
    file.truncate(0)
    return file


def acquire_lock(path: Path) -> int | None:
    """Lock a file or folder until the returned descriptor is closed or this process ends.

    Returns None where a living process has it, or has removed it meanwhile.
    """
    with suppress(FileNotFoundError):
        descriptor = os.open(path, os.O_RDONLY)
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
            if os.path.samestat(os.fstat(descriptor), path.stat()):
                return descriptor
        os.close(descriptor)
    return None


@contextmanager
def lock_file(path: Path) -> Iterator[bool]:
    """Lock a file or folder for the duration of the block; yield whether that was possible."""
    descriptor = acquire_lock(path)
    try:
        yield descriptor is not None
    finally:
        if descriptor is not None:
            os.close(descriptor)


def recovered_name(part: Path) -> Path:
    """Return a free `<name>.recovered.<kind>` for `<name>.<kind>.part`, numbered if necessary."""
    complete_file = part.with_name(part.name.removesuffix(".part"))
    number, path = (
        1,
        complete_file.with_name(f"{complete_file.stem}.recovered{complete_file.suffix}"),
    )
    while path.exists():
        number += 1
        path = complete_file.with_name(
            f"{complete_file.stem}.recovered-{number}{complete_file.suffix}"
        )
    return path
