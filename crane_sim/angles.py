"""Sines and cosines of many angles at once: straight-line arithmetic that the compiler turns into vector instructions.

Reduction by π/2 in two parts and the polynomials of fdlibm (Sun Microsystems, 1993; k_sin.c, k_cos.c, e_rem_pio2.c).
"""

from math import cos, sin

from crane_sim.jit import kernel, routine

_TWO_OVER_PI = 0.6366197723675814
_HALF_PI, _HALF_PI_REST = 1.57079632673412561417, 6.07710050650619224932e-11  # the first has 33 bits
_ROUND = 6755399441055744.0  # 1.5 * 2^52: adding and taking it away rounds to an integer
MOST = 1e5  # rad, up to which the reduction keeps its accuracy


@kernel
def one_angle(angle):
    """Return (sine, cosine) of an angle [rad] of at most MOST, within 1.2e-16."""
    k = (angle * _TWO_OVER_PI + _ROUND) - _ROUND
    first = angle - k * _HALF_PI
    rest = k * _HALF_PI_REST
    x = first - rest
    y = (first - x) - rest
    z = x * x
    r = 8.33333333332248946124e-03 + z * (
        -1.98412698298579493134e-04
        + z * (2.75573137070700676789e-06 + z * (-2.50507602534068634195e-08 + z * 1.58969099521155010221e-10))
    )
    s = x - ((z * (0.5 * y - z * x * r) - y) + z * x * 1.66666666666666324348e-01)
    r = 4.16666666666666019037e-02 + z * (
        -1.38888888888741095749e-03
        + z
        * (
            2.48015872894767294178e-05
            + z * (-2.75573143513906633035e-07 + z * (2.08757232129817482790e-09 + z * -1.13596475577881948265e-11))
        )
    )
    w = 1.0 - 0.5 * z
    c = w + (((1.0 - w) - 0.5 * z) + (z * z * r - x * y))
    half = 0.5 * k
    odd = half - ((half + _ROUND) - _ROUND) != 0.0
    quarter = 0.25 * k - ((0.25 * k + _ROUND) - _ROUND)  # 0, ±1/4, ±1/2
    s, c = (c, s) if odd else (s, c)
    s = -s if quarter < -0.2 or quarter > 0.4 else s
    c = -c if quarter > 0.2 or quarter < -0.4 else c
    return s, c


@routine
def fill_angles(angles, sines, cosines):
    """Write the sines and cosines of the angles [rad]."""
    n, largest = len(angles), 0.0
    for k in range(n):
        largest = max(largest, abs(angles[k]))
    if largest < MOST:
        for k in range(n):
            sines[k], cosines[k] = one_angle(angles[k])
    else:
        for k in range(n):
            sines[k], cosines[k] = sin(angles[k]), cos(angles[k])
