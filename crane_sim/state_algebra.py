"""Arithmetic on states: floats, and tuples of states nested to any depth, held in registers by compiled code.

A structural zero of a tableau is None: it is seen by type, so it costs no arithmetic. Sums run left to right over the
stages and meet the state last, in Python and in compiled code alike.
"""

from typing import Any

from numba.core import types
from numba.extending import overload

from crane_sim.jit import OPTIONS

State = Any
"""A float, or a tuple of states."""


def add(x: State, y: State) -> State:
    """Return x + y."""
    return tuple(add(a, b) for a, b in zip(x, y, strict=True)) if isinstance(x, tuple) else x + y


@overload(add, jit_options=OPTIONS)
def _add(x, y):
    if isinstance(x, types.Float):
        return lambda x, y: x + y
    if len(x) == 0:
        return lambda x, y: ()
    return lambda x, y: (add(x[0], y[0]), *add(x[1:], y[1:]))


def scale(a: float, x: State) -> State:
    """Return a x."""
    return tuple(scale(a, b) for b in x) if isinstance(x, tuple) else a * x


@overload(scale, jit_options=OPTIONS)
def _scale(a, x):
    if isinstance(x, types.Float):
        return lambda a, x: a * x
    if len(x) == 0:
        return lambda a, x: ()
    return lambda a, x: (scale(a, x[0]), *scale(a, x[1:]))


def add_scaled(x: State, a: float, y: State) -> State:
    """Return x + a y."""
    return tuple(add_scaled(b, a, c) for b, c in zip(x, y, strict=True)) if isinstance(x, tuple) else x + a * y


@overload(add_scaled, jit_options=OPTIONS)
def _add_scaled(x, a, y):
    if isinstance(x, types.Float):
        return lambda x, a, y: x + a * y
    if len(x) == 0:
        return lambda x, a, y: ()
    return lambda x, a, y: (add_scaled(x[0], a, y[0]), *add_scaled(x[1:], a, y[1:]))


def combine(h: float, row: tuple[float | None, ...], ks: tuple[State, ...]) -> State:
    """Return the sum of h row[j] ks[j] over the entries of `row` that are not None (at least one is not)."""
    terms = [(h * a, k) for a, k in zip(row, ks, strict=True) if a is not None]
    total = scale(*terms[0])
    for a, k in terms[1:]:
        total = add_scaled(total, a, k)
    return total


@overload(combine, jit_options=OPTIONS)
def _combine(h, row, ks):
    if isinstance(row[0], types.NoneType):
        return lambda h, row, ks: combine(h, row[1:], ks[1:])
    return lambda h, row, ks: _add_rest(scale(h * row[0], ks[0]), h, row[1:], ks[1:])


def _add_rest(total, h, row, ks):
    raise NotImplementedError  # compiled code only


@overload(_add_rest, jit_options=OPTIONS)
def _compiled_add_rest(total, h, row, ks):
    if len(row) == 0:
        return lambda total, h, row, ks: total
    if isinstance(row[0], types.NoneType):
        return lambda total, h, row, ks: _add_rest(total, h, row[1:], ks[1:])
    return lambda total, h, row, ks: _add_rest(add_scaled(total, h * row[0], ks[0]), h, row[1:], ks[1:])


def weighted_square(e: State, x: State, y: State, rtol: float, atol: float) -> float:
    """Return the sum of squares of e / (atol + rtol max(|x|, |y|)), component by component."""
    if isinstance(e, tuple):
        return sum((weighted_square(*parts, rtol, atol) for parts in zip(e, x, y, strict=True)), 0.0)
    ratio = e / (atol + rtol * max(abs(x), abs(y)))
    return ratio * ratio


@overload(weighted_square, jit_options=OPTIONS)
def _weighted_square(e, x, y, rtol, atol):
    if isinstance(e, types.Float):

        def component(e, x, y, rtol, atol):
            ratio = e / (atol + rtol * max(abs(x), abs(y)))
            return ratio * ratio

        return component
    if len(e) == 0:
        return lambda e, x, y, rtol, atol: 0.0

    def components(e, x, y, rtol, atol):
        head = weighted_square(e[0], x[0], y[0], rtol, atol)
        return head + weighted_square(e[1:], x[1:], y[1:], rtol, atol)

    return components


def dimension(x: State) -> int:
    """Return the number of floats in x."""
    return sum(dimension(part) for part in x) if isinstance(x, tuple) else 1


@overload(dimension, jit_options=OPTIONS)
def _dimension(x):
    n = _count(x)
    return lambda x: n


def _count(t: types.Type) -> int:
    return sum(_count(part) for part in t) if isinstance(t, types.BaseTuple) else 1  # pyright: ignore[reportGeneralTypeIssues]
