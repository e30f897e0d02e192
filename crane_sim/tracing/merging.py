"""Variables after a branch or a loop: trees of numbers and objects, made equal in structure."""

from collections.abc import Callable, Iterator
from typing import Any

from crane_sim.tracing.arithmetic import RANK, common_kind, convert, is_number, number_kind
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import rebuilt

Rebuild = Callable[[Iterator[Value]], Any]
"""A function that makes a tree of leaves that it takes from an iterator."""


class Undefined:
    """A variable that has no value here."""

    def __repr__(self) -> str:
        return "undefined"


UNDEFINED = Undefined()


class KindChange(TraceError):
    """A number of a loop's state needs another kind than it had at first."""

    def __init__(self, index: int, kind: Kind) -> None:
        super().__init__(f"number {index} becomes {kind.name}")
        self.index, self.kind = index, kind


def base_address(graph: Graph, part: ArraySymbol | RecordSymbol) -> Value:
    """Return the address of the first element."""
    if not part.offset:
        return part.address
    return graph.append("move", (part.address.number,), (Kind.ARRAY,), part.offset)[0]


def with_address(part: Any, address: Value, leaves: Iterator[Value]) -> Any:
    """Return an array or a record at an address; an iterator gives sizes that are symbols."""
    if isinstance(part, RecordSymbol):
        return RecordSymbol(address, 0, part.dtype)
    sizes = [next(leaves) if isinstance(x, Value) else x for x in (*part.shape, *part.strides)]
    n = len(part.shape)
    address.graph.least.update((x.number, 0) for x in sizes[:n] if isinstance(x, Value))
    return ArraySymbol(address, 0, part.dtype, tuple(sizes[:n]), tuple(sizes[n:]))


def sizes_of(part: Any) -> list[Value]:
    """Return the sizes and strides of an array that are symbols."""
    return (
        [x for x in (*part.shape, *part.strides) if isinstance(x, Value)]
        if isinstance(part, ArraySymbol)
        else []
    )


def known_sizes(part: Any) -> list[Any]:
    """Return the sizes and strides of an array, None for those that are symbols."""
    sizes = (*part.shape, None, *part.strides) if isinstance(part, ArraySymbol) else ()
    return [None if isinstance(x, Value) else x for x in sizes]


def split(tree: Any, graph: Graph, variable: bool) -> tuple[list[Value], Rebuild]:
    """Return (the leaves of a tree, what makes a tree like it).

    Args:
        tree: nested tuples of numbers, arrays and other objects.
        graph: of its symbols.
        variable: numbers that are known become leaves, too.
    """
    if isinstance(tree, tuple):
        parts = [split(part, graph, variable) for part in tree]
        leaves = [leaf for part, _ in parts for leaf in part]
        return leaves, lambda it: rebuilt(tree, [rebuild(it) for _, rebuild in parts])
    if isinstance(tree, ArraySymbol | RecordSymbol):
        leaves = [base_address(graph, tree), *sizes_of(tree)]
        return leaves, lambda it: with_address(tree, next(it), it)
    if isinstance(tree, Value) or (variable and is_number(tree)):
        return [convert(graph, tree, number_kind(tree))], lambda it: next(it)
    return [], lambda it: tree


def fit(
    tree: Any, like: Any, graph: Graph, kinds: Iterator[Kind], index: list[int], what: str
) -> list[Value]:
    """Return the leaves of a tree as those of `split(like, graph, True)`, of these kinds.

    Raises:
        KindChange: a leaf needs another kind.
        TraceError: the trees differ in structure.
    """
    if isinstance(like, tuple):
        if type(tree) is not type(like) or len(tree) != len(like):
            raise TraceError(
                f"{what} changes the structure of a variable: {_describe(like)}, then "
                f"{_describe(tree)}"
            )
        return [
            leaf
            for a, b in zip(tree, like, strict=True)
            for leaf in fit(a, b, graph, kinds, index, what)
        ]
    if isinstance(like, ArraySymbol | RecordSymbol):
        return _fit_array(tree, like, graph, kinds, index, what)
    if is_number(like):
        return [_fit_number(tree, graph, next(kinds), index, what)]
    if tree is not like and tree != like:
        raise TraceError(f"{what} changes {_describe(like)} into {_describe(tree)}")
    return []


def _fit_array(
    tree: Any,
    like: ArraySymbol | RecordSymbol,
    graph: Graph,
    kinds: Iterator[Kind],
    index: list[int],
    what: str,
) -> list[Value]:
    """Return address and sizes of an array or a record, which has the type and shape of `like`."""
    if (
        type(tree) is not type(like)
        or tree.dtype != like.dtype
        or known_sizes(tree) != known_sizes(like)
    ):
        raise TraceError(f"{what} changes the type or the shape of an array")
    leaves = [base_address(graph, tree), *sizes_of(tree)]
    for _ in leaves:
        next(kinds)
    index[0] += len(leaves)
    return leaves


def _fit_number(tree: Any, graph: Graph, kind: Kind, index: list[int], what: str) -> Value:
    """Return a number as one of this kind."""
    if not is_number(tree):
        raise TraceError(f"{what} changes a number into {_describe(tree)}")
    common = max(kind, number_kind(tree), key=RANK.__getitem__)
    if common is not kind:
        raise KindChange(index[0], common)
    index[0] += 1
    return convert(graph, tree, kind)


def _describe(tree: Any) -> str:
    return type(tree).__name__ if isinstance(tree, tuple | Value | ArraySymbol) else repr(tree)


class Merge:
    """What two sides of a branch result in, tree by tree.

    Attributes:
        pairs: (leaf of one side, of the other one, kind that both are converted to).
    """

    def __init__(self) -> None:
        """Begin without leaves."""
        self.pairs: list[tuple[Any, Any, Kind]] = []

    def join(self, a: Any, b: Any) -> Rebuild:
        """Return what makes the merged tree of the merged leaves.

        Raises:
            TraceError: the trees differ in structure.
        """
        if a is b:
            return lambda it: a
        if a is UNDEFINED or b is UNDEFINED:
            return lambda it: UNDEFINED
        if isinstance(a, tuple) and type(a) is type(b) and len(a) == len(b):
            parts = [self.join(x, y) for x, y in zip(a, b, strict=True)]
            return lambda it: rebuilt(a, [rebuild(it) for rebuild in parts])
        if isinstance(a, ArraySymbol | RecordSymbol) and type(a) is type(b) and a.dtype == b.dtype:
            return self._join_memory(a, b)
        if is_number(a) and is_number(b):
            return self._join_numbers(a, b)
        if not isinstance(a, Value) and not isinstance(b, Value) and type(a) is type(b) and a == b:
            return lambda it: a
        raise TraceError(f"the sides of a branch differ: {_describe(a)} and {_describe(b)}")

    def _join_numbers(self, a: Any, b: Any) -> Rebuild:
        if isinstance(a, Value) and isinstance(b, Value):
            if a.number == b.number:
                return lambda it: a
        elif (
            not isinstance(a, Value)
            and not isinstance(b, Value)
            and type(a) is type(b)
            and repr(a) == repr(b)
        ):
            return lambda it: a
        self.pairs.append((a, b, common_kind(a, b)))
        return lambda it: next(it)

    def _join_memory(self, a: Any, b: Any) -> Rebuild:
        self.pairs.append((a, b, Kind.ARRAY))
        if isinstance(a, RecordSymbol):
            return lambda it: RecordSymbol(next(it), 0, a.dtype)
        n = len(a.shape)
        if len(b.shape) != n:
            raise TraceError("the sides of a branch have arrays of different dimensions")
        parts = [
            self.join(x, y)
            for x, y in zip((*a.shape, *a.strides), (*b.shape, *b.strides), strict=True)
        ]

        def rebuild(it: Iterator[Value]) -> ArraySymbol:
            address = next(it)
            sizes = [part(it) for part in parts]
            address.graph.least.update((x.number, 0) for x in sizes[:n] if isinstance(x, Value))
            return ArraySymbol(address, 0, a.dtype, tuple(sizes[:n]), tuple(sizes[n:]))

        return rebuild


def leaf_value(graph: Graph, x: Any, kind: Kind) -> Value:
    """Return a leaf of a `Merge` as a value."""
    return base_address(graph, x) if kind is Kind.ARRAY else convert(graph, x, kind)
