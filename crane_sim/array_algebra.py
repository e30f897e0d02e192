"""Arithmetic on states that are arrays, which `state_algebra` compiles for them, and rows of results."""

from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload

from crane_sim.jit import OPTIONS, intrinsic, lean_routine, routine


@routine
def add_arrays(x, y):
    """Return x + y."""
    return add_scaled_arrays(x, 1.0, y)


@routine
def scale_array(a, x):
    """Return a x."""
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = a * x[i]
    return out


@routine
def add_scaled_arrays(x, a, y):
    """Return x + a y."""
    out = np.empty_like(x)
    for i in range(len(x)):
        out[i] = x[i] + a * y[i]
    return out


@lean_routine
def weigh(h, weights, count, ks, out):
    """Write the sum of h weights[j] ks[j] over the first `count` rows, at least one, into `out`.

    Four rows are added at a time, from left to right all the same; in place of those after the last one, that one with
    a weight of 0.
    """
    last = count - 1
    for j in range(0, count, 4):
        a, b, c = min(j + 1, last), min(j + 2, last), min(j + 3, last)
        u, v = h * weights[j], h * weights[a] if a > j else 0.0
        w, x = h * weights[b] if b > a else 0.0, h * weights[c] if c > b else 0.0
        if j == 0:
            for i in range(len(out)):
                out[i] = ((u * ks[j, i] + v * ks[a, i]) + w * ks[b, i]) + x * ks[c, i]
        else:
            for i in range(len(out)):
                out[i] = (((out[i] + u * ks[j, i]) + v * ks[a, i]) + w * ks[b, i]) + x * ks[c, i]


@routine
def combine_rows(h, weights, ks):
    """Return the sum of h weights[j] ks[j]."""
    out = np.empty(ks.shape[1])
    weigh(h, weights, len(weights), ks, out)
    return out


@routine
def move_rows(x, h, weights, ks):
    """Return x plus the sum of h weights[j] ks[j]."""
    out = combine_rows(h, weights, ks)
    for i in range(len(out)):
        out[i] += x[i]
    return out


@intrinsic
def dense(typing_context, row):
    """Return the row with 0 in place of None, as a tuple of one type."""
    kind = types.UniTuple(types.float64, len(row))

    def generate(context, builder, signature, args):
        zero = context.get_constant(types.float64, 0.0)
        given = [isinstance(entry, types.Float) for entry in row]
        entries = [builder.extract_value(args[0], j) if is_given else zero for j, is_given in enumerate(given)]
        return context.make_tuple(builder, kind, entries)

    return kind(row), generate


def store(rows: Any, i: int, first: int, values: tuple[float, ...]) -> None:
    """Write the values into row i from column `first` on; there may be none."""
    rows[i, first : first + len(values)] = values


@overload(store, jit_options=OPTIONS)
def _store(rows, i, first, values):
    def each(rows, i, first, values):
        for j in range(len(values)):
            rows[i, first + j] = values[j]

    return each if len(values) else lambda rows, i, first, values: None
