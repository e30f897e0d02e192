"""Loops while tracing: known turns one after the other, unknown ones as a loop in the code."""

import ast
from collections.abc import Callable
from typing import Any

import numpy as np

from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol
from crane_sim.tracing.expressions import assign, condition_of, evaluate_iterable
from crane_sim.tracing.frame import CONTINUES, RUNS, Frame
from crane_sim.tracing.graph import Value, numbers_of
from crane_sim.tracing.instructions import Block, Kind
from crane_sim.tracing.merging import UNDEFINED, KindChange, fit, split
from crane_sim.tracing.ranges import Range, SimdRange
from crane_sim.tracing.scopes import assigned_names, has_jump, has_return, names_read_later
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import rebuilt

UNROLLED = 16
"""Turns of a loop of known length up to which it is unrolled."""


class _Elements(Range):
    """The elements of an array."""

    def __init__(self, array: ArraySymbol) -> None:
        super().__init__(array.shape[0])
        self.array = array

    def value(self, index: Any) -> Any:
        """Return the element at an index."""
        return array_symbols.get_item(self.array, index)


class _LateVariable(Exception):
    """A variable that a loop assigns first is read behind the loop: it needs a value before it."""

    def __init__(self, name: str, value: Any) -> None:
        super().__init__(name)
        self.name, self.value = name, value


def turns_of(frame: Frame, loop: ast.For | ast.While) -> Any:
    """Return what a loop goes over: a list, `range` or `Range`; None for one by a condition.

    Raises:
        TraceError: it is nothing of this.
    """
    if isinstance(loop, ast.While):
        return None
    iterable = evaluate_iterable(frame, loop.iter)
    if isinstance(iterable, ArraySymbol):
        return _Elements(iterable)
    if isinstance(iterable, np.ndarray) and iterable.ndim == 1:
        return iterable.tolist()
    if isinstance(iterable, tuple | list):
        return list(iterable)
    if isinstance(iterable, range | Range):
        return iterable
    raise TraceError(
        f"a loop over {'a number' if isinstance(iterable, Value) else type(iterable).__name__} is "
        "not traced"
    )


def known_turns(loop: ast.For | ast.While, turns: Any) -> list[Any] | None:
    """Return the values of a loop's variable, None for one that is a loop in the code, too."""
    if isinstance(turns, list):
        return turns
    if isinstance(turns, range) and len(turns) <= UNROLLED and not has_jump(loop):
        return list(turns)
    return None


def trace_loop(frame: Frame, loop: ast.For | ast.While, turns: Any, turn: Callable[[], Any]) -> Any:
    """Record a loop; return how it ended, None for a loop that only ends by its condition.

    Args:
        frame: of its variables.
        loop: its statement.
        turns: what it goes over.
        turn: runs its body, and returns how that ends.
    """
    steps = Range(turns.start, turns.stop, turns.step) if isinstance(turns, range) else turns
    names = [
        name
        for name in assigned_names(loop)
        if frame.variables.get(name, UNDEFINED) is not UNDEFINED
    ]
    late: dict[str, Any] = {}
    promoted: dict[int, Kind] = {}
    while True:
        try:
            return _Recorder(frame, loop, steps, [*names, *late], late, promoted).record(turn)
        except KindChange as change:
            promoted[change.index] = change.kind
        except _LateVariable as variable:
            late[variable.name] = variable.value


class _Recorder:
    """Records one loop; its state: some variables, a range's index, and how the last turn ended."""

    def __init__(
        self,
        frame: Frame,
        loop: Any,
        steps: Range | None,
        names: list[str],
        late: dict[str, Any],
        promoted: dict[int, Kind],
    ) -> None:
        self._frame, self._loop, self._steps, self._names = frame, loop, steps, names
        self._exits = has_return(loop) or has_jump(loop, ast.Break)
        before = frame.variables
        values = tuple(late[name] if name in late else before[name] for name in names)
        self._state = values, steps.first if steps else None, RUNS if self._exits else None
        leaves, self._rebuild = split(self._state, frame.graph, True)
        self._kinds = [promoted.get(i, leaf.kind) for i, leaf in enumerate(leaves)]
        pairs = zip(leaves, self._kinds, strict=True)
        self._leaves = tuple(
            leaf if kind is Kind.ARRAY else arithmetic.convert(frame.graph, leaf, kind)
            for leaf, kind in pairs
        )

    def record(self, turn: Callable[[], Any]) -> Any:
        """Record the loop; return how it ended, None for one that only ends by its condition."""
        frame, before = self._frame, self._frame.variables
        with frame.nested():
            proceed = self._block(self._proceeds)
            body = self._block(lambda index, code: self._turn(turn, index))
        results = frame.graph.append(
            "loop", numbers_of(self._leaves), tuple(self._kinds), (proceed, body)
        )
        if isinstance(self._steps, SimdRange):
            frame.graph.simd_loops.add(results[0].number)
        after, _, code = self._rebuild(iter(results))
        frame.variables = {**before, **dict.fromkeys(assigned_names(self._loop), UNDEFINED)}
        frame.variables.update(zip(self._names, after, strict=True))
        return code

    def _block(self, function: Callable[[Any, Any], list[Value]]) -> Block:
        frame = self._frame
        graph, before = frame.graph, frame.variables
        block = graph.new_block()
        with graph.recording(block):
            parameters = tuple(graph.new_value(kind) for kind in self._kinds)
            values, index, code = self._rebuild(iter(parameters))
            if self._steps and self._steps.least is not None:
                graph.least[index.number] = self._steps.least
            frame.variables = {**before, **dict(zip(self._names, values, strict=True))}
            results = function(index, code)
        frame.variables = before
        return Block(block.instructions, numbers_of(parameters), numbers_of(tuple(results)))

    def _proceeds(self, index: Any, code: Any) -> list[Value]:
        condition = self._steps.includes(index) if self._steps else None
        if code is not None:
            runs = arithmetic.combine("equal", code, RUNS)
            condition = runs if condition is None else arithmetic.combine("both", condition, runs)
        if not self._steps:
            condition = self._continues(condition)
        return [arithmetic.convert(self._frame.graph, condition, Kind.BOOLEAN)]

    def _continues(self, runs: Any) -> Any:
        """Return whether a while loop's condition holds; not evaluated once the loop is left."""
        frame, test = self._frame, self._loop.test
        if runs is None:
            return condition_of(frame, test)
        return frame.branch(runs, lambda: condition_of(frame, test), lambda: False)

    def _turn(self, turn: Callable[[], Any], index: Any) -> list[Value]:
        frame, steps = self._frame, self._steps
        if steps:
            assign(frame, self._loop.target, steps.value(index))
        code = turn()
        code = arithmetic.choose(arithmetic.combine("equal", code, CONTINUES), RUNS, code)
        if steps:
            index = arithmetic.combine("add", index, steps.step)
        self._find_late_variables()
        values = tuple(frame.variables[name] for name in self._names)
        state = values, index, code if self._exits else None
        return fit(state, self._state, frame.graph, iter(self._kinds), [0], "a loop")

    def _find_late_variables(self) -> None:
        frame, later = self._frame, names_read_later(self._frame.source, self._loop)
        for name in assigned_names(self._loop):
            value = frame.variables.get(name, UNDEFINED)
            if name not in self._names and value is not UNDEFINED and name in later:
                raise _LateVariable(name, _zeros_like(value, name))


def _zeros_like(tree: Any, name: str) -> Any:
    """Return a tree of zeros of the same kinds, which are known."""
    if isinstance(tree, tuple):
        return rebuilt(tree, [_zeros_like(part, name) for part in tree])
    if isinstance(tree, Value):
        return {Kind.REAL: 0.0, Kind.BOOLEAN: False, Kind.WORD: np.uint64(0)}.get(tree.kind, 0)
    if isinstance(tree, ArraySymbol | RecordSymbol):
        raise TraceError(f"{name}, an array that a loop makes, is used behind the loop")
    return tree
