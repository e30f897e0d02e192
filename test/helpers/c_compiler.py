"""Functions compiled from C source by the system's compiler, where there is one."""

import ctypes
import shutil
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest

needs_compiler = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")


def c_function(source: str, name: str, folder: Path) -> Any:
    """Return a function of C source, called with floats and arrays."""
    (folder / "source.c").write_text(source)
    options = [
        "-O1",
        "-std=c99",
        "-Wall",
        "-Wno-unused",
        "-Werror",
        "-ffp-contract=off",
        "-fno-builtin-pow",
    ]
    command = ["cc", *options, "-shared", "-fPIC", "source.c", "-o", "source.so", "-lm"]
    subprocess.run(command, cwd=folder, check=True, timeout=300)
    function = getattr(ctypes.CDLL(str(folder / "source.so")), name)
    function.restype = None
    return lambda *arguments: function(*map(_as_c, arguments))


def _as_c(x: float | np.ndarray) -> Any:
    return ctypes.c_double(x) if isinstance(x, float) else ctypes.c_void_p(x.ctypes.data)
