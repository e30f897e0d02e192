"""Linear algebra of small matrices in one thread: OpenBLAS starts more even for 5 x 5, and waits 100 times longer."""

import ctypes
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import Any

import scipy


@cache
def _library() -> Any:
    """Return the OpenBLAS that SciPy's wheel brings; None where it is linked with another library."""
    for file in (Path(scipy.__file__).parents[1] / "scipy.libs").glob("*openblas*"):
        library = ctypes.CDLL(str(file))
        if hasattr(library, "scipy_openblas_set_num_threads"):
            return library
    return None


@contextmanager
def in_one_thread() -> Iterator[None]:
    """Let SciPy compute in one thread within the block; results for small matrices are bitwise identical."""
    library = _library()
    if library is None:
        yield
        return
    threads = library.scipy_openblas_get_num_threads()
    library.scipy_openblas_set_num_threads(1)
    try:
        yield
    finally:
        library.scipy_openblas_set_num_threads(threads)
