"""What functions that have no source in Python, or another one there, are on symbols."""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.loops import UNROLLED
from crane_sim.tracing.operations import fma, select, sqrt, to_integer
from crane_sim.tracing.operators import items_of
from crane_sim.tracing.ranges import SimdRange
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.vectors import local_array, simd_range, use_wide_vectors

_PYTHON = {Kind.REAL: float, Kind.INTEGER: int, Kind.BOOLEAN: bool, Kind.WORD: np.uint64}


def type_of(x: Any) -> type:
    """Return the class of an object; of a symbol, that of what it stands for."""
    if isinstance(x, Value):
        return _PYTHON[x.kind]
    return np.ndarray if isinstance(x, ArraySymbol) else type(x)


def _length(graph: Graph, x: Any) -> Any:
    if isinstance(x, Value):
        raise TraceError("a number has no elements")
    return x.shape[0] if isinstance(x, ArraySymbol) else len(x)


def _to_float(graph: Graph, x: Any) -> Any:
    return arithmetic.convert(graph, x, Kind.REAL) if isinstance(x, Value) else float(x)


def _symbol_unless_finite(graph: Graph, x: Any) -> Any:
    """Return a number that has no integer as a symbol: the code that rounds it may never run."""
    return graph.constant(x) if isinstance(x, float) and not math.isfinite(x) else x


def _to_int(graph: Graph, x: Any) -> Any:
    x = _symbol_unless_finite(graph, x)
    return arithmetic.convert(graph, x, Kind.INTEGER) if isinstance(x, Value) else int(x)


def _to_word(graph: Graph, x: Any) -> Any:
    return arithmetic.convert(graph, x, Kind.WORD) if isinstance(x, Value) else np.uint64(x)


def _to_flag(graph: Graph, x: Any) -> Any:
    return arithmetic.holds(x)


def _round(graph: Graph, x: Any) -> Any:
    x = _symbol_unless_finite(graph, x)
    if not isinstance(x, Value):
        return round(x)
    return _to_int(graph, arithmetic.call_function("round", x) if x.kind is Kind.REAL else x)


def _rounded(name: str) -> Callable[..., Any]:
    def handler(graph: Graph, x: Any) -> Any:
        x = _symbol_unless_finite(graph, x)
        if not isinstance(x, Value):
            return getattr(math, name)(x)
        return _to_int(graph, arithmetic.call_function(name, x) if x.kind is Kind.REAL else x)

    return handler


def _extreme(function: Callable[..., Any]) -> Callable[..., Any]:
    def handler(graph: Graph, *numbers: Any) -> Any:
        if len(numbers) == 1:
            numbers = tuple(items_of(numbers[0]))
        return function(*numbers)

    return handler


def _absolute(graph: Graph, x: Any) -> Any:
    return arithmetic.absolute(x)


def _function(name: str) -> Callable[..., Any]:
    def handler(graph: Graph, *numbers: Any) -> Any:
        return arithmetic.call_function(name, *numbers)

    return handler


def _power(graph: Graph, a: Any, b: Any) -> Any:
    if not (isinstance(a, Value) or isinstance(b, Value)):
        return math.pow(a, b)
    return arithmetic.call_function("power", a, b)


def _is_finite(graph: Graph, x: Any) -> Any:
    if not isinstance(x, Value):
        return math.isfinite(x)
    return arithmetic.combine("less", arithmetic.absolute(x), math.inf)


def _is_nan(graph: Graph, x: Any) -> Any:
    return arithmetic.combine("unequal", x, x) if isinstance(x, Value) else math.isnan(x)


def _sign(graph: Graph, x: Any) -> Any:
    one, zero = (1.0, 0.0) if arithmetic.number_kind(x) is Kind.REAL else (1, 0)
    below = arithmetic.choose(arithmetic.combine("less", x, 0), -one, x)  # NaN stays
    result = arithmetic.choose(arithmetic.combine("greater", x, 0), one, below)
    return arithmetic.choose(arithmetic.combine("equal", x, 0), zero, result)  # -0.0 becomes 0.0


def _is_instance(graph: Graph, x: Any, kinds: Any) -> bool:
    return issubclass(type_of(x), kinds)


def _class_of(graph: Graph, x: Any) -> type:
    return type_of(x)


def _has_attribute(graph: Graph, x: Any, name: str) -> bool:
    if isinstance(x, ArraySymbol) and x.dtype.names:
        return name in x.dtype.names
    return hasattr(type_of(x) if isinstance(x, Value | ArraySymbol) else x, name)


def _attribute(graph: Graph, x: Any, name: str, *default: Any) -> Any:
    if isinstance(x, Value | ArraySymbol | RecordSymbol):
        raise TraceError("getattr of a number or an array is not traced")
    return getattr(x, name, *default)


def _reversed(graph: Graph, tree: Any) -> tuple[Any, ...]:
    return tuple(reversed(items_of(tree)))


def _sum(graph: Graph, numbers: Any, start: Any = 0) -> Any:
    for x in items_of(numbers):
        start = arithmetic.combine("add", start, x)
    return start


def _every(graph: Graph, conditions: Any) -> Any:
    result: Any = True
    for x in items_of(conditions):
        result = arithmetic.combine("both", result, arithmetic.holds(x))
    return result


def _some(graph: Graph, conditions: Any) -> Any:
    if isinstance(conditions, ArraySymbol):
        return _some_element(graph, conditions)
    result: Any = False
    for x in items_of(conditions):
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


def _empty(graph: Graph, shape: Any, dtype: Any = float) -> ArraySymbol:
    return array_symbols.allocate(graph, _as_shape(shape), np.dtype(dtype))


def _full(number: float) -> Callable[..., Any]:
    def handler(graph: Graph, shape: Any, dtype: Any = float) -> ArraySymbol:
        array = _empty(graph, shape, dtype)
        array_symbols.assign(array, number)
        return array

    return handler


def _empty_like(graph: Graph, array: ArraySymbol) -> ArraySymbol:
    return array_symbols.allocate(graph, array.shape, array.dtype)


def _arange(graph: Graph, count: Any) -> ArraySymbol:
    array = array_symbols.allocate(graph, (count,), np.dtype("i8"))
    array_symbols.for_each(graph, count, lambda i: array_symbols.set_item(array, i, i))
    return array


def _zip(graph: Graph, *trees: Any, strict: bool = False) -> Any:
    return tuple(zip(*(items_of(tree) for tree in trees), strict=strict))


def _enumerate(graph: Graph, tree: Any, start: int = 0) -> Any:
    return tuple(enumerate(items_of(tree), start))


def _to_tuple(graph: Graph, tree: Any = ()) -> Any:
    return tuple(items_of(tree))


def _select(graph: Graph, condition: Any, a: Any, b: Any) -> Any:
    return arithmetic.choose(condition, a, b)


def _to_integer(graph: Graph, x: Any) -> Any:
    return arithmetic.convert(graph, x, Kind.INTEGER) if isinstance(x, Value) else to_integer(x)


def _simd_range(graph: Graph, *bounds: Any) -> range | SimdRange:
    if any(isinstance(bound, Value) for bound in bounds):
        return SimdRange(*bounds)
    turns = range(*bounds)
    return turns if len(turns) <= UNROLLED and len(turns) % _WIDEST else SimdRange(*bounds)


def _local_array(graph: Graph, shape: tuple[int, ...]) -> ArraySymbol:
    if graph.is_in_a_block:
        raise TraceError(
            "an array of a function's own inside a loop or a branch: it is one for all turns"
        )
    dtype = np.dtype(float)
    strides = array_symbols.contiguous_strides(shape, dtype.itemsize)
    return ArraySymbol(graph.new_slot(math.prod(shape)), 0, dtype, shape, strides)


def _use_wide_vectors(graph: Graph) -> None:
    graph.has_wide_vectors = True


def _print(graph: Graph, *_: Any) -> None:
    """Print nothing."""


_WIDEST = 8  # numbers in a vector
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
    type: _class_of,
    getattr: _attribute,
    hasattr: _has_attribute,
    reversed: _reversed,
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
    fma: _function("fma"),
    sqrt: _function("sqrt"),
    select: _select,
    to_integer: _to_integer,
    simd_range: _simd_range,
    local_array: _local_array,
    use_wide_vectors: _use_wide_vectors,
    **{
        getattr(math, name): _function(name)
        for name in (
            "sqrt",
            "exp",
            "log",
            "sin",
            "cos",
            "tan",
            "asin",
            "acos",
            "atan",
            "tanh",
            "sinh",
            "cosh",
            "atan2",
            "hypot",
            "fmod",
        )
    },
    np.sqrt: _function("sqrt"),
    np.tanh: _function("tanh"),
    np.sin: _function("sin"),
    np.cos: _function("cos"),
    np.exp: _function("exp"),
    np.isnan: _is_nan,
    np.isfinite: _is_finite,
}
"""What functions that have no source in Python, or another one there, are on symbols."""
