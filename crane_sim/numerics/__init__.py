"""Compiled arithmetic: kernels and their cache, states, arrays, lanes, linear systems; numba only here.

Numba imports two packages only to see whether they are there, which takes a tenth of a process's start: `coverage`,
which it has no use for where nothing measures it, and all of scipy.linalg, for numpy.cov and the like.
"""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Any


@contextmanager
def _withheld(name: str) -> Iterator[None]:
    """Let imports of a module fail within the block as if it were not installed, unless it was imported before."""
    modules: Any = sys.modules
    if name in modules:
        yield
        return
    modules[name] = None  # Python's own mark of a module that must not be imported
    try:
        yield
    finally:
        del modules[name]


with _withheld("coverage"):
    import numba as numba


@cache
def import_array_functions() -> None:
    """Import what numba would import when it first compiles or loads a function."""
    with _withheld("scipy.linalg.cython_blas"):
        from numba.np import arraymath
    arraymath._HAVE_BLAS = True  # it is there
