"""Copies of a finished study on a disk or in an object store, by fsspec."""

from pathlib import Path
from typing import Any

from crane_sim.files.errors import SceneError, join_lines
from crane_sim.files.installation import import_optional


def check_store(url: str) -> None:
    """Raise SceneError where there is no such kind of store, or its package is not installed."""
    _file_system(url)


def copy_study(folder: Path, url: str) -> None:
    """Copy table, study and recordings of a folder to a URL.

    Examples are s3://bucket/masses and file:///data/masses.

    Raises:
        SceneError: the store does not take them.
    """
    store, place = _file_system(url)
    try:
        store.makedirs(place, exist_ok=True)
        store.put(f"{folder}/", f"{place}/", recursive=True)
    except Exception as error:  # stores raise what their packages raise
        raise SceneError(f"--copy-to {url}: {join_lines(error) or type(error).__name__}") from None


def _file_system(url: str) -> tuple[Any, str]:
    """Return the file system of a URL, and the path in it."""
    fsspec = import_optional("fsspec", "--copy-to")
    try:
        store, place = fsspec.core.url_to_fs(url)
    except (ImportError, ValueError) as error:
        raise SceneError(f"--copy-to {url}: {join_lines(error)}") from None
    return store, place.rstrip("/")
