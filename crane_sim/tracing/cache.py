"""Folder of the compiled code, and digest of its sources."""

import hashlib
import os
import shutil
import stat
import sys
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.metadata import version
from pathlib import Path

_LLVMLITE = version("llvmlite")
_PACKAGES = tuple(
    Path(__file__).resolve().parents[2] / name for name in ("crane_sim", "crane_control")
)
UNDIGESTED = (
    "gym",
    "operator",
    "ros",
    "orchestration",
    "recording",
    "identification",
    "report",
    "cli",
    "nodes",
)
"""Folders of a package with no compiled code and not imported by any: a change there does not
invalidate the cache."""


def digest(folders: tuple[Path, ...] = _PACKAGES) -> str:
    """Return a digest of the sources below `folders`, but UNDIGESTED ones, and of the compiler."""
    sha = hashlib.sha256(f"{sys.version} {_LLVMLITE}".encode())
    for folder in map(str, folders):
        for file in sorted(_sources(folder)):
            with suppress(FileNotFoundError), open(file, "rb") as source:
                sha.update(file[len(folder) :].encode() + b"\0" + source.read())
    return sha.hexdigest()[:16]


class SourceState:
    """Snapshot of the sources, checked before code is read or written.

    Attributes:
        digest: of the sources.
    """

    def __init__(self, folders: tuple[Path, ...] = _PACKAGES) -> None:
        """Take a snapshot of the sources below `folders`, those of `digest`."""
        self._folders = folders
        # stamps first, so that a change during hashing is noticed later
        self._stamps = self._read_stamps()
        self.digest = digest(folders)

    def is_current(self) -> bool:
        """Return whether the sources are unchanged; contents are read where stamps differ."""
        stamps = self._read_stamps()
        if stamps != self._stamps and digest(self._folders) == self.digest:
            self._stamps = stamps
        return stamps == self._stamps

    def includes(self, file: str) -> bool:
        """Return whether the digest includes a file; "" and names in brackets are no files."""
        return os.path.realpath(file) in self._stamps

    def is_unchanged(self, file: str) -> bool:
        """Return whether the digest includes a file that is as it was then."""
        with suppress(OSError):
            return self._stamps.get(os.path.realpath(file)) == _stamp_of(file)
        return False

    def _read_stamps(self) -> dict[str, tuple[int, ...]]:
        """Return the file attributes that change on a write, by path."""
        stamps: dict[str, tuple[int, ...]] = {}
        for file in (file for folder in map(str, self._folders) for file in _sources(folder)):
            with suppress(FileNotFoundError):  # a file that is removed meanwhile
                stamps[file] = _stamp_of(file)
        return stamps


def _stamp_of(file: str) -> tuple[int, ...]:
    """Return the attributes of a file that change on a write."""
    status = os.stat(file)
    return status.st_ino, status.st_size, status.st_mtime_ns, status.st_ctime_ns


def _sources(package: str) -> Iterator[str]:
    """Yield the Python sources below a package's folder, but UNDIGESTED ones, as strings (fast)."""
    return _sources_below(package, {os.path.join(package, undigested) for undigested in UNDIGESTED})


def _sources_below(folder: str, undigested: set[str]) -> Iterator[str]:
    for entry in os.scandir(folder):
        if entry.is_dir():
            if entry.path not in undigested:
                yield from _sources_below(entry.path, undigested)
        elif entry.name.endswith(".py") and entry.is_file():
            # not an editor's lock, a link to nowhere
            yield entry.path


SOURCES_AT_IMPORT = SourceState()
MAX_CACHES = 8  # folders of compiled code that are kept, one for each state of the sources


def cache_root() -> Path:
    """Return the folder for compiled code of all sources: $CRANE_SIM_CACHE, else the user's."""
    return Path(
        os.environ.get("CRANE_SIM_CACHE")
        or os.environ.get("XDG_CACHE_HOME")
        or os.path.expanduser("~/.cache")
    )


def cache_folder() -> Path:
    """Return the folder for compiled code of these sources.

    Where `cache_root` is read-only, it is one of temporary files.
    """
    folder = cache_root() / "crane_sim" / SOURCES_AT_IMPORT.digest
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)
            _prune(folder.parent)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass  # a read-only home: compile anew in every process rather than not at all
    return _temporary_folder() / SOURCES_AT_IMPORT.digest


@cache
def _temporary_folder() -> Path:
    """Return a folder of this user's among temporary files, where others could make one as well.

    What it contains is executed: where the folder is another user's, or a link, there is a new one
    for this process.
    """
    folder = Path(tempfile.gettempdir()) / f"crane_sim_{os.getuid()}"
    with suppress(FileExistsError):
        folder.mkdir(mode=0o700)
    status = folder.lstat()
    if stat.S_ISDIR(status.st_mode) and status.st_uid == os.getuid():
        folder.chmod(0o700)
        return folder
    return Path(tempfile.mkdtemp(prefix="crane_sim_"))


def _prune(root: Path) -> None:
    """Remove all but the newest folders of compiled code."""
    with suppress(FileNotFoundError):  # another process is removing them
        folders = sorted(root.iterdir(), key=lambda folder: folder.stat().st_mtime, reverse=True)
        for old in folders[MAX_CACHES:]:
            shutil.rmtree(old, ignore_errors=True)
