"""A product and a sum, rounded once: what processors call a fused multiply-add.

Asked for by name, and not left to the compiler, it gives the same bits wherever a kernel is inlined and on every
processor; one without the instruction only takes longer.
"""

import ctypes
from typing import Any

from numba.core import types
from numba.extending import overload

from crane_sim.jit import LEAN, intrinsic

_LIBRARY: Any = ctypes.CDLL("libm.so.6")
_LIBRARY.fma.restype, _LIBRARY.fma.argtypes = ctypes.c_double, [ctypes.c_double] * 3


def fused(a: float, b: float, c: float) -> float:
    """Return a b + c, rounded once."""
    return _LIBRARY.fma(a, b, c)


@intrinsic
def _fused(typing_context, a, b, c):
    def generate(context, builder, signature, args):
        return builder.fma(*args)

    return types.float64(types.float64, types.float64, types.float64), generate


@overload(fused, jit_options=LEAN)
def _compiled_fused(a, b, c):
    return lambda a, b, c: _fused(a, b, c)
