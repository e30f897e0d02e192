"""Values of a function as LLVM text: names, types, and what computes, reads and writes them."""

import struct
from collections.abc import Callable, Iterator

from crane_sim.tracing.function import Function
from crane_sim.tracing.instructions import DIRECTIONS, Block, Instruction, Kind
from crane_sim.tracing.llvm_types import (
    ARITHMETIC,
    BITS,
    COMPARISON,
    INTRINSIC,
    LIBRARY,
    MEMORY_TYPES,
    TYPES,
    literal_text,
)
from crane_sim.tracing.shared_arguments import Place

_ALIGNMENT = {"i4": 4, "b1": 1}  # bytes; of all others 8


class ValueText:
    """Writes instructions without control flow; names are numbers of values or orders of labels."""

    def __init__(self, function: Function, places: dict[int, Place], nodes: Iterator[int]) -> None:
        """Begin to write.

        Args:
            function: that is written.
            places: parameters that it reads itself.
            nodes: numbers of metadata.
        """
        self._function, self._places, self._nodes = function, places, nodes
        self._metadata: list[str] = []
        self._access = ""  # what loads, stores and calls are marked with where it is being written
        self._lines: list[str] = []
        self._names: dict[int, str] = {}
        self._labels = self._writes = self._reads = 0
        self._head: list[str] = []  # memory of the function, and arguments that it reads
        self.tables: list[str] = []  # constants
        self._near: dict[int, str] = {}  # names of arguments that the basic block has read
        self._label = "entry"  # of the basic block that is being written

    def _kind(self, number: int) -> Kind:
        return self._function.graph.kinds[number]

    def _name(self, number: int) -> str:
        if number in self._places and number not in self._names:
            return self._near.get(number) or self._read_argument(number)
        return self._names.setdefault(number, f"%v{number}")

    def _typed(self, number: int) -> str:
        return f"{TYPES[self._kind(number)]} {self._name(number)}"

    def _write(self, line: str) -> None:
        self._lines.append(" " + line)

    def _define(self, number: int, expression: str) -> None:
        self._write(f"{self._name(number)} = {expression}")

    def _new_label(self, word: str) -> str:
        self._labels += 1
        return f"{word}{self._labels}"

    def _begin(self, label: str) -> None:
        self._lines.append(f"{label}:")
        self._label = label
        self._near.clear()

    def _write_block(self, block: Block) -> None:
        for instruction in block.instructions:
            writer: Callable[[Instruction], None] | None = getattr(
                self, f"_write_{instruction.operation}", None
            )
            if writer:
                writer(instruction)
            else:
                self._define(instruction.results[0], self._expression(instruction))

    # numbers

    def _expression(self, instruction: Instruction) -> str:
        operation, arguments = instruction.operation, instruction.arguments
        typed = ", ".join(map(self._typed, arguments))
        if operation in INTRINSIC:
            return f"call double @llvm.{INTRINSIC[operation][0]}.f64({typed})"
        if operation in LIBRARY:
            return f"call double @{LIBRARY[operation][0]}({typed})"
        if operation == "select":
            return f"select {typed}"
        names = ", ".join(map(self._name, arguments))
        kind = self._kind(arguments[0])
        return self._conversion(operation, kind, names) or self._operation(operation, kind, names)

    def _conversion(self, operation: str, kind: Kind, name: str) -> str:
        """Return the expression of an operation that changes a value's kind, else empty."""
        match operation:
            case "flag_to_integer":
                return f"zext i1 {name} to i64"
            case "to_word" | "word_to_integer":
                return f"add i64 {name}, 0"
            case "to_real":
                return f"{'ui' if kind is Kind.WORD else 'si'}tofp i64 {name} to double"
            case "to_integer":
                return f"fptosi double {name} to i64"
            case _:
                return ""

    def _operation(self, operation: str, kind: Kind, names: str) -> str:
        first, real, word = TYPES[kind], kind is Kind.REAL, kind is Kind.WORD
        if operation in ARITHMETIC:
            return f"{'f' if real else ''}{ARITHMETIC[operation]} {first} {names}"
        if operation in COMPARISON:
            return f"{COMPARISON[operation][0 if real else 2 if word else 1]} {first} {names}"
        if operation in BITS:
            return (
                f"{'lshr' if operation == 'shift_right' and word else BITS[operation]} {first} "
                f"{names}"
            )
        if operation in ("quotient", "remainder"):
            return (
                f"{'u' if word else 's'}{'div' if operation == 'quotient' else 'rem'} {first} "
                f"{names}"
            )
        assert operation == "negate", operation
        return f"fneg {first} {names}" if real else f"sub {first} 0, {names}"

    def _write_constant(self, instruction: Instruction) -> None:
        (number,) = instruction.results
        self._names[number] = literal_text(instruction.literal, self._kind(number))

    def _write_scale(self, instruction: Instruction) -> None:
        factor, tangent = instruction.arguments
        self._define(
            instruction.results[0],
            f"fmul {self._spread(factor, instruction)}, {self._name(tangent)}",
        )

    def _write_add_scaled(self, instruction: Instruction) -> None:
        summand, factor, tangent = instruction.arguments
        operands = (
            f"{self._spread(factor, instruction)}, {self._typed(tangent)}, {self._typed(summand)}"
        )
        self._define(
            instruction.results[0],
            f"call {TYPES[Kind.TANGENT]} @llvm.fma.v{DIRECTIONS}f64({operands})",
        )

    def _spread(self, factor: int, instruction: Instruction) -> str:
        """Write a tangent of which every element is a real; return it with its type."""
        kind, name = TYPES[Kind.TANGENT], f"%t{instruction.results[0]}"
        self._write(f"{name}.first = insertelement {kind} poison, {self._typed(factor)}, i32 0")
        zeros = f"<{DIRECTIONS} x i32> zeroinitializer"
        self._write(f"{name} = shufflevector {kind} {name}.first, {kind} poison, {zeros}")
        return f"{kind} {name}"

    # memory

    def _write_table(self, instruction: Instruction) -> None:
        name = f"@{self._function.name}.table{instruction.results[0]}"
        words = struct.unpack(f"<{len(instruction.literal) // 8}q", instruction.literal)
        elements = ", ".join(f"i64 {word}" for word in words)
        self.tables.append(
            f"{name} = internal constant [{len(words)} x i64] [{elements}], align 16"
        )
        self._names[instruction.results[0]] = name

    def _write_slot(self, instruction: Instruction) -> None:
        align = 64 if instruction.literal >= 8 else 16
        size = f"[{max(instruction.literal, 1)} x i64]"
        self._head.append(f" {self._name(instruction.results[0])} = alloca {size}, align {align}")

    def _write_allocate(self, instruction: Instruction) -> None:
        size = self._typed(instruction.arguments[0])
        self._define(instruction.results[0], f"call ptr @allocate(ptr %memory, {size})")

    def _write_move(self, instruction: Instruction) -> None:
        self._write_place(
            instruction.arguments, instruction.literal, self._name(instruction.results[0])
        )

    def _write_place(self, arguments: tuple[int, ...], offset: int, name: str) -> None:
        """Write an address from another one, `offset` and an argument's bytes further."""
        base = self._name(arguments[0])
        if len(arguments) > 1:
            self._write(
                f"{name}i = getelementptr inbounds i8, ptr {base}, {self._typed(arguments[1])}"
            )
            base = f"{name}i"
        self._write(f"{name} = getelementptr inbounds i8, ptr {base}, i64 {offset}")

    def _write_read(self, instruction: Instruction) -> None:
        (number,), (offset, code) = instruction.results, instruction.literal
        self._write_place(instruction.arguments, offset, f"%p{number}")
        self._write_load(self._name(number), f"%p{number}", code, self._access)

    def _write_load(self, name: str, place: str, code: str, mark: str) -> None:
        """Write the load of a value."""
        loaded = f"{place}n" if code in _ALIGNMENT else name
        self._write(
            f"{loaded} = load {MEMORY_TYPES[code]}, ptr {place}, align "
            f"{_ALIGNMENT.get(code, 8)}{mark}"
        )
        if code in _ALIGNMENT:
            self._write(
                f"{name} = "
                + (f"sext i32 {loaded} to i64" if code == "i4" else f"trunc i8 {loaded} to i1")
            )

    def _read_argument(self, number: int) -> str:
        """Write the read of an entry point's argument, which is constant; return its name."""
        (offset, code), self._reads = self._places[number], self._reads + 1
        name, place = f"%a{self._reads}", f"%b{self._reads}"
        self._write(f"{place} = getelementptr inbounds i8, ptr %memory, i64 {offset}")
        self._write_load(name, place, code, ", !invariant.load !0")
        self._near[number] = name
        return name

    def _write_write(self, instruction: Instruction) -> None:
        (value, *address), (offset, code) = instruction.arguments, instruction.literal
        self._writes += 1
        kind, place, typed = MEMORY_TYPES[code], f"%q{self._writes}", self._typed(value)
        self._write_place(tuple(address), offset, place)
        if code in _ALIGNMENT:
            self._write(
                f"{place}n = "
                + (f"trunc {typed} to i32" if code == "i4" else f"zext {typed} to i8")
            )
            typed = f"{kind} {place}n"
        self._write(f"store {typed}, ptr {place}, align {_ALIGNMENT.get(code, 8)}{self._access}")
