"""Machine code of entry points on disk, in a folder for each state of the sources.

What is read fits by construction: the folder is named after a digest of the packages' sources, the
file after the function, the structure of its arguments, the processor and the compiler. Of
functions of other files, such as a law of the user's, the file has what they depend on: digests of
their files, and the outer values that they use. A file that is damaged, or cannot be written, costs
a compilation, and so does code that depends on anything else.
"""

import hashlib
import os
import pickle
import sys
import types
from collections.abc import Iterable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from crane_sim.tracing.arguments import text_of
from crane_sim.tracing.cache import SOURCES_AT_IMPORT, cache_folder
from crane_sim.tracing.machine_code import compiler_name
from crane_sim.tracing.scopes import source_of

_DIGEST = hashlib.sha256().digest_size
_OTHER_IMPLEMENTATIONS: set[str] = set()


class _Unknown(ValueError):
    """Code depends on something whose state cannot be told."""


class _OuterValue(NamedTuple):
    """What a global name of a module stood for when a function that uses it was traced."""

    module: str
    name: str
    state: str


def read_entry(function: Any, key: Any) -> Any:
    """Return a function's code for a structure of arguments, None where none is whole and fits."""
    try:
        if not SOURCES_AT_IMPORT.is_current():
            return None
        content = _file(function, key).read_bytes()
        digest, data = content[:_DIGEST], content[_DIGEST:]
        if hashlib.sha256(data).digest() != digest:
            return None
        files, values, code = pickle.loads(data)
        fits = all(_digest_of(file) == known for file, known in files) and all(
            map(_is_current, values)
        )
        return code if fits else None
    except Exception:  # a file of code may hold anything: whatever it is, there is none
        return None


def write_entry(
    function: Any, key: Any, code: Any, functions: Iterable[types.FunctionType]
) -> None:
    """Keep code, where the folder can be written and the code can be read again.

    Args:
        function: the entry point's.
        key: structure of its arguments.
        code: for these.
        functions: all that are in it.
    """
    with suppress(OSError, pickle.PicklingError, AttributeError, TypeError, _Unknown):
        if not SOURCES_AT_IMPORT.is_current():
            return
        data = pickle.dumps((*_dependencies(functions), code))
        file = _file(function, key)
        part = file.with_suffix(f".{os.getpid()}")
        try:
            part.write_bytes(hashlib.sha256(data).digest() + data)
            part.replace(file)
        finally:
            part.unlink(missing_ok=True)


def note_implementation(function: Any, cls: Any, implementation: Any) -> None:
    """Note an implementation outside the packages and its type's file: its code is kept apart."""
    file = implementation.__code__.co_filename
    of_cls = (
        getattr(sys.modules.get(cls.__module__), "__file__", None)
        if isinstance(cls, type)
        else None
    )
    if file != of_cls and not SOURCES_AT_IMPORT.includes(file):
        _OTHER_IMPLEMENTATIONS.add(f"{function.__module__}.{function.__qualname__} {cls} {file}")


def _file(function: Any, key: Any) -> Path:
    text = f"{text_of(key)} {sorted(_states_of_types(key))}"
    if function.__closure__ or " at 0x" in text:
        raise _Unknown  # two functions of one name, and objects that have no text of their own
    name = (
        function.__module__,
        function.__qualname__,
        function.__code__.co_filename,
        text,
        *compiler_name(),
    )
    digest = hashlib.sha256(repr((name, sorted(_OTHER_IMPLEMENTATIONS))).encode()).hexdigest()
    return cache_folder() / f"{function.__name__}-{digest[:24]}.code"


def _states_of_types(key: Any) -> Iterator[str]:
    """Yield the states of the types of a structure that other files than the packages' define."""
    if isinstance(key, tuple):
        for part in key:
            yield from _states_of_types(part)
    elif (
        isinstance(key, type)
        and hasattr(key, "_fields")
        and not SOURCES_AT_IMPORT.includes(_file_of(key) or "")
    ):
        yield _state_of(key)


def _file_of(x: Any) -> str | None:
    return getattr(sys.modules.get(getattr(x, "__module__", None) or ""), "__file__", None)


def _dependencies(
    functions: Iterable[types.FunctionType],
) -> tuple[list[tuple[str, str]], list[_OuterValue]]:
    """Return (other files with their digests, outer values) that code of functions depends on."""
    others = [f for f in functions if not SOURCES_AT_IMPORT.includes(f.__code__.co_filename)]
    if any(
        f.__closure__ or os.stat(f.__code__.co_filename).st_mtime_ns != source_of(f).time_stamp
        for f in others
    ):
        raise _Unknown  # a file that has changed since has other code
    files = sorted({f.__code__.co_filename for f in others})
    values = {
        _OuterValue(f.__module__, name, _state_of(f.__globals__[name]))
        for f in others
        for name in _names_of(f.__code__)
        if name in f.__globals__
    }
    return [(file, _digest_of(file)) for file in files], sorted(values)


def _names_of(code: types.CodeType) -> Iterator[str]:
    """Yield the outer names, also of attributes, of a function and of those inside it."""
    yield from code.co_names
    for inner in code.co_consts:
        if isinstance(inner, types.CodeType):
            yield from _names_of(inner)


def _is_current(value: _OuterValue) -> bool:
    return _state_of(vars(sys.modules[value.module])[value.name]) == value.state


def _state_of(x: Any) -> str:
    """Return a text that tells an outer value from others; of functions: file and defaults.

    Of modules and classes it is the same.
    """
    if x is None or isinstance(x, bool | int | float | str):
        return repr(x)
    if isinstance(x, tuple | list):
        return f"{type(x).__qualname__}({', '.join(map(_state_of, x))})"
    if isinstance(x, np.ndarray) and not x.dtype.hasobject:
        return f"{x.dtype} {x.shape} {hashlib.sha256(x.tobytes()).hexdigest()}"
    module = (
        x
        if isinstance(x, types.ModuleType)
        else sys.modules.get(getattr(x, "__module__", None) or "")
    )
    name = getattr(x, "__qualname__", None) or getattr(x, "__name__", None)
    if module is None or name is None:
        raise _Unknown
    file = getattr(module, "__file__", None)
    if not file or SOURCES_AT_IMPORT.includes(file):
        return f"{module.__name__} {name}"
    defaults = tuple(getattr(x, "_field_defaults", {}).values()) or getattr(x, "__defaults__", None)
    # a condition may decide which of two it is
    line = getattr(getattr(x, "__code__", None), "co_firstlineno", 0)
    return f"{module.__name__} {name}:{line} {_digest_of(file)} {_state_of(defaults)}"


def _digest_of(file: str) -> str:
    return hashlib.sha256(Path(file).read_bytes()).hexdigest()
