"""Recordings that are cut, for the viewer, which does not end to load them: a copy of what is whole."""

from __future__ import annotations

import logging
import shutil
import tempfile
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from crane_sim.files.errors import SceneError
from crane_sim.recording.rerun.rrd_file import whole_size

if TYPE_CHECKING:
    from collections.abc import Iterator
    from typing import BinaryIO


@contextmanager
def viewable(recording: Path) -> Iterator[Path]:
    """Yield a file that the viewer loads for the length of the block: the recording, or what is whole of it.

    Raises:
        SceneError: it is an unfinished bag.
    """
    size = _size_to_show(recording)
    if size is None:
        yield recording
        return
    with tempfile.TemporaryDirectory(prefix="crane_sim-") as folder:
        copy = Path(folder, f"{recording.name.removesuffix('.part').removesuffix('.rrd')}.rrd")
        with copy.open("wb") as file:
            _copy(recording, file, size)
        yield copy


def open_viewable(recording: Path) -> BinaryIO | None:
    """Return a file without a name with what is whole of a recording that is cut; None of a whole one.

    Raises:
        SceneError: it is an unfinished bag.
    """
    size = _size_to_show(recording)
    if size is None:
        return None
    file = tempfile.TemporaryFile(prefix="crane_sim-")
    _copy(recording, file, size)
    file.seek(0)
    return file


def _size_to_show(recording: Path) -> int | None:
    if recording.name.endswith(".mcap.part"):
        raise SceneError(f"{recording}: is an unfinished bag, which the viewer does not load; crane report draws it")
    size = whole_size(recording)
    if size is not None:
        logging.getLogger(__name__).warning("%s is cut off: what is whole of it is shown", recording)
    return size


def _copy(recording: Path, file: BinaryIO, size: int) -> None:
    with recording.open("rb") as source:
        shutil.copyfileobj(source, file)
    file.truncate(size)
