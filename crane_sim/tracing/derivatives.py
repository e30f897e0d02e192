"""Derivatives of functions along directions, by forward mode, in compiled code and in Python.

    value, derivative = directional_derivatives(f, (x, y), (x_directions, None))

computes f(x, y) and, at the same time, its derivatives along `DIRECTIONS` directions of x. A
direction is a tree like its argument: in place of a float an array (DIRECTIONS,), in place of an
array one with a last axis (…, DIRECTIONS), contiguous, None for what does not move. So is a
derivative like the value; what is no real, or an array that nothing moves, is itself there.
"""

import types
from collections.abc import Iterator
from typing import Any

import numpy as np

from crane_sim.tracing.arithmetic import combine, number_kind
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol, allocate, is_contiguous
from crane_sim.tracing.calls import Calls, resolve
from crane_sim.tracing.entry_point import EntryPoint
from crane_sim.tracing.forward_mode import ArgumentsNeeded
from crane_sim.tracing.graph import Graph, Value, numbers_of
from crane_sim.tracing.instructions import DIRECTIONS, Kind
from crane_sim.tracing.machine_code import NONE
from crane_sim.tracing.merging import base_address, sizes_of
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import rebuilt

_REALS = np.dtype(float)


def directional_derivatives(f: Any, arguments: Any, directions: Any) -> Any:
    """Return (f(*arguments), its derivatives along directions of the arguments).

    Raises:
        SceneError: f has an operation whose derivative is not known, as derivatives have, or stores
            what moves where nothing does; a direction is that of an integer, or of an array that is
            not contiguous.
    """
    return _IN_PYTHON.run(f, arguments, directions)


def _derive(f: Any, arguments: Any, directions: Any) -> Any:
    return directional_derivatives(f, arguments, directions)


_derive.optimisation = NONE  # type: ignore[attr-defined]  # Python calls it for a few instants
_IN_PYTHON = EntryPoint(_derive)


def trace_derivatives(
    calls: Calls, graph: Graph, f: Any, arguments: Any, directions: Any
) -> tuple[Any, Any]:
    """Note a call of `directional_derivatives`; return its result."""
    given, seeds = (calls.as_argument(graph, tuple(x)) for x in (arguments, directions))
    if isinstance(f, types.MethodType):
        f, given, seeds = f.__func__, (f.__self__, *given), (None, *seeds)
    variables, leaves, traced = calls.function_of(graph, resolve(f, list(given))[0], list(given))
    rest = variables[len(given) :]  # defaults
    tangents = list(_tangents_of(graph, (*given, *rest), (*seeds, *[None] * len(rest))))
    moved = tuple(tangent is not None for tangent in tangents)
    addresses = frozenset(
        i for i, kind in enumerate(traced.function.result_kinds) if kind is Kind.ARRAY
    )
    try:
        transformed = calls.forward_mode.transform(traced.function, moved, addresses)
    except ArgumentsNeeded as error:
        raise TraceError(
            "a number that moves is stored in an argument without directions"
        ) from error
    function, count = transformed.function, len(transformed.moved)
    graph.has_allocations |= function.graph.has_allocations
    numbers = numbers_of((*leaves, *(tangent for tangent in tangents if tangent is not None)))
    results = graph.append("call", numbers, function.result_kinds, function)
    rest = iter(results[count:])
    value = traced.result(iter(results[:count]))
    return value, _Derivative(
        graph, iter([next(rest) if moves else None for moves in transformed.moved])
    ).of(value)


directional_derivatives.traced_by = trace_derivatives  # type: ignore[attr-defined]


def _tangents_of(graph: Graph, tree: Any, direction: Any) -> Iterator[Value | None]:
    """Yield the tangents of the leaves of an argument, those of `take_apart`."""
    if isinstance(tree, tuple):
        for i, part in enumerate(tree):
            yield from _tangents_of(graph, part, None if direction is None else direction[i])
    elif isinstance(tree, ArraySymbol | RecordSymbol):
        yield None if direction is None else _address_of_tangents(graph, tree, direction)
        yield from [None] * len(sizes_of(tree))
    elif isinstance(tree, Value | float) or type(tree) is int:
        if direction is not None and number_kind(tree) is not Kind.REAL:
            raise TraceError("a direction of an integer: derivatives are by reals")
        yield None if direction is None else _read(direction)


def _address_of_tangents(graph: Graph, array: Any, direction: ArraySymbol) -> Value:
    for part in (array, direction):
        if isinstance(part, ArraySymbol) and not is_contiguous(part):
            raise TraceError(
                "derivatives by an array, or a direction, whose elements may be apart: give a copy "
                "of it"
            )
    return base_address(graph, direction)


def _read(direction: ArraySymbol) -> Value:
    literal = direction.offset, "t8"
    return direction.graph.append("read", (direction.address.number,), (Kind.TANGENT,), literal)[0]


class _Derivative:
    """Makes the derivative of a value of the tangents of its leaves."""

    def __init__(self, graph: Graph, tangents: Iterator[Value | None]) -> None:
        self._graph, self._tangents = graph, tangents

    def of(self, value: Any) -> Any:
        """Return the tree of arrays of derivatives."""
        if isinstance(value, tuple):
            return rebuilt(value, [self.of(part) for part in value])
        if not isinstance(value, Value | ArraySymbol | RecordSymbol):
            return self._store(None) if isinstance(value, float) else value
        tangent = next(self._tangents)
        for _ in sizes_of(value):
            next(self._tangents)
        if isinstance(value, Value):
            return self._store(tangent) if value.kind is Kind.REAL else value
        return (
            value
            if tangent is None or value.dtype != _REALS
            else _array_of_tangents(value, tangent)
        )

    def _store(self, tangent: Value | None) -> ArraySymbol:
        graph, array = self._graph, allocate(self._graph, (DIRECTIONS,), _REALS)
        value = graph.constant(0.0, Kind.TANGENT) if tangent is None else tangent
        graph.append("write", (value.number, array.address.number), (), (0, "t8"))
        return array


def _array_of_tangents(array: Any, address: Value) -> ArraySymbol:
    strides = [combine("multiply", stride, DIRECTIONS) for stride in array.strides]
    return ArraySymbol(address, 0, _REALS, (*array.shape, DIRECTIONS), (*strides, _REALS.itemsize))
