"""Sine, cosine and fused sums with the same bits compiled, in Python, and on any processor.

Sine and cosine are straight-line arithmetic, in vectors too. What processors call a fused
multiply-add is asked for by name, and not left to the compiler; a processor without the instruction
only takes longer.

Reduction by π/2 in two parts and the polynomials of fdlibm (Sun Microsystems, 1993; k_sin.c,
k_cos.c, e_rem_pio2.c), summed in pairs, so that fewer operations wait for each other.
"""

from typing import Any

from crane_sim.tracing.operations import fma as fma
from crane_sim.tracing.operations import select, to_integer

_TWO_OVER_PI = 0.6366197723675814
# the first has 33 bits
_HALF_PI, _HALF_PI_REST = 1.57079632673412561417, 6.07710050650619224932e-11
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and taking it away rounds to an integer


def _reduce(angle: Any) -> Any:
    """Return (whole quarters of a turn in an angle [rad], what is left of it, that one's rest)."""
    k = (angle * _TWO_OVER_PI + _ROUND) - _ROUND
    first = fma(k, -_HALF_PI, angle)
    rest = k * _HALF_PI_REST
    x = first - rest
    return k, x, (first - x) - rest


def _sine(x: Any, y: Any) -> Any:
    """Return sin(x + y) for |x| ≤ π/4 and |y| below the last digit of x."""
    z = x * x
    z2, v = z * z, z * x
    low = fma(z, -1.98412698298579493134e-04, 8.33333333332248946124e-03)
    high = fma(
        z2,
        1.58969099521155010221e-10,
        fma(z, -2.50507602534068634195e-08, 2.75573137070700676789e-06),
    )
    correction = fma(z, -fma(z2, high, low), 1.66666666666666324348e-01)
    return x - fma(v, correction, fma(z, 0.5 * y, -y))


def _cosine(x: Any, y: Any) -> Any:
    """Return cos(x + y) for |x| ≤ π/4 and |y| below the last digit of x."""
    z = x * x
    z2 = z * z
    low = fma(z, -1.38888888888741095749e-03, 4.16666666666666019037e-02)
    middle = fma(z, -2.75573143513906633035e-07, 2.48015872894767294178e-05)
    high = fma(z2, fma(z, -1.13596475577881948265e-11, 2.08757232129817482790e-09), middle)
    w = fma(z, -0.5, 1.0)
    return w + fma(z2, fma(z2, high, low), fma(-x, y, fma(z, -0.5, 1.0 - w)))


def _turn(s: Any, c: Any, quarter: Any) -> Any:
    """Return (sine, cosine) of an angle that is quarters of a turn more than that of s and c."""
    odd = (quarter & 1) == 1
    s, c = select(odd, c, s), select(odd, s, c)
    s = select((quarter & 2) == 2, -s, s)
    return s, select(((quarter + 1) & 2) == 2, -c, c)


def sincos(angle: Any) -> Any:
    """Return (sine, cosine) of an angle [rad], within 1.2e-16 up to 1e5 rad.

    Above, the error is within the angle's own last digit.

    Beyond 1e15 rad, where neighbouring doubles are a radian apart, what is returned means nothing.
    """
    k, x, y = _reduce(angle)
    return _turn(_sine(x, y), _cosine(x, y), to_integer(k))


def _sincos_often_small(angle: Any) -> Any:
    """Return the bits of `sincos`, with branches, which lanes lack, for quick small angles."""
    x, y, quarter = angle, 0.0, 0
    if abs(angle) >= _SMALL:
        k, x, y = _reduce(angle)
        quarter = to_integer(k)
    s, c = _sine(x, y), _cosine(x, y)
    if quarter == 0:
        return s, c
    return _turn(s, c, quarter)


_SMALL = 0.78  # rad, less than an eighth of a turn: nothing is taken away
sincos.without_lanes = _sincos_often_small  # type: ignore[attr-defined]
sincos.slopes = lambda s, c: (c, -s)  # type: ignore[attr-defined]  # of its results
