"""One call while tracing: its variables, branches, and returns from inside loops."""

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from itertools import count
from typing import Any, Protocol

from crane_sim.tracing.arithmetic import combine
from crane_sim.tracing.graph import Graph, OpenBlock, Value, numbers_of
from crane_sim.tracing.instructions import Block, Kind
from crane_sim.tracing.merging import UNDEFINED, KindChange, Merge, Rebuild, fit, leaf_value, split
from crane_sim.tracing.scopes import Source
from crane_sim.tracing.trace_error import TraceError

RUNS, BREAKS, RETURNS, CONTINUES = range(4)
"""How statements end inside a loop, or inside a branch of which one side may return, as a
number."""
CODES = {Kind.REAL: "f8", Kind.INTEGER: "i8", Kind.WORD: "u8", Kind.BOOLEAN: "b1", Kind.ARRAY: "p8"}
"""Types in memory of numbers and addresses that are kept in eight bytes each."""


def read_leaves(address: Value, kinds: Iterable[Kind], first: int = 0) -> list[Value]:
    """Return consecutive numbers and addresses, eight bytes each, from byte `first` on."""
    append, places = address.graph.append, count(first, 8)
    return [
        append("read", (address.number,), (kind,), (next(places), CODES[kind]))[0] for kind in kinds
    ]


def write_leaves(address: Value, leaves: Iterable[Value], first: int = 0) -> None:
    """Keep numbers and addresses one behind the other, eight bytes each, from byte `first` on."""
    for place, leaf in zip(count(first, 8), leaves):  # noqa: B905 # places without end
        address.graph.append("write", (leaf.number, address.number), (), (place, CODES[leaf.kind]))


class Returned:
    """The end of a function, with what it returns."""

    def __init__(self, value: Any) -> None:
        self.value = value


class ResultChange(TraceError):
    """What a function returns needs other kinds of numbers: it is traced again."""


class Caller(Protocol):
    """What traces the functions that a function calls."""

    def call(
        self, graph: Graph, function: Any, arguments: list[Any], keywords: dict[str, Any]
    ) -> Any:
        """Return the result of a call."""
        ...

    def constant_array(self, graph: Graph, array: Any, index: Any) -> Any:
        """Return what a constant array has at an index."""
        ...


class Frame:
    """The variables of one call, and where returns that end with `RETURNS` store results."""

    def __init__(
        self,
        graph: Graph,
        calls: Caller,
        source: Source,
        variables: dict[str, Any],
        result_kinds: dict[int, Kind],
    ) -> None:
        """Begin with the parameters, and with kinds of stored results in place of their own."""
        self.graph, self.calls, self.source, self.variables = graph, calls, source, variables
        self.depth = 0  # of loops and branches in which a return stores its result
        self._result: tuple[Rebuild, list[Kind], Value, Any] | None = None
        self._result_kinds = result_kinds

    @contextmanager
    def nested(self) -> Iterator[None]:
        """Have returns store their results meanwhile; the variables become those of before."""
        before = self.variables
        self.depth += 1
        try:
            yield
        finally:
            self.depth -= 1
            self.variables = before

    # what it returns

    def leave(self, value: Any) -> Any:
        """Return how a return statement ends; the result is stored where that is a number.

        Raises:
            ResultChange: results stored before are of other kinds.
        """
        if not self.depth:
            return Returned(value)
        graph = self.graph
        if self._result is None:
            leaves, rebuild = split(value, graph, True)
            kinds = [self._result_kinds.get(i, leaf.kind) for i, leaf in enumerate(leaves)]
            self._result = rebuild, kinds, graph.new_slot(len(leaves)), value
        _, kinds, slot, like = self._result
        try:
            leaves = fit(value, like, graph, iter(kinds), [0], "a return")
        except KindChange as change:
            self._result_kinds[change.index] = change.kind
            raise ResultChange(str(change)) from change
        write_leaves(slot, leaves)
        return RETURNS

    def _stored_result(self) -> Any:
        assert self._result is not None
        rebuild, kinds, slot, _ = self._result
        return rebuild(iter(read_leaves(slot, kinds)))

    def finish(self, code: Any, following: Callable[[], Any]) -> Any:
        """Return a function's outcome after statements with `code`; what follows may not run."""
        if self._result is None or (not isinstance(code, Value) and code != RETURNS):
            return following()
        if not isinstance(code, Value):
            return Returned(self._stored_result())

        def rest() -> Any:
            outcome = following()
            return outcome.value if isinstance(outcome, Returned) else None

        return Returned(self.branch(combine("equal", code, RETURNS), self._stored_result, rest))

    def stored(self) -> Returned:
        """Return the outcome of a function that ends with a result that is stored."""
        return Returned(self._stored_result())

    @property
    def has_stored(self) -> bool:
        """Return whether a return has stored its result."""
        return self._result is not None

    # branches

    def branch(
        self, condition: Value, then: Callable[[], Any], otherwise: Callable[[], Any]
    ) -> Any:
        """Return what the side that runs results in; so do the variables.

        Raises:
            TraceError: the results of the sides differ in structure.
        """
        merge, rebuilds, sides = self._record_sides(condition, then, otherwise)
        rebuild = merge.join(sides[0][1], sides[1][1])
        leaves = self._close(merge, condition, sides)
        self._take_variables(rebuilds, leaves)
        return rebuild(leaves)

    def branch_variables(
        self, condition: Value, then: Callable[[], Any], otherwise: Callable[[], Any]
    ) -> None:
        """Have the variables become what the side that runs makes of them."""
        merge, rebuilds, sides = self._record_sides(condition, then, otherwise)
        self._take_variables(rebuilds, self._close(merge, condition, sides))

    def _record_sides(
        self, condition: Value, *functions: Callable[[], Any]
    ) -> tuple[Merge, dict[str, Any], list[Any]]:
        graph, before, sides, variables = self.graph, self.variables, [], []
        try:
            for function in functions:
                block, self.variables = graph.new_block(), dict(before)
                with graph.recording(block):
                    result = function()
                sides.append((block, result))
                variables.append(self.variables)
        finally:
            self.variables = before
        merge = Merge()
        return merge, _join_variables(merge, *variables), sides

    def _take_variables(self, rebuilds: dict[str, Any], leaves: Iterator[Value]) -> None:
        self.variables = {
            name: make(leaves) if callable(make) else make[0] for name, make in rebuilds.items()
        }

    def _close(
        self, merge: Merge, condition: Value, sides: list[tuple[OpenBlock, Any]]
    ) -> Iterator[Value]:
        graph, kinds = self.graph, tuple(kind for *_, kind in merge.pairs)
        blocks = []
        for side, (block, _) in enumerate(sides):
            with graph.recording(block):
                leaves = tuple(leaf_value(graph, pair[side], pair[2]) for pair in merge.pairs)
            blocks.append(Block(block.instructions, (), numbers_of(leaves)))
        if not kinds and not any(block.instructions for block in blocks):
            return iter(())
        return iter(graph.append("branch", (condition.number,), kinds, tuple(blocks)))


def _join_variables(merge: Merge, ours: dict[str, Any], theirs: dict[str, Any]) -> dict[str, Any]:
    """Return what makes variables of leaves: a function, or (the value,) where sides share it.

    A variable whose values differ in structure is undefined: an error only where it is read.
    """
    rebuilds: dict[str, Any] = {}
    for name in {**ours, **theirs}:
        mine, other = ours.get(name, UNDEFINED), theirs.get(name, UNDEFINED)
        if mine is other:
            rebuilds[name] = (mine,)
            continue
        count = len(merge.pairs)
        try:
            rebuilds[name] = merge.join(mine, other)
        except TraceError:
            del merge.pairs[count:]
            rebuilds[name] = (UNDEFINED,)
    return rebuilds
