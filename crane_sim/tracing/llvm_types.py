"""Types, literals and operations of LLVM's language."""

import struct
from collections.abc import Iterator

from crane_sim.tracing.instructions import DIRECTIONS, Kind
from crane_sim.tracing.memory import MEMORY

TYPES = {
    Kind.REAL: "double",
    Kind.INTEGER: "i64",
    Kind.BOOLEAN: "i1",
    Kind.WORD: "i64",
    Kind.ARRAY: "ptr",
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
    **{
        name: (name, 1)
        for name in (
            "exp",
            "log",
            "sin",
            "cos",
            "tan",
            "asin",
            "acos",
            "atan",
            "tanh",
            "sinh",
            "cosh",
        )
    },
    **{name: (name, 2) for name in ("atan2", "hypot", "fmod")},
    "power": ("pow", 2),
}
"""Operations on reals: instructions of processors, and functions of the C library, with their
numbers of arguments."""

MEMORY_TYPES = {
    **{"f8": "double", "i8": "i64", "u8": "i64", "i4": "i32", "b1": "i8", "p8": "ptr"},
    "t8": TYPES[Kind.TANGENT],
}
"""Types of what arrays hold, by the codes of NumPy."""


def declarations() -> Iterator[str]:
    """Yield what every module declares: memory, intrinsics and functions of the C library."""
    tangent = TYPES[Kind.TANGENT]
    yield MEMORY
    yield f"declare {tangent} @llvm.fma.v{DIRECTIONS}f64({tangent}, {tangent}, {tangent})"
    for name, count in INTRINSIC.values():
        yield f"declare double @llvm.{name}.f64({', '.join(['double'] * count)})"
    for name, count in LIBRARY.values():
        # pow(x, 2) is not always x x
        known = "nobuiltin" if name == "pow" else "memory(none) nounwind willreturn"
        yield f"declare double @{name}({', '.join(['double'] * count)}) {known}"


def literal_text(number: float | int, kind: Kind) -> str:
    """Return a constant; of tangents, zeros."""
    if kind is Kind.TANGENT:
        return "zeroinitializer"
    return (
        f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}"
        if kind is Kind.REAL
        else str(int(number))
    )
