"""The file of a recording while it grows: locked, written here, renamed when it is complete.

Rerun writes into a pipe, and a thread copies that to the file. Its own writer ends when the disk
refuses it, and calls that then wait for it may wait for ever.
"""

from __future__ import annotations

import os
import select
import shutil
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from io import FileIO
from pathlib import Path

import rerun as rr
import rerun.blueprint as rrb

from crane_sim.recording.files import claim, unfinished_name
from crane_sim.recording.rerun.repair import repair


class RecordingError(RuntimeError):
    """The recording could not be written; the message is one line."""


FLUSH_SECONDS = 5.0
_PIECE = 1 << 20  # bytes, at most as many as a pipe may hold


class PartFile:
    """A file that grows in `<path>.part` and becomes `<path>` when it is finished.

    What a stream writes behind an error of the disk is read and dropped.

    Attributes:
        path: the complete recording's.
        part: the file while it grows.
    """

    def __init__(self, path: Path, rec: rr.RecordingStream) -> None:
        """Make and lock a stream's file, in its folder; recover a killed run's of that name.

        Raises:
            RecordingError: the file cannot be written, or another recorder writes it.
        """
        self.path, self.part = path, unfinished_name(path)
        self._rec, self._file = rec, _claim(self.part)
        self._error: OSError | None = None
        self._mutex = threading.Lock()  # between reading from the pipe and writing

    def connect(
        self, views: rrb.Blueprint, *others: rr.GrpcSink, write_footer: bool = True
    ) -> None:
        """Let the stream write into the file, and into other sinks.

        Args:
            views: what viewers show by default.
            others: further sinks.
            write_footer: end the file with an index.
        """
        output, inlet = os.pipe()
        os.set_blocking(output, False)
        self._pipe = os.fdopen(output, "rb", buffering=0)
        self._copier = threading.Thread(target=self._copy_to_end, daemon=True)
        self._copier.start()
        try:
            file = rr.FileSink(f"/proc/self/fd/{inlet}", write_footer=write_footer)
            self._rec.set_sinks(file, *others, default_blueprint=views)
        finally:
            os.close(inlet)  # Rerun has opened its own

    def check(self) -> None:
        """Have all that the stream was given on the disk.

        Raises:
            RecordingError: the disk is full or gone.
        """
        with self.on_disk():
            self._rec.flush(timeout_sec=FLUSH_SECONDS)
            self._copy()
            self._raise_error()

    def finish(self) -> Path:
        """End the stream and give the file its final name, which is returned.

        Raises:
            RecordingError: the end did not reach the disk; what was written before stays in the
                `.part` file.
        """
        self.check()
        with self.on_disk():
            self._rec.disconnect()
            self._copier.join(FLUSH_SECONDS)
            if self._copier.is_alive():
                raise TimeoutError("its end is not written")
            self._raise_error()
            self.part.replace(self.path)
        self._file.close()
        return self.path

    def discard(self) -> None:
        """End the stream and remove the file."""
        self._rec.disconnect()
        self.part.unlink(missing_ok=True)
        self._file.close()

    @contextmanager
    def on_disk(self) -> Iterator[None]:
        """Raise RecordingError, naming the file, where the block's data do not reach the disk."""
        try:
            yield
        except RecordingError:
            raise
        except (RuntimeError, ValueError, OSError) as error:
            why = getattr(error, "strerror", None) or error
            raise RecordingError(
                f"recording {self.part}: {why} ({_describe_disk(self.part.parent)})"
            ) from error

    def _copy_to_end(self) -> None:
        arrivals = select.poll()
        arrivals.register(self._pipe, select.POLLIN)
        with self._pipe:
            while self._copy():
                arrivals.poll()

    def _copy(self) -> bool:
        """Copy what is in the pipe; return whether more may follow."""
        with self._mutex:
            while data := self._pipe.read(_PIECE):
                self._write(data)
            return data is None  # the pipe is empty, and still open

    def _write(self, data: bytes) -> None:
        try:
            while data and not self._error:
                data = data[self._file.write(data) :]
        except OSError as error:
            self._error = error

    def _raise_error(self) -> None:
        if self._error:
            raise self._error


def _claim(part: Path) -> FileIO:
    """Make the file and lock it, after recovering a killed run's."""
    try:
        if part.exists():
            repair(part)
        return claim(part)
    except OSError as error:
        raise RecordingError(f"recording {part}: {error.strerror}") from error


def _describe_disk(folder: Path) -> str:
    try:
        return f"{shutil.disk_usage(folder).free // 1_000_000} MB free on its disk"
    except OSError as error:
        return f"its folder: {error.strerror}"
