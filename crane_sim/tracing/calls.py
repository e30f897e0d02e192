"""Calls while tracing: a function is traced once for each structure of its arguments.

Entry points of one kind of scene share most functions: what has been traced is kept for those that
follow.
"""

import itertools
import types
from collections.abc import Iterator
from functools import cache
from operator import is_
from typing import Any, NamedTuple

import numpy as np

from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol
from crane_sim.tracing.builtin_functions import HANDLERS, type_of
from crane_sim.tracing.cache import SOURCES_AT_IMPORT
from crane_sim.tracing.forward_mode import ForwardMode
from crane_sim.tracing.frame import Frame, ResultChange, Returned
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, Value, numbers_of
from crane_sim.tracing.instructions import Block, Kind
from crane_sim.tracing.interpreter import run
from crane_sim.tracing.merging import Rebuild, base_address, sizes_of, split, with_address
from crane_sim.tracing.scopes import Source, source_of
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import rebuilt

_DEPTH = 60
"""Functions run in place that are inside one another at most: one that calls itself is then
refused."""
_ARRAYS: Any = (list, np.ndarray)
_LIBRARIES = {"builtins", "math", "numpy", "operator", "_operator", "functools"}
"""Modules whose functions of what is known are called while tracing: they have one result for the
same arguments."""
_LIBRARY_SOURCES = ("crane_sim.tracing", "functools", "typing", "numpy", "collections")


class Traced(NamedTuple):
    """A traced function, and what makes its result of the results of a call."""

    function: Function
    result: Rebuild
    functions: set[types.FunctionType]  # that are in it


_MOST = 500  # functions that are kept: those of two or three kinds of scene, about 20 MB
_TRACED: dict[Any, Traced] = {}
_NUMBERS = itertools.count(1)  # of functions, which are part of their names


def forget_functions() -> None:
    """Forget what has been traced: a call means another function from now on."""
    _TRACED.clear()


class Calls:
    """The functions of one module of code."""

    def __init__(self) -> None:
        """Begin without functions."""
        self._own: dict[Any, Traced] = {}
        self._under_way: set[Any] = set()
        self._depth = 0  # of functions that are run in place
        self.forward_mode = ForwardMode()
        self.functions: set[types.FunctionType] = set()  # that are traced

    def call(
        self, graph: Graph, function: Any, arguments: list[Any], keywords: dict[str, Any]
    ) -> Any:
        """Return the result of a call of any function or class with symbols and objects.

        Raises:
            TraceError: it is not traced.
        """
        if isinstance(function, types.MethodType) and _is_traced(function.__func__):
            function, arguments = function.__func__, [function.__self__, *arguments]
        handler = _handler_of(function)
        if handler is not None:
            return handler(graph, *arguments, **keywords)
        note: Any = getattr(function, "traced_by", None)
        if note is not None:
            return note(self, graph, *arguments)
        implementation, inlined = resolve(function, arguments)
        if not _is_traced(implementation):
            return _call_untraced(implementation, arguments, keywords)
        return self.call_traced(graph, implementation, arguments, keywords, inlined)

    def call_traced(
        self,
        graph: Graph,
        function: types.FunctionType,
        arguments: list[Any],
        keywords: dict[str, Any],
        inlined: bool,
    ) -> Any:
        """Return the result of a call of a function that is traced on its own, or run in place.

        Raises:
            TraceError: it does what is not traced, or calls itself.
        """
        source = source_of(function)
        variables = source.bind(arguments, keywords)
        if inlined and source.is_straight and self._depth < _DEPTH:
            return self._run_in_place(graph, source, variables)
        leaves, traced = self._find_traced(graph, source, variables, inlined)
        graph.has_allocations |= traced.function.graph.has_allocations
        graph.has_wide_vectors |= inlined and traced.function.graph.has_wide_vectors
        results = graph.append(
            "call", numbers_of(leaves), traced.function.result_kinds, traced.function
        )
        inner = zip(results, traced.function.block.results, strict=True)
        least = traced.function.graph.least
        graph.least.update(
            (result.number, 0) for result, number in inner if least.get(number, -1) >= 0
        )
        return traced.result(iter(results))

    def function_of(
        self, graph: Graph, function: types.FunctionType, arguments: list[Any]
    ) -> tuple[tuple[Any, ...], tuple[Value, ...], Traced]:
        """Return (arguments of a call with defaults, their leaves, the function traced for it).

        Raises:
            TraceError: it does what is not traced, or calls itself.
        """
        source = source_of(function)
        variables = source.bind(arguments, {})
        return tuple(variables.values()), *self._find_traced(graph, source, variables, False)

    def _find_traced(
        self, graph: Graph, source: Source, variables: dict[str, Any], inlined: bool
    ) -> tuple[tuple[Value, ...], Traced]:
        tree = tuple([self.as_argument(graph, x) for x in variables.values()])
        leaves, key, rebuild = take_apart(tree, graph, not inlined)
        whole = source.function, inlined, key
        traced = self._own.get(whole) or _TRACED.get(whole)
        if traced is None:
            if whole in self._under_way:
                raise TraceError(f"{source.name} calls itself: recursion is not traced")
            self._under_way.add(whole)
            traced = self._trace(
                source, tuple(variables), rebuild, tuple(leaf.kind for leaf in leaves), inlined
            )
            self._keep(whole, traced)
        self.functions |= traced.functions
        return tuple(leaves), traced

    def _run_in_place(self, graph: Graph, source: Source, variables: dict[str, Any]) -> Any:
        """Return the result of a short function without branches, inlined into the caller."""
        self.functions.add(source.function)
        arrays = {
            name: self.as_argument(graph, x)
            for name, x in variables.items()
            if isinstance(x, _ARRAYS)
        }
        outer, graph.structural = (
            graph.structural,
            _is_of_packages(source.function.__code__.co_filename),
        )
        self._depth += 1
        try:
            outcome = run(Frame(graph, self, source, variables | arrays, {}), source.body)
        finally:
            self._depth -= 1
            graph.structural = outer
        return outcome.value if isinstance(outcome, Returned) else None

    def _trace(
        self,
        source: Source,
        names: tuple[str, ...],
        rebuild: Rebuild,
        kinds: tuple[Kind, ...],
        inlined: bool,
    ) -> Traced:
        result_kinds: dict[int, Kind] = {}
        outer, self.functions = self.functions, {source.function}
        while True:
            try:
                graph, block, result = self._trace_block(
                    source, names, rebuild, kinds, result_kinds
                )
            except ResultChange:
                continue
            inner, self.functions = self.functions, outer
            graph.close()
            variant = getattr(source.function, "without_lanes", None)
            other = (
                self._trace(source_of(variant), names, rebuild, kinds, inlined).function
                if variant
                else None
            )
            name = f"{source.name.strip('<>')}.{next(_NUMBERS)}"
            return Traced(
                Function(name, source.function, graph, block, inlined, other), result, inner
            )

    def _keep(self, whole: Any, traced: Traced) -> None:
        if all(_is_of_packages(function.__code__.co_filename) for function in traced.functions):
            if len(_TRACED) >= _MOST:
                _TRACED.clear()
            _TRACED[whole] = traced
        self._own[whole] = traced

    def _trace_block(
        self,
        source: Source,
        names: tuple[str, ...],
        rebuild: Rebuild,
        kinds: tuple[Kind, ...],
        result_kinds: dict[int, Kind],
    ) -> tuple[Graph, Block, Rebuild]:
        graph = Graph()
        graph.structural = _is_of_packages(source.function.__code__.co_filename)
        results: list[Rebuild] = []

        def values(*symbols: Value) -> tuple[Value, ...]:
            variables = dict(zip(names, rebuild(iter(symbols)), strict=True))
            outcome = run(Frame(graph, self, source, variables, result_kinds), source.body)
            leaves, result = split(
                outcome.value if isinstance(outcome, Returned) else None, graph, False
            )
            results.append(result)
            return tuple(leaves)

        return graph, graph.trace_block(values, kinds), results[0]

    def as_argument(self, graph: Graph, x: Any) -> Any:
        """Return an argument of tuples, with constant arrays in memory."""
        if isinstance(x, tuple):
            parts = [self.as_argument(graph, part) for part in x]
            return x if all(map(is_, parts, x)) else rebuilt(x, parts)
        if isinstance(x, list):
            return tuple([self.as_argument(graph, part) for part in x])
        return self.array_of(graph, x) if isinstance(x, np.ndarray) else x

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
        if any(
            isinstance(i, Value)
            or (isinstance(i, slice) and any(isinstance(x, Value) for x in (i.start, i.stop)))
            for i in indices
        ):
            return array_symbols.get_item(self.array_of(graph, array), index)
        part = array[index]
        return part if isinstance(part, np.ndarray) else part.item()


def trace_on_arrays(function: types.FunctionType, sizes: tuple[int | None, ...]) -> Function:
    """Return a function traced for arguments: reals, where a size is None, or arrays of reals.

    An array has as many reals as its size says.

    Raises:
        TraceError: it does what is not traced.
    """
    graph, calls, real = Graph(), Calls(), np.dtype(float)

    def run_on(*symbols: Value) -> tuple[Value, ...]:
        pairs = zip(symbols, sizes, strict=True)
        arguments = [
            x if n is None else ArraySymbol(x, 0, real, (n,), (real.itemsize,)) for x, n in pairs
        ]
        calls.call_traced(graph, function, arguments, {}, True)
        return ()

    kinds = tuple(Kind.REAL if n is None else Kind.ARRAY for n in sizes)
    return Function("entry", function, graph, graph.trace_block(run_on, kinds), False)


def resolve(function: Any, arguments: list[Any]) -> tuple[Any, bool]:
    """Return (the Python function that a call runs, whether it is inlined into its callers)."""
    inlined = getattr(function, "inlined", True)
    if hasattr(function, "dispatch"):
        implementation = function.dispatch(type_of(arguments[0]))
        return implementation, inlined and getattr(implementation, "inlined", True)
    return getattr(function, "py_func", function), inlined


@cache
def _is_of_packages(file: str) -> bool:
    return SOURCES_AT_IMPORT.includes(file)


def _handler_of(function: Any) -> Any:
    try:
        return HANDLERS.get(function)
    except TypeError:  # it has no hash
        return None


def _is_traced(function: Any) -> bool:
    """Return whether a function is traced from its source."""
    return isinstance(function, types.FunctionType) and not (function.__module__ or "").startswith(
        _LIBRARY_SOURCES
    )


def _call_untraced(function: Any, arguments: list[Any], keywords: dict[str, Any]) -> Any:
    """Return the result of a function or class that Python calls while tracing."""
    owner = getattr(function, "__self__", None)
    module = getattr(function, "__module__", None) or type(owner).__module__
    of_tuple = any(
        issubclass(cls, tuple) for cls in (function, owner, type(owner)) if isinstance(cls, type)
    )
    if of_tuple or module.startswith("crane_sim.tracing"):
        return function(*arguments, **keywords)
    known = not _has_symbols((*arguments, *keywords.values()))
    if not known or module not in _LIBRARIES or isinstance(owner, list | dict | set | bytearray):
        raise TraceError(f"{_name_of(function)} is not traced")
    return function(*arguments, **keywords)


def _name_of(function: Any) -> str:
    name = (
        getattr(function, "__qualname__", None)
        or getattr(function, "__name__", None)
        or repr(function)
    )
    module = getattr(function, "__module__", None)
    return name if module in (None, "builtins") else f"{module}.{name}"


def _has_symbols(tree: Any) -> bool:
    if isinstance(tree, tuple | list):
        return any(map(_has_symbols, tree))
    return isinstance(tree, Value | ArraySymbol | RecordSymbol)


def take_apart(tree: Any, graph: Graph, integers: bool) -> tuple[list[Value], Any, Rebuild]:
    """Return (leaves of arguments, the rest of their structure, what makes them of leaves).

    Args:
        tree: of the arguments; floats that are known are leaves as well.
        graph: of its symbols.
        integers: so are integers.
    """
    if isinstance(tree, tuple):
        place = id(tree), integers
        known = graph.taken_apart.get(place)
        if known is None or not graph.are_defined(known[1][0]):
            known = graph.taken_apart[place] = tree, _take_tuple_apart(tree, graph, integers)
        return known[1]
    if isinstance(tree, ArraySymbol | RecordSymbol):
        leaves = [base_address(graph, tree), *sizes_of(tree)]
        sizes = () if isinstance(tree, RecordSymbol) else (*tree.shape, *tree.strides)
        key = type(tree), str(tree.dtype), tuple(None if isinstance(x, Value) else x for x in sizes)
        return leaves, key, lambda it: with_address(tree, next(it), it)
    if isinstance(tree, Value):
        natural = arithmetic.is_natural(tree)
        return (
            [graph.lift(tree, tree.kind)],
            (tree.kind, natural),
            _take_natural if natural else next,
        )
    if isinstance(tree, float) or (integers and type(tree) is int):
        value, natural = (
            graph.constant(tree, arithmetic.number_kind(tree)),
            type(tree) is int and tree >= 0,
        )
        return [value], (value.kind, natural), _take_natural if natural else next
    return [], (type(tree), tree), lambda it: tree


def _take_tuple_apart(
    tree: tuple[Any, ...], graph: Graph, integers: bool
) -> tuple[list[Value], Any, Rebuild]:
    parts = [take_apart(part, graph, integers) for part in tree]
    leaves = [leaf for part, _, _ in parts for leaf in part]
    key = type(tree), *(part_key for _, part_key, _ in parts)
    return leaves, key, lambda it: rebuilt(tree, [rebuild(it) for _, _, rebuild in parts])


def _take_natural(leaves: Iterator[Value]) -> Value:
    """Return the next leaf, an integer that is not negative."""
    leaf = next(leaves)
    leaf.graph.least[leaf.number] = 0
    return leaf
