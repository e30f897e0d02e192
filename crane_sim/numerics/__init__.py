"""Compiled arithmetic: kernels and their cache, states, arrays, lanes, linear systems; numba only here.

Numba imports two packages only to see whether they are there: all of scipy.linalg, a tenth of the start of a process,
and `coverage`, where it is installed, of which it has no use where nothing measures it.
"""

import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from typing import Any


@contextmanager
def _without_coverage() -> Iterator[None]:
    """Let imports of `coverage` fail within the block as if it were not installed, unless it was imported before."""
    modules: Any = sys.modules
    if "coverage" in modules or "numba" in modules:
        yield
        return
    modules["coverage"] = None  # Python's own mark of a module that must not be imported
    try:
        yield
    finally:
        modules.pop("coverage", None)


try:
    with _without_coverage(), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Environment variable .* value ''")  # an empty one counts as not set
        import numba as numba
except ValueError as error:  # a variable that it reads
    variables = ", ".join(f"{name} = {value}" for name, value in os.environ.items() if name.startswith("NUMBA_"))
    raise RuntimeError(f"numba rejects a variable of the environment: {variables}: {error}") from None


@cache
def import_array_functions() -> None:
    """Import numba's array functions without scipy.linalg, which is imported when a function needs it."""
    from numba.np import linalg

    ensure_blas, linalg.ensure_blas = linalg.ensure_blas, lambda: None
    try:
        import_module("numba.np.arraymath")
    finally:
        linalg.ensure_blas = ensure_blas
