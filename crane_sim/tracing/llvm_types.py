"""Types, literals and operations of LLVM's language, for one crane or for several, one in each lane of vectors."""

import struct
from collections.abc import Iterator

from crane_sim.tracing.function import Function
from crane_sim.tracing.instructions import DIRECTIONS, Kind
from crane_sim.tracing.memory import MEMORY

TYPES = {
    Kind.REAL: "double",
    Kind.INTEGER: "i64",
    Kind.BOOLEAN: "i1",
    Kind.WORD: "i64",
    Kind.ARRAY: "ptr",
    Kind.FUNCTION: "ptr",
    Kind.TANGENT: f"<{DIRECTIONS} x double>",
}
ARITHMETIC = {"add": "add", "subtract": "sub", "multiply": "mul", "divide": "div"}
COMPARISON = {
    "less": ("fcmp olt", "icmp slt", "icmp ult"),
    "less_equal": ("fcmp ole", "icmp sle", "icmp ule"),
    "equal": ("fcmp oeq", "icmp eq", "icmp eq"),
    "unequal": ("fcmp une", "icmp ne", "icmp ne"),
}
BITS = {"both": "and", "either": "or", "differ": "xor", "shift_right": "ashr", "shift_left": "shl"}
INTRINSIC = {
    "sqrt": ("sqrt", 1),
    "absolute": ("fabs", 1),
    "fma": ("fma", 3),
    "floor": ("floor", 1),
    "ceil": ("ceil", 1),
    "round": ("rint", 1),
    "copy_sign": ("copysign", 2),
}
LIBRARY = {
    **{name: (name, 1) for name in ("exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh", "sinh", "cosh")},
    **{name: (name, 2) for name in ("atan2", "hypot", "fmod")},
    "power": ("pow", 2),
}
"""Operations on reals: instructions of processors, and functions of the C library, with their numbers of arguments."""

MEMORY_TYPES = {
    **{"f8": "double", "i8": "i64", "u8": "i64", "i4": "i32", "b1": "i8", "p8": "ptr"},
    "t8": TYPES[Kind.TANGENT],
}
"""Types of what arrays hold, by the codes of NumPy."""


def declarations(width: int) -> Iterator[str]:
    """Yield what every module declares: memory, intrinsics and functions of the C library."""
    tangent = TYPES[Kind.TANGENT]
    fma = f"declare {tangent} @llvm.fma.v{DIRECTIONS}f64({tangent}, {tangent}, {tangent})"
    yield f"{MEMORY}\n{fma}" if width == 1 else ""
    real = type_of(Kind.REAL, width)
    for name, count in INTRINSIC.values():
        yield f"declare {real} @llvm.{name}.{suffix_of(width)}({', '.join([real] * count)})"
    for name, count in LIBRARY.values():
        known = "nobuiltin" if name == "pow" else "memory(none) nounwind willreturn"  # pow(x, 2) is not always x x
        yield f"declare double @{name}({', '.join(['double'] * count)}) {known}"


def suffix_of(width: int) -> str:
    """Return how the name of an intrinsic ends."""
    return "f64" if width == 1 else f"v{width}f64"


def type_of(kind: Kind, width: int) -> str:
    """Return the type of a value."""
    scalar = TYPES[kind]
    return scalar if width == 1 or scalar == "ptr" else f"<{width} x {scalar}>"


def result_type(function: Function, width: int) -> str:
    """Return the type of what a function returns."""
    kinds = function.result_kinds
    if len(kinds) > 1:
        return f"%{symbol_of(function, width)}.result"
    return type_of(kinds[0], width) if kinds else "void"


def result_definition(function: Function, width: int) -> str:
    """Return the definition of the type of what a function returns, several numbers."""
    parts = ", ".join(type_of(kind, width) for kind in function.result_kinds)
    return f"{result_type(function, width)} = type {{{parts}}}"


def declaration(function: Function) -> str:
    """Return the declaration of a function of another module."""
    parameters = [argument_type(kind, 1) for kind in function.parameter_kinds]
    parameters += ["ptr"] if function.graph.has_allocations else []
    result = result_type(function, 1)
    return f"declare {'zeroext ' if result == 'i1' else ''}{result} @{function.name}({', '.join(parameters)}) nounwind"


def literal_text(number: float | int, kind: Kind, width: int) -> str:
    """Return a constant; of tangents, zeros."""
    if kind is Kind.TANGENT:
        return "zeroinitializer"
    text = f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}" if kind is Kind.REAL else str(int(number))
    return text if width == 1 else "<" + ", ".join([f"{TYPES[kind]} {text}"] * width) + ">"


def symbol_of(function: Function, width: int) -> str:
    """Return the name of a function."""
    return function.name if width == 1 else f"{function.name}.lanes"


def all_lanes(width: int) -> str:
    """Return, with its type, that all lanes are used."""
    return f"<{width} x i1> {literal_text(1, Kind.BOOLEAN, width)}"


def argument_type(kind: Kind, width: int) -> str:
    """Return the type of an argument or a result; a condition from and to C is a byte, 0 or 1."""
    return type_of(kind, width) + (" zeroext" if kind is Kind.BOOLEAN and width == 1 else "")
