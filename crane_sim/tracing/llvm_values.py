"""Values of a function as text in LLVM's language: their names and types, and what computes them."""

from collections.abc import Callable, Iterator

from crane_sim.tracing.function import Function
from crane_sim.tracing.instructions import DIRECTIONS, Block, Instruction, Kind
from crane_sim.tracing.llvm_types import (
    ARITHMETIC,
    BITS,
    COMPARISON,
    INTRINSIC,
    LIBRARY,
    TYPES,
    literal_text,
    suffix_of,
    type_of,
)


class ValueText:
    """Writes instructions that compute numbers; a value is named by its number, a label by the order of labels."""

    def __init__(self, function: Function, width: int, nodes: Iterator[int]) -> None:
        self._function, self._width, self._nodes = function, width, nodes
        self._metadata: list[str] = []
        self._access = ""  # what loads, stores and calls are marked with where it is being written
        self._lines: list[str] = []
        self._names: dict[int, str] = {}
        self._labels = self._elements = 0
        self._slots: list[str] = []
        self.tables: list[str] = []  # constants
        self._label = "entry"  # of the basic block that is being written
        self._lanes = "%lanes"  # whose results are used where it is being written

    def _kind(self, number: int) -> Kind:
        return self._function.graph.kinds[number]

    def _name(self, number: int) -> str:
        return self._names.setdefault(number, f"%v{number}")

    def _typed(self, number: int) -> str:
        return f"{type_of(self._kind(number), self._width)} {self._name(number)}"

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

    def _write_block(self, block: Block) -> None:
        for instruction in block.instructions:
            writer: Callable[[Instruction], None] | None = getattr(self, f"_write_{instruction.operation}", None)
            if writer:
                writer(instruction)
            elif instruction.operation in LIBRARY:
                self._write_library_call(instruction)
            else:
                self._define(instruction.results[0], self._expression(instruction))

    def _expression(self, instruction: Instruction) -> str:
        operation, arguments = instruction.operation, instruction.arguments
        typed = ", ".join(map(self._typed, arguments))
        if operation in INTRINSIC:
            first = type_of(self._kind(arguments[0]), self._width)
            return f"call {first} @llvm.{INTRINSIC[operation][0]}.{suffix_of(self._width)}({typed})"
        if operation == "select":
            return f"select {typed}"
        names = ", ".join(map(self._name, arguments))
        kind = self._kind(arguments[0])
        return self._conversion(operation, kind, names) or self._operation(operation, kind, names)

    def _conversion(self, operation: str, kind: Kind, name: str) -> str:
        """Return the expression of an operation that changes the kind of a value, empty for another one."""
        first = type_of(kind, self._width)
        integer, real = type_of(Kind.INTEGER, self._width), type_of(Kind.REAL, self._width)
        match operation:
            case "flag_to_integer":
                return f"zext {first} {name} to {integer}"
            case "to_word" | "word_to_integer":
                return f"add {first} {name}, 0"
            case "to_real":
                return f"{'ui' if kind is Kind.WORD else 'si'}tofp {first} {name} to {real}"
            case "to_integer":
                return f"fptosi {first} {name} to {integer}"
            case _:
                return ""

    def _operation(self, operation: str, kind: Kind, names: str) -> str:
        first, real = type_of(kind, self._width), kind is Kind.REAL
        if operation in ARITHMETIC:
            return f"{'f' if real else ''}{ARITHMETIC[operation]} {first} {names}"
        if operation in COMPARISON:
            return f"{COMPARISON[operation][0 if real else 2 if kind is Kind.WORD else 1]} {first} {names}"
        if operation in BITS:
            logical = operation == "shift_right" and kind is Kind.WORD
            return f"{'lshr' if logical else BITS[operation]} {first} {names}"
        if operation in ("quotient", "remainder"):
            return f"{'u' if kind is Kind.WORD else 's'}{'div' if operation == 'quotient' else 'rem'} {first} {names}"
        assert operation == "negate", operation
        return f"fneg {first} {names}" if real else f"sub {first} zeroinitializer, {names}"

    def _write_constant(self, instruction: Instruction) -> None:
        (number,) = instruction.results
        self._names[number] = literal_text(instruction.literal, self._kind(number), self._width)

    def _write_scale(self, instruction: Instruction) -> None:
        factor, tangent = instruction.arguments
        self._define(instruction.results[0], f"fmul {self._spread(factor, instruction)}, {self._name(tangent)}")

    def _write_add_scaled(self, instruction: Instruction) -> None:
        summand, factor, tangent = instruction.arguments
        operands = f"{self._spread(factor, instruction)}, {self._typed(tangent)}, {self._typed(summand)}"
        self._define(instruction.results[0], f"call {TYPES[Kind.TANGENT]} @llvm.fma.v{DIRECTIONS}f64({operands})")

    def _spread(self, factor: int, instruction: Instruction) -> str:
        """Write a tangent of which every element is a real; return it with its type."""
        kind, name = TYPES[Kind.TANGENT], f"%t{instruction.results[0]}"
        self._write(f"{name}.first = insertelement {kind} poison, {self._typed(factor)}, i32 0")
        zeros = f"<{DIRECTIONS} x i32> zeroinitializer"
        self._write(f"{name} = shufflevector {kind} {name}.first, {kind} poison, {zeros}")
        return f"{kind} {name}"

    def _write_library_call(self, instruction: Instruction) -> None:
        """Write a call of the C library, lane by lane."""
        (number,), name = instruction.results, LIBRARY[instruction.operation][0]
        if self._width == 1:
            self._define(number, f"call double @{name}({', '.join(map(self._typed, instruction.arguments))})")
            return
        whole, vector = "undef", type_of(Kind.REAL, self._width)
        for lane in range(self._width):
            for i, argument in enumerate(instruction.arguments):
                self._write(f"%e{number}.{lane}.{i} = extractelement {self._typed(argument)}, i32 {lane}")
            arguments = ", ".join(f"double %e{number}.{lane}.{i}" for i in range(len(instruction.arguments)))
            self._write(f"%e{number}.{lane} = call double @{name}({arguments})")
            target = self._name(number) if lane == self._width - 1 else f"%w{number}.{lane}"
            self._write(f"{target} = insertelement {vector} {whole}, double %e{number}.{lane}, i32 {lane}")
            whole = target
