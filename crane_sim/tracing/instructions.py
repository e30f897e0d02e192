"""Instructions in single-assignment form, kinds of values, and properties of operations."""

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
    literal: Any = None  # a constant, an offset into an array, the function that is called, or
    # blocks


class Block(NamedTuple):
    """Instructions that run one after the other, and the values that they result in."""

    instructions: list[Instruction]
    parameters: tuple[int, ...]
    results: tuple[int, ...]


COMMUTATIVE = {"add", "multiply", "equal", "unequal", "both"}
IMPURE = {"read", "write", "allocate", "call", "branch", "loop"}
"""Operations that read or write memory, or may: each is kept as it is noted."""
