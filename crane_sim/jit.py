"""Compiled kernels: the only file that imports numba, beside the algebra of states, arrays and lanes below it.

A scene's physics is a tree of NamedTuples, and a `generic` function picks the body that fits the type of its first
argument, at compile time. Numba therefore compiles exactly what a scene is made of, an absent part (None) costs
nothing, and no function is ever passed to another one, so compiled code can be kept on disk.

Compiled code is kept in a folder named after a digest of every source file of the two packages (and of the versions
that produced it). It is read and written only while the files still have the digest they had before the first kernel
was imported, so stale machine code cannot be met.
"""

import functools
import hashlib
import os
import shutil
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

import numba
import numpy as np
from numba.core import config as numba_config
from numba.core import types
from numba.core.caching import FunctionCache
from numba.extending import intrinsic as _intrinsic
from numba.extending import overload

Function = Callable[..., Any]
intrinsic: Any = _intrinsic
"""Marks a function that returns (signature, generator of LLVM instructions)."""
OPTIONS: Any = {
    "error_model": "numpy",
    "forceinline": True,
    "no_cfunc_wrapper": True,
    "no_cpython_wrapper": True,
    "_nrt": True,  # said, since pieces would inherit it from the one that first calls them
}
"""Compile options of every kernel: IEEE division, no reassociation; small pieces melt into the loop that calls them."""
LEAN: Any = OPTIONS | {"_nrt": False}
"""Of pieces that allocate nothing and return numbers only, never an array: arrays pass through them uncounted, which
saves some six nanoseconds for each of them. An array that is returned, or received
from a counted piece, would be freed twice, or never."""

_PACKAGES = tuple(Path(__file__).resolve().parents[1] / name for name in ("crane_sim", "crane_control"))


def digest(folders: tuple[Path, ...] = _PACKAGES) -> str:
    """Return a digest of all Python sources below `folders` and of the versions that compile them."""
    sha = hashlib.sha256(f"{sys.version} {numba.__version__}".encode())
    for folder in folders:
        for file in sorted(folder.rglob("*.py")):
            sha.update(str(file.relative_to(folder)).encode() + b"\0" + file.read_bytes())
    return sha.hexdigest()[:16]


_AT_IMPORT = digest()
_KEPT = 8  # folders of compiled code, one for each state of the sources


def cache_folder() -> Path:
    """Return the folder for compiled code of these sources: $CRANE_SIM_CACHE, else the user's cache folder."""
    root = os.environ.get("CRANE_SIM_CACHE") or os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
    folder = Path(root) / "crane_sim" / _AT_IMPORT
    try:
        if not folder.is_dir():
            folder.mkdir(parents=True, exist_ok=True)
            _prune(folder.parent)
        if os.access(folder, os.W_OK):
            return folder
    except OSError:
        pass  # a read-only home: compile anew in every process rather than not at all
    return Path(tempfile.gettempdir()) / f"crane_sim_{os.getuid()}" / _AT_IMPORT


def _prune(root: Path) -> None:
    """Remove all but the newest folders of compiled code."""
    folders = sorted(root.iterdir(), key=lambda folder: folder.stat().st_mtime, reverse=True)
    for old in folders[_KEPT:]:
        shutil.rmtree(old, ignore_errors=True)


class _CheckedCache(FunctionCache):
    """Numba's on-disk cache, closed as soon as sources on disk differ from the ones in memory."""

    def load_overload(self, sig, target_context):
        return super().load_overload(sig, target_context) if _trusted() else None

    def save_overload(self, sig, data):
        if _trusted():
            super().save_overload(sig, data)


_outside: list[str] = []  # kernels of other packages, whose files the digest does not cover


def _trusted() -> bool:
    return not _outside and digest() == _AT_IMPORT


def _note_origin(f: Function) -> None:
    file = Path(f.__code__.co_filename).resolve()
    if not any(file.is_relative_to(package) for package in _PACKAGES):
        _outside.append(str(file))


def kernel(f: Function) -> Function:
    """Compile `f` into the kernels that call it."""
    _note_origin(f)
    return numba.njit(f, **OPTIONS)


def routine(f: Function) -> Function:
    """Compile `f` as one piece that kernels call: for long bodies, whose copies would cost minutes to compile."""
    _note_origin(f)
    return numba.njit(f, **(OPTIONS | {"forceinline": False}))


def lean_kernel(f: Function) -> Function:
    """Compile `f` as `kernel` does, by the rules of LEAN."""
    _note_origin(f)
    return numba.njit(f, **LEAN)


def lean_routine(f: Function) -> Function:
    """Compile `f` as `routine` does, by the rules of LEAN."""
    _note_origin(f)
    return numba.njit(f, **(LEAN | {"forceinline": False}))


def entry(f: Function) -> Function:
    """Compile `f` for calls from Python, and keep the result on disk."""
    dispatcher: Any = numba.njit(f, error_model="numpy", nogil=True)
    settings: Any = numba_config
    if not settings.DISABLE_JIT:
        settings.CACHE_DIR, previous = str(cache_folder()), settings.CACHE_DIR
        dispatcher._cache = _CheckedCache(f)
        settings.CACHE_DIR = previous
    return dispatcher


class Generic(Protocol):
    """A function whose body is chosen by the type of its first argument."""

    def __call__(self, *args: Any) -> Any:
        """Call the body for these arguments."""
        ...

    def register(self, cls: type) -> Callable[[Function], Function]:
        """Return a decorator that adds the body for first arguments of class `cls`."""
        ...

    def knows(self, cls: type) -> bool:
        """Return whether there is a body for `cls` other than the default."""
        ...


def lean_generic(f: Function) -> Generic:
    """Make `f` what `generic` makes of it, all bodies by the rules of LEAN."""
    return generic(f, LEAN)


def generic(f: Function, options: Any = OPTIONS) -> Generic:
    """Make `f` a function whose body is chosen by the type of its first argument, in Python and in kernels alike.

    `f.register(Type)` adds the body for a NamedTuple class, for `tuple` (any other tuple), for `float`, `np.ndarray` or
    `type(None)` (the part is absent), exactly as functools.singledispatch does. The body given here is the default.
    """
    table = functools.singledispatch(f)

    @functools.wraps(f)
    def call(*args: Any) -> Any:
        return table.dispatch(type(args[0]))(*args)

    def register(cls: type) -> Callable[[Function], Function]:
        def add(body: Function) -> Function:
            _note_origin(body)
            return table.register(cls)(body)

        return add

    def choose(*args: Any) -> Function:
        return table.dispatch(_python_type(args[0]))

    overload(call, strict=False, jit_options=options)(choose)
    generic_call: Any = call
    generic_call.register = register
    generic_call.knows = lambda cls: table.dispatch(cls) is not f
    return generic_call


def _python_type(t: types.Type) -> type:
    """Return the Python class that the numba type `t` stands for."""
    if isinstance(t, types.NamedTuple | types.NamedUniTuple):
        return t.instance_class
    kinds = {types.BaseTuple: tuple, types.NoneType: type(None), types.Float: float, types.Integer: int}
    kinds |= {types.Array: np.ndarray}
    return next((python for kind, python in kinds.items() if isinstance(t, kind)), object)
