"""Instructions in single-assignment form, their kinds of values, and what is known of their operations."""

import operator
from collections.abc import Callable
from enum import Enum
from typing import Any, NamedTuple

Number = float | int
DIRECTIONS = 8
"""Directions along which derivatives are computed at once."""


class Kind(Enum):
    """What a value is."""

    REAL = "real"
    INTEGER = "integer"
    BOOLEAN = "boolean"
    WORD = "word"  # 64 bits, without a sign
    ARRAY = "array"  # an address
    TANGENT = "tangent"  # derivatives of a real along `DIRECTIONS` directions

    __hash__ = object.__hash__  # as each is one object; that of an Enum takes longer


class Instruction(NamedTuple):
    """One instruction; values are called by their number."""

    operation: str
    arguments: tuple[int, ...]
    results: tuple[int, ...]
    literal: Any = None  # a constant, an offset into an array, the function that is called, or blocks


class Block(NamedTuple):
    """Instructions that run one after the other, and the values that they result in."""

    instructions: list[Instruction]
    parameters: tuple[int, ...]
    results: tuple[int, ...]


FOLDED: dict[str, Callable[..., Any]] = {
    "add": operator.add,
    "subtract": operator.sub,
    "multiply": operator.mul,
    "divide": operator.truediv,
    "negate": operator.neg,
    "less": operator.lt,
    "less_equal": operator.le,
    "equal": operator.eq,
    "unequal": operator.ne,
    "both": operator.and_,
    "absolute": abs,
}
"""Operations whose result on constants is computed while tracing; Python's floats have the bits of the code's."""

_NUMBERS = {Kind.REAL, Kind.INTEGER, Kind.WORD}
OPERANDS: dict[str, set[Kind]] = {
    **dict.fromkeys(("add", "subtract", "multiply", "negate", "less", "less_equal"), _NUMBERS),
    **dict.fromkeys(("equal", "unequal"), {*_NUMBERS, Kind.BOOLEAN}),
    **dict.fromkeys(("divide", "absolute", "sqrt", "exp", "power", "fma", "to_integer"), {Kind.REAL}),
    "both": {Kind.INTEGER, Kind.BOOLEAN, Kind.WORD},
    "to_real": {Kind.INTEGER, Kind.WORD},
}
"""Kinds that an operation is defined for."""

COMMUTATIVE = {"add", "multiply", "equal", "unequal", "both"}
COMPARISONS = {"less", "less_equal", "equal", "unequal"}
IMPURE = {"read", "write", "allocate", "call", "branch", "loop"}
"""Operations that read or write memory, or may: each is kept as it is noted."""
