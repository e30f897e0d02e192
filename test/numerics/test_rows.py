"""Functions of floats applied to rows: compiled vectors against Python, by element."""

import numpy as np
import pytest

from crane_sim.numerics.elementary import fma, sincos
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.rows import elementwise


@elementwise
def fill_mixture(a, b):
    """Fill sine and cosine of a; a number that every operation goes into; a constant."""
    s, c = sincos(a)
    return s, c, 2.0 - (-a * b + 0.5) / (1.0 + b * b) + fma(a, b, 3.0 - s), 0.25


@entry_point
def fill_rows(n, out, a, b):
    """Fill four rows of `out`."""
    fill_mixture(n, (out[0], out[1], out[2], out[3]), (a, b))


@entry_point
def each_sincos(angles, out):
    """Fill out (2, n) with sines and cosines, one by one."""
    for i in range(len(angles)):
        out[0, i], out[1, i] = sincos(angles[i])


ANGLES = np.concatenate(
    [np.linspace(-9.0, 9.0, 20), [0.0, -0.0, 1e4, -1e4, np.pi / 4, -np.pi / 4, 1e-9, 3.0, 1e-300]]
)


@pytest.mark.parametrize("n", [0, 1, 2, 3, 7, 8, 10, 29])
def test_rows_of_any_length_have_the_bits_of_floats(n: int) -> None:
    """However a row falls into vectors, elements are Python's, and nothing behind is touched."""
    b, out = np.linspace(0.1, 2.0, len(ANGLES)), np.full((4, len(ANGLES)), 7.0)
    fill_rows(n, out, ANGLES, b)
    sines = np.empty((2, len(ANGLES)))
    each_sincos(ANGLES, sines)
    for k in range(n):
        third = (
            2.0
            - (-ANGLES[k] * b[k] + 0.5) / (1.0 + b[k] * b[k])
            + fma(ANGLES[k], b[k], 3.0 - sines[0, k])
        )
        assert out[:, k].tobytes() == np.array([*sines[:, k], third, 0.25]).tobytes()
    assert (out[:, n:] == 7.0).all()
