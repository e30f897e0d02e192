"""Functions of one's own that files name: FILE.py:FUNCTION or MODULE:FUNCTION."""

from collections.abc import Callable
from importlib import import_module
from importlib.util import find_spec, module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType
from typing import Any

from crane_sim.files.errors import SceneError


def load_function(key: str, name: str) -> Callable[..., Any]:
    """Return the function FILE.py:FUNCTION or MODULE:FUNCTION that a file names at a key.

    Raises:
        SceneError: there is no such file or function.
        Exception: whatever the module raises when it is executed.
    """
    place, _, function = name.rpartition(":")
    if not (place and function):
        raise SceneError(f"{key} = {name!r}: must be FILE.py:FUNCTION or MODULE:FUNCTION")
    module = _execute_file(key, Path(place)) if place.endswith(".py") else import_module(place)
    found = getattr(module, function, None)
    if not callable(found):
        raise SceneError(f"{key} = {name!r}: {place} has no function {function!r}")
    return found


def source_of(name: str) -> Path | None:
    """Return the source file of a function FILE.py:FUNCTION or MODULE:FUNCTION, None where there is none."""
    place = name.rpartition(":")[0]
    if not place.endswith(".py"):
        try:
            spec = find_spec(place)
        except Exception:  # of a package that the module is in, which is executed: told where it is loaded
            return None
        place = "" if spec is None or spec.origin is None else spec.origin
    return Path(place) if Path(place).is_file() else None


def _execute_file(key: str, path: Path) -> ModuleType:
    """Return the module of a file, executed anew."""
    spec = spec_from_file_location(path.stem, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise SceneError(f"{key}: there is no file {path}")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
