"""Sine and cosine of an angle: straight-line arithmetic, which compilers turn into vector instructions.

Reduction by π/2 in two parts and the polynomials of fdlibm (Sun Microsystems, 1993; k_sin.c, k_cos.c, e_rem_pio2.c),
summed in pairs, so that fewer operations wait for each other. Library functions would be calls, which end
vectorisation.

A product and a sum, rounded once: what processors call a fused multiply-add.

Asked for by name, and not left to the compiler, it gives the same bits wherever a kernel is inlined and on every
processor; one without the instruction only takes longer.
"""

import ctypes
from typing import Any

from numba.core import types
from numba.extending import overload

from crane_sim.numerics.jit import LEAN, intrinsic, kernel

_LIBRARY: Any = ctypes.CDLL("libm.so.6")


_LIBRARY.fma.restype, _LIBRARY.fma.argtypes = ctypes.c_double, [ctypes.c_double] * 3


def fma(a: Any, b: Any, c: Any) -> Any:
    """Return a b + c, rounded once; a float, or what has its own `fma`, such as `rows.Lanes`."""
    return a.fma(b, c) if hasattr(a, "fma") else _LIBRARY.fma(a, b, c)


@intrinsic
def _fma(typing_context, a, b, c):
    def generate(context, builder, signature, args):
        return builder.fma(*args)

    return types.float64(types.float64, types.float64, types.float64), generate


@overload(fma, jit_options=LEAN)
def _compiled_fma(a, b, c):
    return lambda a, b, c: _fma(a, b, c)


_TWO_OVER_PI = 0.6366197723675814


_HALF_PI, _HALF_PI_REST = 1.57079632673412561417, 6.07710050650619224932e-11  # the first has 33 bits


_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and taking it away rounds to an integer


@kernel
def sincos_of_residue(angle):
    """Return (quarters of a turn in an angle [rad], a whole number, then sine and cosine of what is left of it)."""
    k = (angle * _TWO_OVER_PI + _ROUND) - _ROUND
    first = fma(k, -_HALF_PI, angle)
    rest = k * _HALF_PI_REST
    x = first - rest
    y = (first - x) - rest
    z = x * x
    z2, v = z * z, z * x
    low = fma(z, -1.98412698298579493134e-04, 8.33333333332248946124e-03)
    high = fma(z2, 1.58969099521155010221e-10, fma(z, -2.50507602534068634195e-08, 2.75573137070700676789e-06))
    s = x - fma(v, fma(z, -fma(z2, high, low), 1.66666666666666324348e-01), fma(z, 0.5 * y, -y))
    low = fma(z, -1.38888888888741095749e-03, 4.16666666666666019037e-02)
    middle = fma(z, -2.75573143513906633035e-07, 2.48015872894767294178e-05)
    high = fma(z2, fma(z, -1.13596475577881948265e-11, 2.08757232129817482790e-09), middle)
    w = fma(z, -0.5, 1.0)
    c = w + fma(z2, fma(z2, high, low), fma(-x, y, fma(z, -0.5, 1.0 - w)))
    return k, s, c


@kernel
def sincos(angle):
    """Return (sine, cosine) of an angle [rad], within 1.2e-16 up to 1e5 rad and within an angle's own last digit above.

    Beyond 1e15 rad, where neighbouring doubles are a radian apart, what is returned means nothing.
    """
    k, s, c = sincos_of_residue(angle)
    quarter = int(k)  # of a turn, with its sign
    s, c = (c, s) if quarter & 1 else (s, c)
    s = -s if quarter & 2 else s
    c = -c if (quarter + 1) & 2 else c
    return s, c
