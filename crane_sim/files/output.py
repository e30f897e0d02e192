"""Files that commands write: each appears whole or not at all, however its writer ends."""

from __future__ import annotations

import os
import shutil
from typing import TYPE_CHECKING

from crane_sim.files.errors import SceneError

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator
    from pathlib import Path


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file under another name of its kind and rename it: it is there whole, or not.

    What a link leads to is written, with the permissions that it had; a device or a pipe as it is.

    Raises:
        OSError: it cannot be written; a file of that name that was there before is as it was.
    """
    path = path.resolve()  # a link stays one
    if path.exists() and not path.is_file():  # a device, a pipe
        write(path)
        return
    partial = path.with_name(f".{path.name}.{os.getpid()}{path.suffix}")
    try:
        write(partial)
        with partial.open("rb") as file:
            os.fsync(file.fileno())
        if path.exists():
            shutil.copymode(path, partial)
        partial.replace(path)
    finally:
        partial.unlink(missing_ok=True)


def write_text(path: Path, text: str) -> None:
    """Write a text as `write_whole` does."""
    write_whole(path, lambda partial: partial.write_text(text, encoding="utf-8"))


def write_output(option: str, file: Path, write: Callable[[Path], object]) -> None:
    """Write the file of a command's option as `write_whole` does, and its folder where missing.

    Raises:
        SceneError: it cannot be written; one line with the option, the file and why.
    """
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        write_whole(file, write)
    except OSError as error:
        raise SceneError(f"{option} {file}: cannot be written: {error.strerror or error}") from None


def partial_files(path: Path) -> Iterator[Path]:
    """Yield the files left by processes that were killed during `write_whole`."""
    return path.parent.glob(f".{path.name}.*")
