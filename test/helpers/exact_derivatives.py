"""Derivatives of traced functions along directions by central differences in 60 digits."""

from typing import Any

import mpmath
import numpy as np
from traced_evaluation import COMPARISONS, FLOATS, Memory, Numbers, evaluate, trace_tree

from crane_sim.numerics.elementary import sincos
from crane_sim.tracing.arguments import describe, kinds_of
from crane_sim.tracing.instructions import Kind

DIGITS = 60
STEP = mpmath.mpf(10) ** -20  # so differences have errors of 1e-40


FUNCTIONS = (
    *("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh", "sinh", "cosh"),
    *("floor", "ceil", "atan2", "hypot", "power"),
)


def _truncate(x: Any) -> Any:
    return mpmath.floor(x) if x >= 0 else mpmath.ceil(x)


EXACT = Numbers(
    mpmath.mpf,
    {
        **{
            name: FLOATS.operations[name]
            for name in (*COMPARISONS, "add", "subtract", "multiply", "negate")
        },
        **{name: getattr(mpmath, name) for name in FUNCTIONS},
        "divide": lambda a, b: (
            a / b if b else mpmath.mpf(FLOATS.operations["divide"](float(a), float(b)))
        ),
        "absolute": abs,
        "copy_sign": lambda size, x: abs(size) if x >= 0 else -abs(size),
        "round": mpmath.nint,
        "fmod": lambda x, y: x - y * _truncate(x / y),
        "fma": lambda a, b, c: a * b + c,
    },
    {sincos: lambda x: (mpmath.sin(x), mpmath.cos(x))},
)
"""Reals of `DIGITS` digits."""


def exact_derivative(f: Any, arguments: Any, directions: Any, column: int = 0) -> np.ndarray:
    """Return the derivatives of the reals of f(*arguments), a flat array, along one of directions.

    Args:
        f: a Python function.
        arguments: tuple of its arguments.
        directions: as of `directional_derivatives`.
        column: which of them.
    """
    traced = trace_tree(
        describe(arguments, [], {}), lambda calls, graph, tree: calls.call(graph, f, list(tree), {})
    )
    with mpmath.workdps(DIGITS):
        ahead, behind = (
            _evaluate(traced, arguments, directions, column, sign * STEP) for sign in (1, -1)
        )
        return np.array([float((a - b) / (2 * STEP)) for a, b in zip(ahead, behind, strict=True)])


def _evaluate(traced: Any, arguments: Any, directions: Any, column: int, step: Any) -> list[Any]:
    memory, leaves = Memory(EXACT), list[Any]()
    kinds = kinds_of(describe(arguments, leaves, {}))
    values = [
        mpmath.mpf(x) if kind is Kind.REAL else x for x, kind in zip(leaves, kinds, strict=True)
    ]
    _move(arguments, directions, column, step, values, iter(range(len(values))), memory)
    results = iter(evaluate(traced.function, values, EXACT, memory))
    return _reals_of(traced.structure, results, memory)


def _move(
    tree: Any, direction: Any, column: int, step: Any, values: list[Any], at: Any, memory: Memory
) -> None:
    """Move the leaves of arguments, numbers and elements of arrays, by a step along a direction."""
    if isinstance(tree, tuple):
        for i, part in enumerate(tree):
            _move(
                part, None if direction is None else direction[i], column, step, values, at, memory
            )
    elif isinstance(tree, np.ndarray):
        address = values[next(at)]
        for _ in range(2 * tree.ndim):  # sizes and strides
            next(at)
        if direction is not None:
            for i, (x, d) in enumerate(
                zip(tree.ravel(), direction[..., column].ravel(), strict=True)
            ):
                memory.write(
                    address + 8 * i, "f8", mpmath.mpf(float(x)) + step * mpmath.mpf(float(d))
                )
    elif isinstance(tree, float | int | np.number):
        i = next(at)
        if direction is not None:
            values[i] += step * mpmath.mpf(float(direction[column]))


def _reals_of(structure: Any, results: Any, memory: Memory) -> list[Any]:
    """Return the reals of a value, given its structure and leaves."""
    if hasattr(structure, "dimensions"):
        address = next(results)
        shape, strides = ([next(results) for _ in range(structure.dimensions)] for _ in range(2))
        places = address + sum(
            index * stride for index, stride in zip(np.indices(shape), strides, strict=True)
        )
        return (
            [memory.read(int(place), "f8") for place in np.ravel(places)]
            if structure.dtype == float
            else []
        )
    if isinstance(structure, tuple):
        return [x for part in structure for x in _reals_of(part, results, memory)]
    if structure is None or not isinstance(structure, type):
        return []
    x = next(results)
    return [x] if isinstance(x, mpmath.mpf) else []
