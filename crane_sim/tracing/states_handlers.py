"""Arithmetic of states in traced code: rows of arrays, with the sums of `numerics.arrays`."""

from typing import Any

from crane_sim.numerics import arrays, elementary, states
from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol
from crane_sim.tracing.calls import HANDLERS, Calls, _fma
from crane_sim.tracing.graph import Graph, TraceError, Value


def _accumulate(calls: Calls, graph: Graph, h: Any, weights: Any, count: Any, ks: Any, x: Any, out: Any) -> None:
    if isinstance(count, Value):
        raise TraceError("the number of rows that are added up is not known")
    entries = [array_symbols.get_item(weights, j) if isinstance(weights, ArraySymbol) else weights[j] for j in range(count)]
    factors = [arithmetic.combine("multiply", h, w) for w in entries]

    def turn(i: Any) -> None:
        total = arithmetic.combine("multiply", factors[0], array_symbols.get_item(ks, (0, i)))
        for j, factor in enumerate(factors[1:], 1):
            total = arithmetic.call_function("fma", factor, array_symbols.get_item(ks, (j, i)), total)
        if x is not None:
            total = arithmetic.combine("add", array_symbols.get_item(x, i), total)
        array_symbols.set_item(out, i, total)

    array_symbols.for_each(graph, out.shape[0], turn)


def _dense(calls: Calls, graph: Graph, row: Any) -> Any:
    return tuple(0.0 if x is None else x for x in row)


def _add_weighted(calls: Calls, graph: Graph, x: Any, h: Any, row: Any, ks: Any, out: Any) -> Any:
    if isinstance(x, ArraySymbol):
        return calls.call(graph, arrays.move_rows, [x, h, _dense(calls, graph, row), ks.rows, out], {})
    return calls.call(graph, states.add, [x, calls.call(graph, states.weighted_sum, [h, row, ks], {})], {})


def _error_square(calls: Calls, graph: Graph, h: Any, row: Any, ks: Any, x: Any, y: Any, rtol: Any, atol: Any) -> Any:
    if isinstance(x, ArraySymbol):
        return calls.call(graph, arrays.rows_square, [h, _dense(calls, graph, row), ks.rows, x, y, rtol, atol], {})
    e = calls.call(graph, states.weighted_sum, [h, row, ks], {})
    return calls.call(graph, states.squared_error_norm, [e, x, y, rtol, atol], {})


def _squared_error_norm(calls: Calls, graph: Graph, e: Any, x: Any, y: Any, rtol: Any, atol: Any) -> Any:
    if isinstance(e, ArraySymbol):
        return calls.call(graph, arrays.array_square, [e, x, y, rtol, atol], {})
    return calls.call_traced(graph, states.squared_error_norm, [e, x, y, rtol, atol], {}, True)


def _leaves(calls: Calls, graph: Graph, x: Any) -> Any:
    if isinstance(x, ArraySymbol):
        return x
    return tuple(leaf for part in x for leaf in _leaves(calls, graph, part)) if isinstance(x, tuple) else (x,)


def _dimension(calls: Calls, graph: Graph, x: Any) -> Any:
    return x.shape[0] if isinstance(x, ArraySymbol) else len(_leaves(calls, graph, x))


def _of_arrays(function: Any, of_arrays: Any, position: int) -> Any:
    def handler(calls: Calls, graph: Graph, *arguments: Any) -> Any:
        if isinstance(arguments[position], ArraySymbol):
            return calls.call(graph, of_arrays, list(arguments), {})
        return calls.call_traced(graph, function, list(arguments), {}, True)

    return handler


def _replace_entry(calls: Calls, graph: Graph, x: Any, i: Any, value: Any) -> Any:
    if not isinstance(i, Value):
        return (*x[:i], value, *x[i + 1 :])
    return tuple(arithmetic.choose(arithmetic.combine("equal", i, k), value, part) for k, part in enumerate(x))


HANDLERS.update({
    states.replace_entry: _replace_entry,
    arrays.accumulate: _accumulate,
    arrays.dense: _dense,
    states.add_weighted: _add_weighted,
    states.error_square: _error_square,
    states.squared_error_norm: _squared_error_norm,
    states.leaves: _leaves,
    states.dimension: _dimension,
    states.add: _of_arrays(states.add, arrays.add_arrays, 0),
    states.scale: _of_arrays(states.scale, arrays.scale_array, 1),
    states.add_scaled: _of_arrays(states.add_scaled, arrays.add_scaled_arrays, 0),
    elementary.fma: _fma,
})  # fmt: skip
