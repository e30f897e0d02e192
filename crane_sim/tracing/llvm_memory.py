"""What reads and writes memory, as text in LLVM's language."""

import struct

from crane_sim.tracing.instructions import Instruction, Kind
from crane_sim.tracing.llvm_types import MEMORY_TYPES, type_of
from crane_sim.tracing.llvm_values import ValueText
from crane_sim.tracing.trace_error import TraceError


class MemoryText(ValueText):
    """Writes loads and stores, and memory of functions."""

    def _write_element(self, arguments: tuple[int, ...], offset: int, name: str) -> None:
        base = self._name(arguments[0])
        if len(arguments) > 1:
            if self._width > 1:
                raise TraceError(f"{self._function.name}: an index that is computed differs between lanes")
            self._write(f"{name}i = getelementptr inbounds double, ptr {base}, {self._typed(arguments[1])}")
            base = f"{name}i"
        self._write(f"{name} = getelementptr inbounds double, ptr {base}, i64 {offset * self._width}")

    def _write_address(self, instruction: Instruction) -> None:
        self._write_element(instruction.arguments, instruction.literal, self._name(instruction.results[0]))

    def _write_load(self, instruction: Instruction) -> None:
        (number,) = instruction.results
        self._write_element(instruction.arguments, instruction.literal, f"%p{number}")
        self._define(number, f"load {type_of(Kind.REAL, self._width)}, ptr %p{number}, align 8")

    def _write_store(self, instruction: Instruction) -> None:
        address = f"%{self._new_label('s')}"
        self._write_element(instruction.arguments[1:], instruction.literal, address)
        self._write(f"store {self._typed(instruction.arguments[0])}, ptr {address}, align 8")

    def _write_table(self, instruction: Instruction) -> None:
        name = f"@{self._function.name}.table{instruction.results[0]}"
        words = struct.unpack(f"<{len(instruction.literal) // 8}q", instruction.literal)
        self.tables.append(
            f"{name} = internal constant [{len(words)} x i64] [{', '.join(f'i64 {w}' for w in words)}], align 16"
        )
        self._names[instruction.results[0]] = name

    def _write_slot(self, instruction: Instruction) -> None:
        name = self._name(instruction.results[0])
        align = 64 if instruction.literal >= 8 else 16
        self._slots.append(f" {name} = alloca [{max(instruction.literal, 1)} x i64], align {align}")

    def _write_allocate(self, instruction: Instruction) -> None:
        self._define(
            instruction.results[0], f"call ptr @allocate(ptr %memory, {self._typed(instruction.arguments[0])})"
        )

    def _write_move(self, instruction: Instruction) -> None:
        self._write_place(instruction.arguments, instruction.literal, self._name(instruction.results[0]))

    def _write_place(self, arguments: tuple[int, ...], offset: int, name: str) -> None:
        """Write the address that is `offset` bytes, and an argument's number of bytes, from another one."""
        base = self._name(arguments[0])
        if len(arguments) > 1:
            self._write(f"{name}i = getelementptr inbounds i8, ptr {base}, {self._typed(arguments[1])}")
            base = f"{name}i"
        self._write(f"{name} = getelementptr inbounds i8, ptr {base}, i64 {offset}")

    def _write_read(self, instruction: Instruction) -> None:
        (number,), (offset, code) = instruction.results, instruction.literal
        kind, place = MEMORY_TYPES[code], f"%p{number}"
        self._write_place(instruction.arguments, offset, place)
        if code not in ("i4", "b1"):
            self._define(number, f"load {kind}, ptr {place}, align 8{self._access}")
            return
        self._write(f"{place}n = load {kind}, ptr {place}, align {4 if code == 'i4' else 1}{self._access}")
        self._define(number, f"sext i32 {place}n to i64" if code == "i4" else f"trunc i8 {place}n to i1")

    def _write_write(self, instruction: Instruction) -> None:
        (value, *address), (offset, code) = instruction.arguments, instruction.literal
        self._elements += 1
        kind, place, typed = MEMORY_TYPES[code], f"%q{self._elements}", self._typed(value)
        self._write_place(tuple(address), offset, place)
        if code in ("i4", "b1"):
            self._write(f"{place}n = " + (f"trunc {typed} to i32" if code == "i4" else f"zext {typed} to i8"))
            typed = f"{kind} {place}n"
        self._write(f"store {typed}, ptr {place}, align {dict(i4=4, b1=1).get(code, 8)}{self._access}")
