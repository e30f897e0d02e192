"""Calls while tracing: a function is traced once for each structure of its arguments, and called from then on."""

import math
import types
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, Kind, TraceError, Value
from crane_sim.tracing.interpreter import Frame, ResultChange, Returned, SimdRange
from crane_sim.tracing.merging import Rebuild, base_address, rebuilt, sizes_of, split, with_address
from crane_sim.tracing.scopes import source_of
from crane_sim.tracing.vectors import local_array, simd_range, use_wide_vectors

_PYTHON = {Kind.REAL: float, Kind.INTEGER: int, Kind.BOOLEAN: bool, Kind.WORD: np.uint64}


class Traced(NamedTuple):
    """A traced function, and what makes its result of the results of a call."""

    function: Function
    result: Rebuild


class Calls:
    """The functions of one module of code."""

    def __init__(self) -> None:
        """Begin without functions."""
        self._traced: dict[Any, Traced] = {}
        self._names = 0
        self.functions: set[types.FunctionType] = set()  # that are traced

    def call(self, graph: Graph, function: Any, arguments: list[Any], keywords: dict[str, Any]) -> Any:
        """Return the result of a call of any function or class with symbols, arrays and other objects."""
        handler = self._handler(function)
        if handler is not None:
            return handler(self, graph, *arguments, **keywords)
        implementation, inlined = resolve(function, arguments)
        if not isinstance(implementation, types.FunctionType) or not _is_traced(implementation):
            return implementation(*arguments, **keywords)
        return self.call_traced(graph, implementation, arguments, keywords, inlined)

    def _handler(self, function: Any) -> Any:
        try:
            return HANDLERS.get(function)
        except TypeError:
            return None

    def call_traced(
        self, graph: Graph, function: types.FunctionType, arguments: list[Any], keywords: dict[str, Any], inlined: bool
    ) -> Any:
        """Return the result of a call of a function that is traced on its own."""
        bound = source_of(function).signature.bind(*arguments, **keywords)
        bound.apply_defaults()
        tree = tuple(_as_argument(self, graph, x) for x in bound.arguments.values())
        leaves, key, rebuild = take_apart(tree, graph, not inlined)
        whole = function, key
        if whole not in self._traced:
            kinds = tuple(leaf.kind for leaf in leaves)
            self._traced[whole] = self._trace(function, tuple(bound.arguments), rebuild, kinds, inlined)
        traced = self._traced[whole]
        graph.has_allocations |= traced.function.graph.has_allocations
        graph.has_wide_vectors |= inlined and traced.function.graph.has_wide_vectors
        numbers = tuple(leaf.number for leaf in leaves)
        results = graph.append("call", numbers, traced.function.result_kinds, traced.function)
        return traced.result(iter(results))

    def _trace(
        self, function: types.FunctionType, names: tuple[str, ...], rebuild: Rebuild, kinds: tuple[Kind, ...],
        inlined: bool,
    ) -> Traced:  # fmt: skip
        result_kinds: list[Kind] = []
        self.functions.add(function)
        while True:
            graph = Graph()
            rebuilds: list[Rebuild] = []

            def values(*symbols: Value) -> tuple[Value, ...]:
                arguments = dict(zip(names, rebuild(iter(symbols)), strict=True))
                frame = Frame(graph, self, source_of(function), arguments)
                frame.result_kinds = result_kinds
                outcome = frame.run(frame.source.body)
                value = outcome.value if isinstance(outcome, Returned) else None
                leaves, result = split(value, graph, False)
                rebuilds.append(result)
                return tuple(leaves)

            try:
                block = graph.trace_block(values, kinds)
            except ResultChange:
                continue
            self._names += 1
            name = f"{function.__name__.strip('<>')}.{self._names}"
            return Traced(Function(name, function, graph, block, None, inlined, False), rebuilds[0])

    def array_of(self, graph: Graph, array: np.ndarray) -> ArraySymbol:
        """Return a constant array in memory."""
        data = np.ascontiguousarray(array)
        if data.dtype.kind not in "fiu" or data.dtype.itemsize != 8:
            raise TraceError(f"a constant array of {data.dtype}")
        (address,) = graph.append("table", (), (Kind.ARRAY,), data.tobytes())
        return ArraySymbol(address, 0, data.dtype, data.shape, data.strides)

    def constant_array(self, graph: Graph, array: np.ndarray, index: Any) -> Any:
        """Return what a constant array has at an index."""
        indices = index if isinstance(index, tuple) else (index,)
        if any(isinstance(i, Value) or (isinstance(i, slice) and any(isinstance(x, Value) for x in (i.start, i.stop)))
               for i in indices):  # fmt: skip
            return array_symbols.get_item(self.array_of(graph, array), index)
        part = array[index]
        return part if isinstance(part, np.ndarray) else part.item()


def resolve(function: Any, arguments: list[Any]) -> tuple[Any, bool]:
    """Return (the Python function that a call runs, whether it is inlined into its callers)."""
    inlined = getattr(function, "inlined", True)
    if hasattr(function, "dispatch"):
        implementation = function.dispatch(type_of(arguments[0]))
        return implementation, inlined and getattr(implementation, "inlined", True)
    return getattr(function, "py_func", function), inlined


def type_of(x: Any) -> type:
    """Return the class of an object; of a symbol, that of what it stands for."""
    if isinstance(x, Value):
        return _PYTHON[x.kind]
    return np.ndarray if isinstance(x, ArraySymbol) else type(x)


def _is_traced(function: types.FunctionType) -> bool:
    module = function.__module__ or ""
    return not module.startswith(("crane_sim.tracing", "functools", "typing", "numpy", "collections"))


def _as_argument(calls: Calls, graph: Graph, x: Any) -> Any:
    if isinstance(x, tuple):
        return rebuilt(x, [_as_argument(calls, graph, part) for part in x])
    if isinstance(x, list):
        return tuple(_as_argument(calls, graph, part) for part in x)
    return calls.array_of(graph, x) if isinstance(x, np.ndarray) else x


def take_apart(tree: Any, graph: Graph, integers: bool) -> tuple[list[Value], Any, Rebuild]:
    """Return (the leaves of arguments, what else tells one structure from another, what makes arguments of leaves).

    Args:
        tree: of the arguments; floats that are known are leaves as well.
        graph: of its symbols.
        integers: so are integers.
    """
    if isinstance(tree, tuple):
        parts = [take_apart(part, graph, integers) for part in tree]
        leaves = [leaf for part, _, _ in parts for leaf in part]
        key = type(tree), *(part_key for _, part_key, _ in parts)
        return leaves, key, lambda it: rebuilt(tree, [rebuild(it) for _, _, rebuild in parts])
    if isinstance(tree, ArraySymbol | RecordSymbol):
        leaves = [base_address(graph, tree), *sizes_of(tree)]
        sizes = () if isinstance(tree, RecordSymbol) else (*tree.shape, *tree.strides)
        key = type(tree), str(tree.dtype), tuple(None if isinstance(x, Value) else x for x in sizes)
        return leaves, key, lambda it: with_address(tree, next(it), it)
    if isinstance(tree, Value):
        return [graph.lift(tree, tree.kind)], tree.kind, lambda it: next(it)
    if isinstance(tree, float) or (integers and type(tree) is int):
        value = graph.constant(tree, arithmetic.number_kind(tree))
        return [value], value.kind, lambda it: next(it)
    return [], (type(tree), tree), lambda it: tree


# What is not traced from its source


def _length(calls: Calls, graph: Graph, x: Any) -> Any:
    return x.shape[0] if isinstance(x, ArraySymbol) else len(x)


def _to_float(calls: Calls, graph: Graph, x: Any) -> Any:
    return arithmetic.convert(graph, x, Kind.REAL) if isinstance(x, Value) else float(x)


def _to_int(calls: Calls, graph: Graph, x: Any) -> Any:
    return arithmetic.convert(graph, x, Kind.INTEGER) if isinstance(x, Value) else int(x)


def _to_word(calls: Calls, graph: Graph, x: Any) -> Any:
    return arithmetic.convert(graph, x, Kind.WORD) if isinstance(x, Value) else np.uint64(x)


def _to_flag(calls: Calls, graph: Graph, x: Any) -> Any:
    return arithmetic.holds(x)


def _round(calls: Calls, graph: Graph, x: Any) -> Any:
    if not isinstance(x, Value):
        return round(x)
    return _to_int(calls, graph, arithmetic.call_function("round", x))


def _rounded(name: str) -> Callable[..., Any]:
    def handler(calls: Calls, graph: Graph, x: Any) -> Any:
        if not isinstance(x, Value):
            return getattr(math, name)(x)
        return _to_int(calls, graph, arithmetic.call_function(name, x))

    return handler


def _extreme(function: Callable[..., Any]) -> Callable[..., Any]:
    def handler(calls: Calls, graph: Graph, *numbers: Any) -> Any:
        if len(numbers) == 1:
            numbers = tuple(numbers[0])
        return function(*numbers)

    return handler


def _absolute(calls: Calls, graph: Graph, x: Any) -> Any:
    return arithmetic.absolute(x)


def _function(name: str) -> Callable[..., Any]:
    def handler(calls: Calls, graph: Graph, *numbers: Any) -> Any:
        return arithmetic.call_function(name, *numbers)

    return handler


def _power(calls: Calls, graph: Graph, a: Any, b: Any) -> Any:
    if not (isinstance(a, Value) or isinstance(b, Value)):
        return math.pow(a, b)
    return arithmetic.call_function("power", a, b)


def _is_finite(calls: Calls, graph: Graph, x: Any) -> Any:
    if not isinstance(x, Value):
        return math.isfinite(x)
    return arithmetic.combine("less", arithmetic.absolute(x), math.inf)


def _is_nan(calls: Calls, graph: Graph, x: Any) -> Any:
    return arithmetic.combine("unequal", x, x) if isinstance(x, Value) else math.isnan(x)


def _sign(calls: Calls, graph: Graph, x: Any) -> Any:
    below = arithmetic.choose(arithmetic.combine("less", x, 0.0), -1.0, arithmetic.combine("multiply", x, 1.0))
    return arithmetic.choose(arithmetic.combine("greater", x, 0.0), 1.0, below)


def _is_instance(calls: Calls, graph: Graph, x: Any, kinds: Any) -> bool:
    return issubclass(type_of(x), kinds)


def _sum(calls: Calls, graph: Graph, numbers: Any, start: Any = 0) -> Any:
    for x in numbers:
        start = arithmetic.combine("add", start, x)
    return start


def _every(calls: Calls, graph: Graph, conditions: Any) -> Any:
    result: Any = True
    for x in conditions:
        result = arithmetic.combine("both", result, arithmetic.holds(x))
    return result


def _some(calls: Calls, graph: Graph, conditions: Any) -> Any:
    if isinstance(conditions, ArraySymbol):
        return _some_element(graph, conditions)
    result: Any = False
    for x in conditions:
        result = arithmetic.combine("either", result, arithmetic.holds(x))
    return result


def _some_element(graph: Graph, array: ArraySymbol) -> Any:
    slot = graph.new_slot(1)
    graph.append("write", (graph.constant(False, Kind.BOOLEAN).number, slot.number), (), (0, "b1"))

    def visit(part: ArraySymbol) -> Callable[[Any], None]:
        def turn(i: Any) -> None:
            x = array_symbols.get_item(part, i)
            if isinstance(x, ArraySymbol):
                array_symbols.for_each(graph, x.shape[0], visit(x))
                return
            before = graph.append("read", (slot.number,), (Kind.BOOLEAN,), (0, "b1"))[0]
            now = arithmetic.combine("either", before, arithmetic.holds(x))
            graph.append("write", (now.number, slot.number), (), (0, "b1"))

        return turn

    array_symbols.for_each(graph, array.shape[0], visit(array))
    return graph.append("read", (slot.number,), (Kind.BOOLEAN,), (0, "b1"))[0]


def _as_shape(shape: Any) -> tuple[Any, ...]:
    return shape if isinstance(shape, tuple) else (shape,)


def _empty(calls: Calls, graph: Graph, shape: Any, dtype: Any = float) -> ArraySymbol:
    return array_symbols.allocate(graph, _as_shape(shape), np.dtype(dtype))


def _full(number: float) -> Callable[..., Any]:
    def handler(calls: Calls, graph: Graph, shape: Any, dtype: Any = float) -> ArraySymbol:
        array = _empty(calls, graph, shape, dtype)
        array_symbols.assign(array, number)
        return array

    return handler


def _empty_like(calls: Calls, graph: Graph, array: ArraySymbol) -> ArraySymbol:
    return array_symbols.allocate(graph, array.shape, array.dtype)


def _arange(calls: Calls, graph: Graph, count: Any) -> ArraySymbol:
    array = array_symbols.allocate(graph, (count,), np.dtype("i8"))
    array_symbols.for_each(graph, count, lambda i: array_symbols.set_item(array, i, i))
    return array


def _zip(calls: Calls, graph: Graph, *trees: Any, strict: bool = False) -> Any:
    return list(zip(*(_items(tree) for tree in trees), strict=strict))


def _items(tree: Any) -> list[Any]:
    if isinstance(tree, ArraySymbol):
        if isinstance(tree.shape[0], Value):
            raise TraceError("the length of an array is not known")
        return [array_symbols.get_item(tree, i) for i in range(tree.shape[0])]
    return list(tree)


def _enumerate(calls: Calls, graph: Graph, tree: Any, start: int = 0) -> Any:
    return list(enumerate(_items(tree), start))


def _to_tuple(calls: Calls, graph: Graph, tree: Any = ()) -> Any:
    return tuple(_items(tree))


def _fma(calls: Calls, graph: Graph, a: Any, b: Any, c: Any) -> Any:
    return arithmetic.call_function("fma", a, b, c)


def _simd_range(calls: Calls, graph: Graph, count: Any) -> SimdRange:
    return SimdRange(count)


def _local_array(calls: Calls, graph: Graph, shape: tuple[int, ...]) -> ArraySymbol:
    dtype = np.dtype(float)
    return ArraySymbol(
        graph.new_slot(math.prod(shape)), 0, dtype, shape, array_symbols.contiguous_strides(shape, dtype.itemsize)
    )


def _use_wide_vectors(calls: Calls, graph: Graph) -> None:
    graph.has_wide_vectors = True


def _print(calls: Calls, graph: Graph, *_: Any) -> None:
    """Print nothing."""


HANDLERS: dict[Any, Callable[..., Any]] = {
    len: _length,
    float: _to_float,
    np.float64: _to_float,
    int: _to_int,
    np.int64: _to_int,
    np.uint64: _to_word,
    bool: _to_flag,
    round: _round,
    math.floor: _rounded("floor"),
    math.ceil: _rounded("ceil"),
    min: _extreme(arithmetic.smallest),
    max: _extreme(arithmetic.largest),
    abs: _absolute,
    math.fabs: _absolute,
    math.pow: _power,
    math.isfinite: _is_finite,
    math.isnan: _is_nan,
    math.copysign: _function("copy_sign"),
    np.sign: _sign,
    isinstance: _is_instance,
    sum: _sum,
    all: _every,
    any: _some,
    np.any: _some,
    np.empty: _empty,
    np.zeros: _full(0.0),
    np.ones: _full(1.0),
    np.empty_like: _empty_like,
    np.arange: _arange,
    zip: _zip,
    enumerate: _enumerate,
    tuple: _to_tuple,
    list: _to_tuple,
    print: _print,
    simd_range: _simd_range,
    local_array: _local_array,
    use_wide_vectors: _use_wide_vectors,
    **{getattr(math, name): _function(name)
       for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh", "sinh", "cosh", "atan2",
                    "hypot", "fmod")},
    np.sqrt: _function("sqrt"),
    np.tanh: _function("tanh"),
    np.sin: _function("sin"),
    np.cos: _function("cos"),
    np.exp: _function("exp"),
    np.isnan: _is_nan,
    np.isfinite: _is_finite,
}  # fmt: skip
"""What functions that have no source in Python, or another one there, are on symbols."""
