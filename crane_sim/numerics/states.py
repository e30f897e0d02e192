"""Arithmetic on states: floats, and tuples of states nested to any depth, held in registers by compiled code.

A structural zero of a tableau is None, selected by type, so it costs no arithmetic. Sums run left to right over the
stages and meet the state last, in Python and in compiled code alike. The compiled forms are LLVM instructions,
one for each float: numba's front end would take seconds for every tuple length.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from numba.core import types
from numba.cpython.unsafe.tuple import tuple_setitem as _tuple_setitem
from numba.extending import overload

from crane_sim.numerics.arrays import (
    add_arrays,
    add_scaled_arrays,
    array_square,
    dense,
    move_rows,
    rows_square,
    scale_array,
)
from crane_sim.numerics.elementary import fma
from crane_sim.numerics.jit import LEAN, OPTIONS, intrinsic


def _is_tuple(kind: Any) -> bool:
    return isinstance(kind, types.BaseTuple)


def _each(context: Any, builder: Any, kind: Any, operation: Callable[..., Any], *parts: Any) -> Any:
    """Return the state of type `kind` whose floats are the operation of the floats of `parts`."""
    if not _is_tuple(kind):
        return operation(*parts)
    values = []
    for i, inner in enumerate(kind):
        values.append(_each(context, builder, inner, operation, *(builder.extract_value(part, i) for part in parts)))
    return context.make_tuple(builder, kind, values)


@intrinsic
def add_floats(typing_context, x, y):
    """Return x + y."""

    def generate(context, builder, signature, args):
        return _each(context, builder, x, builder.fadd, *args)

    return x(x, y), generate


@intrinsic
def scale_floats(typing_context, a, x):
    """Return a x."""

    def generate(context, builder, signature, args):
        return _each(context, builder, x, lambda leaf: builder.fmul(args[0], leaf), args[1])

    return x(a, x), generate


@intrinsic
def smaller_floats(typing_context, x, y):
    """Return the smaller ones of the floats of x and y, those of x where they are equal."""

    def generate(context, builder, signature, args):
        def operation(a, b):
            return builder.select(builder.fcmp_ordered("<", b, a), b, a)

        return _each(context, builder, x, operation, *args)

    return x(x, y), generate


@intrinsic
def add_scaled_floats(typing_context, x, a, y):
    """Return x + a y, each float rounded once."""

    def generate(context, builder, signature, args):
        def operation(b, c):
            return builder.fma(args[1], c, b)

        return _each(context, builder, x, operation, args[0], args[2])

    return x(x, a, y), generate


@intrinsic
def combine_floats(typing_context, h, row, ks):
    """Return the sum of h row[j] ks[j] over the entries of `row` that are not None."""
    used = [j for j, entry in enumerate(row) if isinstance(entry, types.Float)]

    def generate(context, builder, signature, args):
        factors = [builder.fmul(args[0], builder.extract_value(args[1], j)) for j in used]

        def operation(*slopes):
            total = builder.fmul(factors[0], slopes[0])
            for factor, slope in zip(factors[1:], slopes[1:], strict=True):
                total = builder.fma(factor, slope, total)
            return total

        stages = [builder.extract_value(args[2], j) for j in used]
        return _each(context, builder, ks[0], operation, *stages)

    return ks[0](h, row, ks), generate


@intrinsic
def leaves_of_floats(typing_context, x):
    """Return the floats of x as a flat tuple."""

    def count(kind: Any) -> int:
        return sum(count(part) for part in kind) if _is_tuple(kind) else 1

    kind = types.UniTuple(types.float64, count(x))

    def generate(context, builder, signature, args):
        values = []
        _each(context, builder, x, lambda leaf: values.append(leaf) or leaf, args[0])
        return context.make_tuple(builder, kind, values)

    return kind(x), generate


tuple_setitem: Any = _tuple_setitem


State = Any
"""A float, an array of floats, or a tuple of states; arrays are never changed in place."""


def add(x: State, y: State) -> State:
    """Return x + y."""
    return tuple([add(a, b) for a, b in zip(x, y, strict=True)]) if isinstance(x, tuple) else x + y


def scale(a: float, x: State) -> State:
    """Return a x."""
    return tuple([scale(a, b) for b in x]) if isinstance(x, tuple) else a * x


def smaller(x: State, y: State) -> State:
    """Return the smaller ones of the floats of two tuples, those of x where they are equal."""
    return tuple(smaller(a, b) for a, b in zip(x, y, strict=True)) if isinstance(x, tuple) else min(x, y)


@overload(smaller, jit_options=OPTIONS)
def _compiled_smaller(x, y):
    return lambda x, y: smaller_floats(x, y)


def add_scaled(x: State, a: float, y: State) -> State:
    """Return x + a y, each float of a tuple rounded once."""
    if isinstance(x, tuple):
        return tuple([add_scaled(b, a, c) for b, c in zip(x, y, strict=True)])
    return x + a * y if isinstance(x, np.ndarray) else fma(a, y, x)


def weighted_sum(h: float, row: tuple[float | None, ...], ks: tuple[State, ...]) -> State:
    """Return the sum of h row[j] ks[j] over the entries of `row` that are not None (at least one is not)."""
    terms = [(h * a, k) for a, k in zip(row, ks, strict=True) if a is not None]
    total = scale(*terms[0])
    for a, k in terms[1:]:
        total = add_scaled(total, a, k)
    return total


def add_weighted(x: State, h: float, row: tuple[float | None, ...], ks: Any, out: State) -> State:
    """Return x + the sum of `weighted_sum`; of arrays, ks.rows being the derivatives, `out` is filled with it."""
    return add(x, weighted_sum(h, row, ks))


def squared_error_norm(e: State, x: State, y: State, rtol: float, atol: float) -> float:
    """Return the sum of squares of e / (atol + rtol max(|x|, |y|)), component by component."""
    total = 0.0
    for a, b, c in zip(leaves(e), leaves(x), leaves(y), strict=True):
        ratio = a / (atol + rtol * max(abs(b), abs(c)))
        total += ratio * ratio
    return total


def error_square(
    h: float, row: tuple[float | None, ...], ks: Any, x: State, y: State, rtol: float, atol: float
) -> float:
    """Return the `squared_error_norm` of the sum of `weighted_sum`; ks as of `add_weighted`."""
    return squared_error_norm(weighted_sum(h, row, ks), x, y, rtol, atol)


def leaves(x: State) -> tuple[float, ...]:
    """Return the floats of x as a flat tuple."""
    if isinstance(x, np.ndarray):
        return tuple(x.tolist())
    return tuple(leaf for part in x for leaf in leaves(part)) if isinstance(x, tuple) else (x,)


def replace_entry(x: tuple[float, ...], i: int, value: float) -> tuple[float, ...]:
    """Return the flat tuple x with `value` at index i."""
    return (*x[:i], value, *x[i + 1 :])


@overload(replace_entry, jit_options=OPTIONS)
def _replace_entry(x, i, value):
    return lambda x, i, value: tuple_setitem(x, i, value)


def replace_field(record: Any, name: str, value: Any) -> Any:
    """Return the NamedTuple with another value of a field; in compiled code the name is a literal."""
    return record._replace(**{name: value})


@intrinsic(prefer_literal=True)
def set_field(typing_context, record, name, value):
    """Return the result of `replace_field`; the field gets the value's type where its own cannot hold the value."""
    i, kinds = record.fields.index(name.literal_value), list(record)
    if typing_context.can_convert(value, kinds[i]) is None:
        kinds[i] = types.unliteral(value)
    kind: Any = types.BaseTuple.from_types(kinds, record.instance_class)

    def generate(context, builder, signature, args):
        parts = [builder.extract_value(args[0], j) for j in range(len(kinds))]
        parts[i] = context.cast(builder, args[2], signature.args[2], kinds[i])
        changed = context.make_tuple(builder, kind, parts)
        context.nrt.incref(builder, kind, changed)  # the caller owns what it receives
        return changed

    return kind(record, name, value), generate


@overload(replace_field, jit_options=OPTIONS, prefer_literal=True)
def _replace_field(record, name, value):
    return lambda record, name, value: set_field(record, name, value)


def dimension(x: State) -> int:
    """Return the number of floats in x."""
    return len(leaves(x))


def _for_arrays_or_tuples(function: Any, position: int, arrays: Any, tuples: Any) -> None:
    """Compile `function` as `arrays` where the argument at `position` is an array, else as `tuples`."""

    def choose(*arguments: Any) -> Any:
        return arrays if isinstance(arguments[position], types.Array) else tuples

    overload(function, strict=False, jit_options=OPTIONS)(choose)


_for_arrays_or_tuples(add, 0, lambda x, y: add_arrays(x, y), lambda x, y: add_floats(x, y))


_for_arrays_or_tuples(scale, 1, lambda a, x: scale_array(a, x), lambda a, x: scale_floats(a, x))


_for_arrays_or_tuples(
    add_scaled, 0, lambda x, a, y: add_scaled_arrays(x, a, y), lambda x, a, y: add_scaled_floats(x, a, y)
)


_for_arrays_or_tuples(leaves, 0, lambda x: x, lambda x: leaves_of_floats(x))


_for_arrays_or_tuples(dimension, 0, lambda x: len(x), lambda x: len(leaves_of_floats(x)))


@overload(weighted_sum, jit_options=OPTIONS)
def _compiled_combine(h, row, ks):
    return lambda h, row, ks: combine_floats(h, row, ks)


@overload(error_square, jit_options=LEAN)
def _compiled_error_square(h, row, ks, x, y, rtol, atol):
    if isinstance(x, types.Array):
        return lambda h, row, ks, x, y, rtol, atol: rows_square(h, dense(row), ks.rows, x, y, rtol, atol)
    return lambda h, row, ks, x, y, rtol, atol: squared_error_norm(combine_floats(h, row, ks), x, y, rtol, atol)


@overload(add_weighted, jit_options=LEAN)
def _compiled_add_weighted(x, h, row, ks, out):
    if isinstance(x, types.Array):
        return lambda x, h, row, ks, out: move_rows(x, h, dense(row), ks.rows, out)
    return lambda x, h, row, ks, out: add_floats(x, combine_floats(h, row, ks))


@overload(squared_error_norm, jit_options=LEAN)
def _weighted_square(e, x, y, rtol, atol):
    if isinstance(e, types.Array):
        return lambda e, x, y, rtol, atol: array_square(e, x, y, rtol, atol)

    def total_of_leaves(e, x, y, rtol, atol):
        es, xs, ys, total = leaves(e), leaves(x), leaves(y), 0.0
        for i in range(len(es)):
            ratio = es[i] / (atol + rtol * max(abs(xs[i]), abs(ys[i])))
            total += ratio * ratio
        return total

    return total_of_leaves
