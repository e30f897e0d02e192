"""A traced computation: instructions in single-assignment form, and the symbols that note them.

A literal zero is structural: 0 x is 0 and x + 0 is x, as if x were finite. So what a model lacks, given as the literal
0, leaves nothing in the code; a float run computes the same numbers, up to the sign of zeros.
"""

from collections.abc import Callable
from contextlib import contextmanager
from typing import Any, NamedTuple

from crane_sim.tracing.instructions import (
    COMMUTATIVE,
    COMPARISONS,
    FOLDED,
    IMPURE,
    OPERANDS,
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
    """Records instructions. A value that an enclosing block has computed already is not computed again."""

    def __init__(self) -> None:
        """Begin with an empty block."""
        self.kinds: list[Kind] = []
        self.constants: dict[int, Number] = {}
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
        self.structural = False  # the integers 0 and 1 are structure where they meet a real, see `arithmetic`

    def close(self) -> None:
        """Forget what only further recording needs: most of what a trace takes in memory."""
        results = self._blocks, self._known, self._owners, self.taken_apart, self.constants
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
        """Return the address of memory for `count` numbers of eight bytes, that of the whole function."""
        self.kinds.append(Kind.ARRAY)
        self._owners.append(self._open[1])
        value = Value(self, len(self.kinds) - 1)
        self._blocks[1].insert(0, Instruction("slot", (), (value.number,), count))
        return value

    def constant(self, number: Number, kind: Kind = Kind.REAL) -> "Value":
        """Return a constant."""
        literal = _PYTHON_TYPES[kind](number)
        (value,) = self.append("constant", (), (kind,), literal)
        self.constants[value.number] = literal
        if kind is Kind.INTEGER:
            self.least[value.number] = int(number)
        return value

    def append(self, operation: str, arguments: tuple[int, ...], kinds: tuple[Kind, ...], literal: Any = None) -> Any:
        """Return the values (as a tuple) that an operation on values results in.

        Raises:
            TraceError: it is not defined for a value, or a value is of a block that has ended.
        """
        self.check_operands(operation, arguments)
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

    def check_operands(self, operation: str, arguments: tuple[int, ...]) -> None:
        """Raise a TraceError where an operation may not have these arguments."""
        allowed = OPERANDS.get(operation)
        for number in arguments:
            if self._owners[number] not in self._open:
                raise TraceError(f"{operation}: a value of a branch or loop is used outside, where it may not exist")
            if allowed and self.kinds[number] not in allowed:
                raise TraceError(f"{operation} is not defined for {self.kinds[number].name}")

    def trace_block(self, function: Callable[..., tuple["Value", ...]], kinds: tuple[Kind, ...] = ()) -> Block:
        """Return the block of what a function of values of these kinds computes."""
        with self._inner_block() as instructions:
            parameters = tuple(self.new_value(kind) for kind in kinds)
            results = numbers_of(function(*parameters))
            self.check_operands("result", results)
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
        raise TraceError(f"{number!r} is neither a {kind.name.lower()} nor a value of the traced function")

    def _own(self, value: "Value", kind: Kind) -> "Value":
        if value.graph is not self:
            raise TraceError("a value of another traced function: make it an argument")
        if value.kind is not kind:
            raise TraceError(f"a value of kind {value.kind.name} where one of kind {kind.name} is needed")
        return value


def numbers_of(values: tuple["Value", ...]) -> tuple[int, ...]:
    """Return the numbers of values."""
    return tuple(value.number for value in values)


class Value:
    """A symbol: what an instruction will have computed. Arithmetic on it notes instructions."""

    __slots__ = ("graph", "number")
    __array_ufunc__ = None  # NumPy's floats leave arithmetic to this class

    def __init__(self, graph: Graph, number: int) -> None:
        """Name the value of this number."""
        self.graph, self.number = graph, number

    @property
    def kind(self) -> Kind:
        """Return what the value is."""
        return self.graph.kinds[self.number]

    @property
    def literal(self) -> Number | None:
        """Return the number that a constant is, None for what is computed."""
        return self.graph.constants.get(self.number)

    def __add__(self, other: Any) -> "Value":
        return _binary("add", self, other)

    def __radd__(self, other: Any) -> "Value":
        return _binary("add", other, self)

    def __sub__(self, other: Any) -> "Value":
        return _binary("subtract", self, other)

    def __rsub__(self, other: Any) -> "Value":
        return _binary("subtract", other, self)

    def __mul__(self, other: Any) -> "Value":
        return _binary("multiply", self, other)

    def __rmul__(self, other: Any) -> "Value":
        return _binary("multiply", other, self)

    def __truediv__(self, other: Any) -> "Value":
        return _binary("divide", self, other)

    def __rtruediv__(self, other: Any) -> "Value":
        return _binary("divide", other, self)

    def __and__(self, other: Any) -> "Value":
        return _binary("both", self, other)

    def __rand__(self, other: Any) -> "Value":
        return _binary("both", other, self)

    def __lt__(self, other: Any) -> "Value":
        return _binary("less", self, other)

    def __le__(self, other: Any) -> "Value":
        return _binary("less_equal", self, other)

    def __gt__(self, other: Any) -> "Value":
        return _binary("less", other, self)

    def __ge__(self, other: Any) -> "Value":
        return _binary("less_equal", other, self)

    def __eq__(self, other: Any) -> Any:
        return _binary("equal", self, other) if _is_number(other) else NotImplemented

    def __ne__(self, other: Any) -> Any:
        return _binary("unequal", self, other) if _is_number(other) else NotImplemented

    __hash__ = None  # type: ignore[assignment]  # equality is an instruction

    def __neg__(self) -> "Value":
        return unary("negate", self)

    def __abs__(self) -> "Value":
        return unary("absolute", self)

    def __pow__(self, exponent: int) -> "Value":
        if exponent != 2:
            raise TraceError(f"a power of {exponent}: write it as products")
        return self * self

    def __bool__(self) -> bool:
        raise TraceError("a condition on a traced number: use `select`, or `branch`")

    def __float__(self) -> float:
        raise TraceError("a traced number is no float: use the functions of `tracing.operations`")

    __index__ = __int__ = __float__  # type: ignore[assignment]


def kind_of(number: Any) -> Kind:
    """Return what a number or value is."""
    if isinstance(number, Value):
        return number.kind
    if isinstance(number, bool):
        return Kind.BOOLEAN
    return Kind.INTEGER if hasattr(number, "__index__") else Kind.REAL


def unary(operation: str, value: Value) -> Value:
    """Return the result of an operation on one value, of its kind."""
    value.graph.check_operands(operation, (value.number,))
    if value.literal is not None and operation in FOLDED:
        return value.graph.constant(FOLDED[operation](value.literal), value.kind)
    return value.graph.append(operation, (value.number,), (value.kind,))[0]


def _is_number(x: Any) -> bool:
    return isinstance(x, Value | float | int)


def _binary(operation: str, a: Any, b: Any) -> Any:
    if not (_is_number(a) and _is_number(b)):
        return NotImplemented
    model = a if isinstance(a, Value) else b
    x, y = model.graph.lift(a, model.kind), model.graph.lift(b, model.kind)
    model.graph.check_operands(operation, (x.number, y.number))
    simple = _fold(operation, x, y)
    if simple is None and operation in _SIMPLER:
        simple = _SIMPLER[operation](x, y)
    if simple is not None:
        return simple
    kind = Kind.BOOLEAN if operation in COMPARISONS else x.kind
    return model.graph.append(operation, (x.number, y.number), (kind,))[0]


def _fold(operation: str, x: Value, y: Value) -> Value | None:
    if x.literal is None or y.literal is None or (operation == "divide" and y.literal == 0.0):
        return None
    kind = Kind.BOOLEAN if operation in COMPARISONS else x.kind
    return x.graph.constant(FOLDED[operation](x.literal, y.literal), kind)


def _simpler_sum(x: Value, y: Value) -> Value | None:
    if x.literal == 0.0:
        return y
    return x if y.literal == 0.0 else None


def _simpler_difference(x: Value, y: Value) -> Value | None:
    if y.literal == 0.0:
        return x
    return -y if x.literal == 0.0 else None


def _simpler_product(x: Value, y: Value) -> Value | None:
    for a, b in ((x, y), (y, x)):
        if a.literal == 0.0:
            return a
        if a.literal == 1.0:
            return b
        if a.literal == -1.0:
            return -b
    return None


def _simpler_quotient(x: Value, y: Value) -> Value | None:
    if x.literal == 0.0:
        return x
    return x if y.literal == 1.0 else None


_SIMPLER: dict[str, Callable[[Value, Value], Value | None]] = {
    "add": _simpler_sum,
    "subtract": _simpler_difference,
    "multiply": _simpler_product,
    "divide": _simpler_quotient,
}
