"""Numba's on-disk cache, and what of compiled code may be in it: only what the digest of the sources covers."""

import functools
import hashlib
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

from numba.core import sigutils, types
from numba.core.caching import FunctionCache

from crane_sim.numerics import import_array_functions
from crane_sim.numerics.cache import SOURCES_AT_IMPORT, FileLock
from crane_sim.numerics.compile_time import COMPILE_TIMER
from crane_sim.numerics.linked_library import linked_sources

_LOCK_TIMEOUT = 120.0  # s; the largest function compiles in a third of that on a busy machine


class CheckedCache(FunctionCache):
    """Numba's on-disk cache of what the digest covers, disabled once sources on disk differ from the ones in memory.

    While a process compiles a function, others that need the same function wait for it, and load it from the disk.
    """

    def __init__(self, f: Callable[..., Any]) -> None:
        super().__init__(f)
        self._locks: dict[Any, FileLock] = {}  # of functions that this process is compiling, by signature

    def load_overload(self, sig, target_context):
        """Return the machine code for a signature, None where there is none; the caller compiles it then."""
        import_array_functions()
        if not _is_cacheable(sig):
            return None
        if loaded := super().load_overload(sig, target_context):
            return loaded
        self._release(sig)  # of a compilation that raised, after which nothing is saved
        with COMPILE_TIMER:
            self._locks[sig] = FileLock(self._lock_file(sig), _LOCK_TIMEOUT)
        if loaded := super().load_overload(sig, target_context):
            self._release(sig)
        return loaded

    def save_overload(self, sig, data):
        """Save the machine code for a signature, and let processes that wait for it go on."""
        try:
            if _is_cacheable(sig) and all(map(_is_digested_file, linked_sources(data.library))):
                self._save(sig, data)
        finally:
            self._release(sig)

    def _save(self, sig: Any, data: Any) -> None:
        # numba reads and writes the index of a function's signatures without a lock
        index = FileLock(self._lock_file("index"), _LOCK_TIMEOUT)
        try:
            super().save_overload(sig, data)
        finally:
            index.release()

    def _release(self, sig: Any) -> None:
        """Let processes that wait for the function of a signature go on, where this one has its lock."""
        if lock := self._locks.pop(sig, None):
            lock.release()

    def _lock_file(self, sig: Any) -> Path:
        key = hashlib.sha256(f"{self._impl.filename_base} {sig}".encode()).hexdigest()[:32]
        return Path(self.cache_path, f"{key}.lock")


_implemented_elsewhere: list[str] = []
"""Functions of the packages that other files implement for types that are not their own; then nothing is cached."""


def _is_cacheable(signature: Any) -> bool:
    """Return whether the digest covers all that a function of the packages compiles for a signature."""
    arguments, _ = sigutils.normalize_signature(signature)
    return not _implemented_elsewhere and all(map(_is_covered, arguments)) and SOURCES_AT_IMPORT.is_current()


def _is_covered(kind: Any) -> bool:
    """Return whether a numba type is of numbers and arrays, and of tuples whose classes the digest covers.

    Implementations for any other type may be code that it does not cover.
    """
    if isinstance(kind, types.NamedTuple | types.NamedUniTuple) and _is_own_class(kind.instance_class):
        return False
    if isinstance(kind, types.BaseTuple):
        parts: Any = kind
        return all(map(_is_covered, parts))
    return isinstance(kind, _COVERED_TYPES)


_COVERED_TYPES = types.Number | types.Boolean | types.NoneType | types.Array | types.UnicodeType | types.Omitted


def _is_own_class(cls: Any) -> bool:
    """Return whether `cls` is a NamedTuple class of a file that the digest does not cover: no other type matches it."""
    if type(cls) is not type or not issubclass(cls, tuple) or not hasattr(cls, "_fields"):
        return False
    return not _is_digested_file(getattr(sys.modules.get(cls.__module__), "__file__", None) or "")


@functools.cache
def _is_digested_file(name: str) -> bool:
    return SOURCES_AT_IMPORT.includes(name)


def is_digested(f: Callable[..., Any]) -> bool:
    """Return whether the digest of the sources covers the file of a Python function."""
    return _is_digested_file(f.__code__.co_filename)


def note_implementation(f: Callable[..., Any], cls: Any, implementation: Callable[..., Any]) -> None:
    """Stop caching if `implementation` is of another file, and of a function of the packages for a type not its own."""
    if is_digested(f) and not is_digested(implementation) and not _is_own_class(cls):
        _implemented_elsewhere.append(f.__name__)
