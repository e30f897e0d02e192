"""A traced computation: instructions in single-assignment form, and symbols for their results."""

from collections.abc import Callable
from contextlib import contextmanager
from typing import Any, NamedTuple

from crane_sim.tracing.instructions import (
    COMMUTATIVE,
    IMPURE,
    Block,
    Instruction,
    Kind,
    Number,
)
from crane_sim.tracing.trace_error import TraceError


class OpenBlock(NamedTuple):
    """A block that may be recorded further."""

    instructions: list[Instruction]
    known: dict[Any, tuple[int, ...]]  # results of operations that it has
    number: int


_PYTHON_TYPES: dict[Kind, Callable[[Any], Number]] = {
    Kind.REAL: float,
    Kind.INTEGER: int,
    Kind.BOOLEAN: bool,
    Kind.WORD: int,
    Kind.TANGENT: float,
}


class Graph:
    """Records instructions; a value that an enclosing block has computed is not computed again."""

    def __init__(self) -> None:
        """Begin with an empty block."""
        self.kinds: list[Kind] = []
        self._blocks: list[list[Instruction]] = [[]]
        self._known: list[dict[Any, tuple[int, ...]]] = [{}]
        self._owners: list[int] = []  # number of the block that has a value
        self._count = 1  # of blocks
        self._open = [0]  # numbers of the blocks that are being recorded
        self.has_allocations = False  # by itself, or in what it calls
        self.has_wide_vectors = False  # the widest of the processor
        self.simd_loops: set[int] = set()  # whose turns are independent, by their first results
        self.least: dict[int, int] = {}  # what integers are known not to be less than
        self.taken_apart: dict[Any, Any] = {}  # tuples with what they consist of, see `calls`
        # the integers 0 and 1 are structure where they meet a real, see `arithmetic`
        self.structural = False

    def close(self) -> None:
        """Forget what only further recording needs: most of what a trace takes in memory."""
        results = self._blocks, self._known, self._owners, self.taken_apart
        for each in results:
            each.clear()

    @property
    def is_in_a_block(self) -> bool:
        """Whether what is noted now may run several times, or not at all."""
        return len(self._open) > 2

    def new_value(self, kind: Kind) -> "Value":
        """Return a value that no instruction computes: a parameter of a block."""
        self.kinds.append(kind)
        self._owners.append(self._open[-1])
        return Value(self, len(self.kinds) - 1)

    def new_slot(self, count: int) -> "Value":
        """Return the address of memory for `count` numbers of 8 bytes, the whole function's."""
        self.kinds.append(Kind.ARRAY)
        self._owners.append(self._open[1])
        value = Value(self, len(self.kinds) - 1)
        self._blocks[1].insert(0, Instruction("slot", (), (value.number,), count))
        return value

    def constant(self, number: Number, kind: Kind = Kind.REAL) -> "Value":
        """Return a constant."""
        literal = _PYTHON_TYPES[kind](number)
        (value,) = self.append("constant", (), (kind,), literal)
        if kind is Kind.INTEGER:
            self.least[value.number] = int(number)
        return value

    def append(
        self,
        operation: str,
        arguments: tuple[int, ...],
        kinds: tuple[Kind, ...],
        literal: Any = None,
    ) -> Any:
        """Return the values (as a tuple) that an operation on values results in.

        Raises:
            TraceError: it is not defined for a value, or a value is of a block that has ended.
        """
        self.check_defined(operation, arguments)
        if operation in COMMUTATIVE:
            arguments = tuple(sorted(arguments))
        key = operation, arguments, repr(literal) if operation == "constant" else literal, kinds
        if operation not in IMPURE:
            for known in reversed(self._known):
                if key in known:
                    return tuple(Value(self, number) for number in known[key])
        values = tuple(self.new_value(kind) for kind in kinds)
        numbers = tuple(value.number for value in values)
        self._blocks[-1].append(Instruction(operation, arguments, numbers, literal))
        if operation not in IMPURE:
            self._known[-1][key] = numbers
        return values

    def are_defined(self, values: list["Value"]) -> bool:
        """Return whether values exist where it is recorded now."""
        owners, opened = self._owners, self._open
        return all([owners[value.number] in opened for value in values])

    def check_defined(self, operation: str, arguments: tuple[int, ...]) -> None:
        """Raise a TraceError where an argument may not exist."""
        for number in arguments:
            if self._owners[number] not in self._open:
                raise TraceError(
                    f"{operation}: a value of a branch or loop is used outside, where it may not "
                    "exist"
                )

    def trace_block(
        self, function: Callable[..., tuple["Value", ...]], kinds: tuple[Kind, ...] = ()
    ) -> Block:
        """Return the block of what a function of values of these kinds computes."""
        with self._inner_block() as instructions:
            parameters = tuple(self.new_value(kind) for kind in kinds)
            results = numbers_of(function(*parameters))
            self.check_defined("result", results)
        return Block(instructions, numbers_of(parameters), results)

    def new_block(self) -> "OpenBlock":
        """Return an empty block, to be recorded."""
        self._count += 1
        return OpenBlock([], {}, self._count - 1)

    @contextmanager
    def recording(self, block: "OpenBlock") -> Any:
        """Record what is noted meanwhile at the end of a block."""
        self._blocks.append(block.instructions)
        self._known.append(block.known)
        self._open.append(block.number)
        try:
            yield
        finally:
            self._blocks.pop()
            self._known.pop()
            self._open.pop()

    @contextmanager
    def _inner_block(self) -> Any:
        block = self.new_block()
        with self.recording(block):
            yield block.instructions

    def lift(self, number: Any, kind: Kind = Kind.REAL) -> "Value":
        """Return a value as it is, a number as a constant of this kind.

        Raises:
            TraceError: neither, of another kind, or a value of another function's trace.
        """
        if isinstance(number, Value):
            return self._own(number, kind)
        real = kind is Kind.REAL and isinstance(number, float)
        if real or kind_of(number) is kind or (kind is Kind.REAL and hasattr(number, "__index__")):
            return self.constant(number, kind)
        raise TraceError(
            f"{number!r} is neither a {kind.name.lower()} nor a value of the traced function"
        )

    def _own(self, value: "Value", kind: Kind) -> "Value":
        if value.graph is not self:
            raise TraceError("a value of another traced function: make it an argument")
        if value.kind is not kind:
            raise TraceError(
                f"a value of kind {value.kind.name} where one of kind {kind.name} is needed"
            )
        return value


def numbers_of(values: tuple["Value", ...]) -> tuple[int, ...]:
    """Return the numbers of values."""
    return tuple(value.number for value in values)


class Value:
    """A symbol: what an instruction will have computed; its operators are of `arithmetic`."""

    __slots__ = ("graph", "number")
    __array_ufunc__ = None  # NumPy's floats leave arithmetic to this class
    __hash__ = None  # type: ignore[assignment]  # equality is an instruction

    def __init__(self, graph: Graph, number: int) -> None:
        """Name the value of this number."""
        self.graph, self.number = graph, number

    @property
    def kind(self) -> Kind:
        """Return what the value is."""
        return self.graph.kinds[self.number]

    def __bool__(self) -> bool:
        raise TraceError("a condition on a traced number")

    def __float__(self) -> float:
        raise TraceError("a traced number is no float")

    __index__ = __int__ = __float__  # type: ignore[assignment]


def kind_of(number: Any) -> Kind:
    """Return what a number or value is."""
    if isinstance(number, Value):
        return number.kind
    if isinstance(number, bool):
        return Kind.BOOLEAN
    return Kind.INTEGER if hasattr(number, "__index__") else Kind.REAL
