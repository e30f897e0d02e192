"""Instructions of a traced function computed one by one in Python, with floats or other numbers.

Addresses are those of the process. In another kind of numbers than floats, reals that are written
are kept apart.
"""

import ctypes
import math
import operator
import struct
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from crane_sim.numerics.elementary import sincos
from crane_sim.tracing.arguments import kinds_of, rebuild_symbols
from crane_sim.tracing.calls import Calls
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, Value
from crane_sim.tracing.instructions import DIRECTIONS, Block, Instruction, Kind
from crane_sim.tracing.operations import fma
from crane_sim.tracing.results import take_result
from crane_sim.tracing.trace_error import TraceError

FORMATS = {"f8": "d", "i8": "q", "u8": "Q", "i4": "i", "b1": "?", "p8": "Q", "t8": f"{DIRECTIONS}d"}
"""Formats of `struct` of what memory holds, by their codes."""
_LIBRARY: Any = ctypes.CDLL("libm.so.6")
_WORDS = 1 << 64


class Numbers(NamedTuple):
    """How reals are computed.

    Attributes:
        lift: a float as a real.
        operations: by name, of reals.
        functions: by those in Python, in place of the instructions of traced functions.
        exact: reals are floats, and memory has them as such.
    """

    lift: Callable[[float], Any]
    operations: dict[str, Callable[..., Any]]
    functions: dict[Any, Callable[..., tuple[Any, ...]]] = {}
    exact: bool = False


class Memory:
    """Memory of the process, and reals that are no floats in front of it."""

    def __init__(self, numbers: Numbers) -> None:
        """Begin without memory of its own."""
        self._numbers, self._cells = numbers, dict[int, Any]()
        self._buffers: list[Any] = []  # which live as long as this

    def allocate(self, size: int) -> int:
        """Return the address of zeros, as many bytes."""
        self._buffers.append(ctypes.create_string_buffer(size + 64))
        return -(-ctypes.addressof(self._buffers[-1]) // 64) * 64

    def keep(self, content: bytes) -> int:
        """Return the address of bytes."""
        address = self.allocate(len(content))
        ctypes.memmove(address, content, len(content))
        return address

    def read(self, address: int, code: str) -> Any:
        """Return the number, address or tangent there."""
        if address in self._cells and code == "f8":
            return self._cells[address]
        layout = struct.Struct(FORMATS[code])
        values = layout.unpack(ctypes.string_at(address, layout.size))
        if code == "t8":
            return np.array(values)
        return self._numbers.lift(values[0]) if code == "f8" else values[0]

    def write(self, address: int, code: str, value: Any) -> None:
        """Store a number, an address or a tangent."""
        if code == "f8" and not self._numbers.exact:
            self._cells[address] = value
            return
        parts = value if code == "t8" else (value,)
        content = struct.pack(FORMATS[code], *parts)
        ctypes.memmove(address, content, len(content))


class TracedTree(NamedTuple):
    """A function of the leaves of a tree, and the structure of what it returns."""

    function: Function
    structure: Any


def trace_tree(key: Any, compute: Callable[[Calls, Graph, Any], Any]) -> TracedTree:
    """Return what a function of (calls, graph, tree of symbols) notes for an `arguments` tree."""
    graph, calls, structure = Graph(), Calls(), list[Any]()

    def run(*symbols: Value) -> tuple[Value, ...]:
        stored: list[Value] = []
        result = compute(calls, graph, rebuild_symbols(key, iter(symbols)))
        structure.append(take_result(result, stored, graph))
        return tuple(stored)

    block = graph.trace_block(run, tuple(kinds_of(key)))
    return TracedTree(Function("tree", compute, graph, block, False), structure[0])


def evaluate(
    function: Function, arguments: list[Any], numbers: Numbers, memory: Memory
) -> tuple[Any, ...]:
    """Return the results of a function, leaf by leaf.

    Raises:
        TraceError: an operation is not known.
    """
    with np.errstate(all="ignore"):
        return _Evaluation(numbers, memory).call(function, arguments)


class _Evaluation:
    def __init__(self, numbers: Numbers, memory: Memory) -> None:
        self._numbers, self._memory = numbers, memory
        self._of_reals = _OF_TANGENTS | _CONVERSIONS | numbers.operations
        self._of_others = _OF_OTHERS | (
            {"add_scaled": _add_scaled_exactly} if numbers.exact else {}
        )
        self._kinds: list[Kind] = []  # of the values of the function that is called

    def call(self, function: Function, arguments: list[Any]) -> tuple[Any, ...]:
        """Return what a function returns."""
        if function.python in self._numbers.functions:
            return self._numbers.functions[function.python](*arguments)
        before, self._kinds = self._kinds, function.graph.kinds
        values = dict(zip(function.block.parameters, arguments, strict=True))
        results = self._run(function.block, values)
        self._kinds = before
        return results

    def _run(self, block: Block, values: dict[int, Any]) -> tuple[Any, ...]:
        for instruction in block.instructions:
            operands = [values[number] for number in instruction.arguments]
            results = self._compute(instruction, operands, values)
            values.update(zip(instruction.results, results, strict=True))
        return tuple([values[number] for number in block.results])

    def _compute(
        self, instruction: Instruction, operands: list[Any], values: dict[int, Any]
    ) -> tuple[Any, ...]:
        operation, numbers, results, literal = instruction
        if operation in _READ_OR_WRITE:
            return self._access(operation, operands, literal)
        if operation == "branch":
            return self._run(literal[0] if operands[0] else literal[1], values)
        if operation == "loop":
            return self._repeat(operands, literal, values)
        if operation == "call":
            return self.call(literal, operands)
        if operation == "constant":
            return (self._constant(literal, self._kinds[results[0]]),)
        if operation == "select":
            return (operands[1] if operands[0] else operands[2],)
        table = self._of_reals if self._kinds[numbers[0]] is Kind.REAL else self._of_others
        compute = table.get(operation)
        if compute is None:
            raise TraceError(f"{operation} is not evaluated")
        result = compute(*operands)
        if operation == "to_real":
            result = self._numbers.lift(result)
        return (result % _WORDS if self._kinds[results[0]] is Kind.WORD else result,)

    def _constant(self, literal: Any, kind: Kind) -> Any:
        if kind is Kind.TANGENT:
            return np.zeros(DIRECTIONS)
        return self._numbers.lift(literal) if kind is Kind.REAL else literal

    def _repeat(
        self, state: Any, blocks: tuple[Block, Block], values: dict[int, Any]
    ) -> tuple[Any, ...]:
        proceed, body = blocks
        while True:
            values.update(zip(proceed.parameters, state, strict=True))
            if not self._run(proceed, values)[0]:
                return tuple(state)
            values.update(zip(body.parameters, state, strict=True))
            state = self._run(body, values)

    def _access(self, operation: str, operands: list[Any], literal: Any) -> tuple[Any, ...]:
        memory = self._memory
        match operation:
            case "slot":
                return (memory.allocate(8 * literal),)
            case "allocate":
                return (memory.allocate(operands[0]),)
            case "table":
                return (memory.keep(literal),)
            case "move":
                return (sum(operands) + literal,)
            case "read":
                return (memory.read(operands[0] + literal[0], literal[1]),)
        memory.write(operands[1] + literal[0], literal[1], operands[0])
        return ()


def _library(name: str, count: int) -> Callable[..., float]:
    function = getattr(_LIBRARY, name)
    function.restype, function.argtypes = ctypes.c_double, [ctypes.c_double] * count
    return function


def _quotient(a: int, b: int) -> int:
    return abs(a) // abs(b) * (1 if (a < 0) == (b < 0) else -1)


COMPARISONS: dict[str, Callable[..., Any]] = {
    "less": operator.lt,
    "less_equal": operator.le,
    "equal": operator.eq,
    "unequal": operator.ne,
}
"""Operations on two numbers of any kind."""
_ARITHMETIC = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "negate": operator.neg,
}
_OF_INTEGERS: dict[str, Callable[..., Any]] = {
    **COMPARISONS,
    **_ARITHMETIC,
    "both": operator.and_,
    "either": operator.or_,
    "differ": operator.xor,
    "shift_right": operator.rshift,
    "shift_left": operator.lshift,
    "quotient": _quotient,
    "remainder": lambda a, b: a - b * _quotient(a, b),
}
_OF_TANGENTS: dict[str, Callable[..., Any]] = {
    "scale": lambda factor, tangent: factor * tangent,
    "add_scaled": lambda tangent, factor, other: tangent + factor * other,
}
_CONVERSIONS: dict[str, Callable[..., Any]] = {
    "to_real": lambda i: i,
    "to_integer": lambda x: int(x) if -(2.0**63) <= x < 2.0**63 else 0,
    "flag_to_integer": int,
    "to_word": lambda i: i,
    "word_to_integer": lambda w: w - _WORDS if w >= _WORDS // 2 else w,
}


def _add_scaled_exactly(tangent: Any, factor: float, other: Any) -> Any:
    """Return the sum as machine code has it: each entry is rounded once."""
    return np.array([fma(factor, x, y) for x, y in zip(other, tangent, strict=True)])


_OF_OTHERS = _OF_INTEGERS | _OF_TANGENTS | _CONVERSIONS
_READ_OR_WRITE = {"slot", "allocate", "table", "move", "read", "write"}
FLOATS = Numbers(
    float,
    {
        **COMPARISONS,
        **_ARITHMETIC,
        "divide": lambda a, b: float(np.float64(a) / np.float64(b)),
        "absolute": abs,
        "copy_sign": math.copysign,
        **{
            name: _library(name, 1)
            for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "asin", "acos", "atan")
        },
        **{name: _library(name, 1) for name in ("tanh", "sinh", "cosh", "floor", "ceil")},
        **{name: _library(name, 2) for name in ("atan2", "hypot", "fmod")},
        **{"round": _library("rint", 1), "power": _library("pow", 2), "fma": _library("fma", 3)},
    },
    {sincos: sincos},
    exact=True,
)
"""Floats, with the bits of machine code."""
