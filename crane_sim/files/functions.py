"""Functions of one's own that files name: FILE.py:FUNCTION or MODULE:FUNCTION."""

import hashlib
import sys
import time
from collections.abc import Callable
from importlib import import_module, reload
from importlib.machinery import SourceFileLoader
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

from crane_sim.files.errors import PATH, SceneError, one_word, shorten

_DIGEST = "__crane_sim_source__"
"""Attribute of a module: the hash of its source when it was loaded here."""
_STARTED = time.time()  # s: a file that is older is what others have imported


def load_function(key: str, name: str) -> Callable[..., Any]:
    """Return the function FILE.py:FUNCTION or MODULE:FUNCTION at a key, from its present source.

    Raises:
        SceneError: there is no such file or function.
        Exception: whatever the module raises when it is executed.
    """
    place, _, function = name.rpartition(":")
    if not (place and function):
        raise SceneError(f"{key} = {shorten(name)}: must be FILE.py:FUNCTION or MODULE:FUNCTION")
    module = (
        _execute_file(key, Path(place)) if place.endswith(".py") else _import_module(name, place)
    )
    found = getattr(module, function, None)
    if not callable(found):
        raise SceneError(f"{key} = {shorten(name, PATH)}: has no function {shorten(function)}")
    return found


def source_of(name: str) -> Path | None:
    """Return the source file of FILE.py:FUNCTION or MODULE:FUNCTION, or None."""
    place = name.rpartition(":")[0]
    if not place.endswith(".py"):
        try:
            spec = find_spec(place)
        except Exception:
            # of a package that the module is in, which is executed: told where it is loaded
            return None
        place = "" if spec is None or spec.origin is None else spec.origin
    return Path(place) if Path(place).is_file() else None


def hash_source(name: str) -> str | None:
    """Return the SHA-256 of the source of FILE.py:FUNCTION or MODULE:FUNCTION, or None."""
    source = source_of(name)
    try:
        return None if source is None else hashlib.sha256(source.read_bytes()).hexdigest()
    except OSError:  # refused where it is loaded
        return None


def _reload(module: ModuleType) -> None:
    """Execute a module anew: from its source where it has one, whatever byte code there is."""
    spec = module.__spec__
    if spec is None or not isinstance(spec.loader, SourceFileLoader):
        reload(module)
    else:
        _SourceLoader(spec.loader.name, spec.loader.path).exec_module(module)


def _import_module(name: str, place: str) -> ModuleType:
    """Return a module, executed anew where its source has been edited since it was executed."""
    # asked first: the search for a source imports the package that it is in
    imported = place in sys.modules
    digest, source = hash_source(name), source_of(name)
    module = import_module(place)
    edited = imported and source is not None and source.stat().st_mtime > _STARTED
    if getattr(module, _DIGEST, None if edited else digest) != digest:
        _reload(module)
    setattr(module, _DIGEST, digest)
    return module


class _SourceLoader(SourceFileLoader):
    """Loads a file from its source.

    Python's byte code would be taken for that of any file of the same second and size.
    """

    def get_code(self, fullname: str) -> CodeType:
        """Return the code of the file as it is now."""
        path = self.get_filename(fullname)
        return self.source_to_code(self.get_data(path), path)


def _execute_file(key: str, path: Path) -> ModuleType:
    """Return the module of a file, executed anew."""
    # no other module's
    name = f"_{path.stem}_{hashlib.sha256(bytes(path.absolute())).hexdigest()[:16]}"
    spec = spec_from_file_location(name, path, loader=_SourceLoader(name, str(path)))
    if spec is None or spec.loader is None or not path.is_file():
        raise SceneError(f"{key}: there is no file {one_word(str(path), PATH)}")
    before, module = sys.modules.get(name), module_from_spec(spec)
    sys.modules[name] = module  # dataclasses and annotations look it up by its name
    try:
        spec.loader.exec_module(module)
    except BaseException:
        sys.modules.pop(name, None)
        if before is not None:
            sys.modules[name] = before
        raise
    return module
