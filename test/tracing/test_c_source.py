"""Traced functions in C have the bits of Python."""

import math
from pathlib import Path

import numpy as np
from c_compiler import c_function, needs_compiler

from crane_sim.numerics.elementary import fma, sincos
from crane_sim.tracing.c_source import c_source
from crane_sim.tracing.calls import trace_on_arrays

TABLE = np.array([1.5, -2.0, 0.25, 8.0])


def cube_root(x):
    """Return (the cube root of x > 0 by Newton's iteration, how many iterations)."""
    z, change, count = x + 1.0, 1.0, 0
    while abs(change) > 1e-9 * z:
        change = (z * z * z - x) / (3.0 * z * z)
        z -= change
        count += 1
    return z, count


def mix(x, out):
    """Write numbers made by branches, loops, calls, integers, a table and memory of its own."""
    (s, c), (root, count) = sincos(x[0]), cube_root(1.0 + x[1] * x[1])
    whole = int(1e3 * x[1])
    work = np.empty(4)
    for i in range(4):
        work[i] = TABLE[(i + count) % 4] * x[2]
    out[0] = s * x[1] if s < c else math.sqrt(c * c + 1.0) + x[1]
    out[1] = root + count
    out[2] = fma(x[0], x[1], work[0] + work[3])
    out[3] = whole // 7 + whole % 7 + (whole >> 2) - (whole & 5 | 8) ^ 3
    out[4] = (x[2] * x[2]) ** 0.3 + math.atan2(x[0], x[1]) + round(x[2])
    out[5] = max(x[0], x[1]) - x[0] % 0.7 + math.copysign(x[1], x[2])
    if x[0] > 0.0 and not x[1] > x[2]:
        out[5] = math.inf


def square(x):
    """Return x x."""
    return x * x


@needs_compiler
def test_c_has_the_bits_of_python(tmp_path: Path) -> None:
    """A program with all that C is written for has the bits of Python, at 200 random inputs.

    These have sizes from 0.1 to 100.
    """
    function = c_function(c_source(trace_on_arrays(mix, (3, 6)), "mix"), "mix", tmp_path)
    rng = np.random.default_rng(7)
    for x in rng.standard_normal((200, 3)) * 10.0 ** rng.integers(-1, 3, (200, 1)):
        out, expected = np.zeros(6), np.zeros(6)
        function(x, out)
        mix(x.tolist(), expected)
        assert out.tobytes() == expected.tobytes(), x
