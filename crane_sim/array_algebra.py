"""Arithmetic on states that are arrays, which `state_algebra` compiles for them, and rows of results."""

from typing import Any

import numpy as np
from numba.core import types
from numba.extending import overload

from crane_sim.jit import OPTIONS, intrinsic, routine


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


@routine
def combine_rows(h, weights, ks):
    """Return the sum of h weights[j] ks[j]."""
    out = np.zeros(ks.shape[1])
    for j in range(len(weights)):
        weight = h * weights[j]
        if weight != 0.0:
            for i in range(len(out)):
                out[i] += weight * ks[j, i]
    return out


@routine
def move_rows(x, h, weights, ks):
    """Return x plus the sum of h weights[j] ks[j]."""
    out = np.zeros(len(x))
    for j in range(len(weights)):
        weight = h * weights[j]
        if weight != 0.0:
            for i in range(len(out)):
                out[i] += weight * ks[j, i]
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
