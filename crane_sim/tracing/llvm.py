"""Text of traced functions in LLVM's language: for one crane, or for several, one in each lane of vectors.

In lanes, every real, integer and condition is a vector; element i of an array is the `width` reals from i × width on.
A branch computes both sides and selects, a loop goes on until no lane does.
"""

import struct
from collections.abc import Callable, Iterator
from typing import Any

from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import IMPURE, Block, Instruction, Kind, TraceError

_TYPES = {
    Kind.REAL: "double",
    Kind.INTEGER: "i64",
    Kind.BOOLEAN: "i1",
    Kind.ARRAY: "ptr",
    Kind.FUNCTION: "ptr",
}
_ARITHMETIC = {"add": "add", "subtract": "sub", "multiply": "mul", "divide": "div"}
_COMPARISON = {
    "less": ("fcmp olt", "icmp slt"),
    "less_equal": ("fcmp ole", "icmp sle"),
    "equal": ("fcmp oeq", "icmp eq"),
    "unequal": ("fcmp une", "icmp ne"),
}
_INTRINSIC = {"sqrt": ("sqrt", 1), "absolute": ("fabs", 1), "fma": ("fma", 3)}
_LIBRARY = {"exp": ("exp", 1), "power": ("pow", 2)}
"""Operations on reals: instructions of processors, and functions of the C library, with their numbers of arguments."""


def module_text(*functions: Function, width: int = 1) -> str:
    """Return a module in which these functions can be called from outside.

    In lanes they take a real as one for all lanes, and return nothing.
    """
    exported = {function.name for function in functions}
    texts = [_FunctionText(f, f.name in exported, width).text for f in functions_with_callees(*functions)]
    return "\n".join((*_declarations(width), *texts, ""))


def functions_with_callees(*functions: Function) -> list[Function]:
    """Return functions and all that they call, each after what it calls."""
    found: dict[str, Function] = {}
    for function in functions:
        _collect(function, found)
    return list(found.values())


def _declarations(width: int) -> Iterator[str]:
    real = _type(Kind.REAL, width)
    for name, count in _INTRINSIC.values():
        yield f"declare {real} @llvm.{name}.{_suffix(width)}({', '.join([real] * count)})"
    for name, count in _LIBRARY.values():
        yield f"declare double @{name}({', '.join(['double'] * count)})"


def _suffix(width: int) -> str:
    return "f64" if width == 1 else f"v{width}f64"


def _collect(function: Function, found: dict[str, Function]) -> None:
    if function.name not in found:
        for callee in _callees(function.block):
            _collect(callee, found)
        found[function.name] = function


def _callees(block: Block) -> Iterator[Function]:
    for instruction in block.instructions:
        if instruction.operation == "call":
            yield instruction.literal
        elif instruction.operation in ("branch", "loop"):
            for inner in instruction.literal:
                yield from _callees(inner)


def _type(kind: Kind, width: int) -> str:
    scalar = _TYPES[kind]
    return scalar if width == 1 or scalar == "ptr" else f"<{width} x {scalar}>"


def _result_type(kinds: tuple[Kind, ...], width: int) -> str:
    if len(kinds) == 1:
        return _type(kinds[0], width)
    return "{" + ", ".join(_type(kind, width) for kind in kinds) + "}" if kinds else "void"


def _literal(number: float | int, kind: Kind, width: int) -> str:
    text = f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}" if kind is Kind.REAL else str(int(number))
    return text if width == 1 else "<" + ", ".join([f"{_TYPES[kind]} {text}"] * width) + ">"


class _FunctionText:
    """Writes one function; a value is named by its number, a label by the order of labels."""

    def __init__(self, function: Function, exported: bool, width: int) -> None:
        self._function, self._width = function, width
        self._lines: list[str] = []
        self._names: dict[int, str] = {}
        self._labels = 0
        self._label = "entry"  # of the basic block that is being written
        self.text = "\n".join((self._head(exported), "entry:", *self._body(), "}"))

    def _head(self, exported: bool) -> str:
        parameters = [self._parameter(number, exported) for number in self._function.block.parameters]
        linkage = "" if exported else "internal "
        inlining = " alwaysinline" if self._function.inlined and not exported else ""
        if exported and self._width > 1 and self._function.block.results:
            raise TraceError(f"{self._function.name} returns a number, which in lanes no caller outside could take")
        signature = f"{self._result} @{self._function.name}({', '.join(parameters)})"
        return f"define {linkage}{signature} nounwind{inlining} {{"

    def _parameter(self, number: int, exported: bool) -> str:
        kind = self._kind(number)
        if kind is Kind.ARRAY:
            return f"ptr noalias {self._name(number)}"
        if not exported or self._width == 1 or kind is Kind.FUNCTION:
            return self._typed(number)
        scalar, vector = f"%scalar{number}", _type(kind, self._width)
        self._write(f"%first{number} = insertelement {vector} undef, {_TYPES[kind]} {scalar}, i32 0")
        zeros = f"<{self._width} x i32> zeroinitializer"
        self._write(f"{self._name(number)} = shufflevector {vector} %first{number}, {vector} undef, {zeros}")
        return f"{_TYPES[kind]} {scalar}"

    @property
    def _result(self) -> str:
        return _result_type(self._function.result_kinds, self._width)

    def _body(self) -> list[str]:
        self._write_block(self._function.block)
        results = self._function.block.results
        if len(results) <= 1:
            self._write("ret " + (self._typed(results[0]) if results else "void"))
            return self._lines
        whole = "undef"
        for i, number in enumerate(results):
            self._write(f"%r{i} = insertvalue {self._result} {whole}, {self._typed(number)}, {i}")
            whole = f"%r{i}"
        self._write(f"ret {self._result} {whole}")
        return self._lines

    def _kind(self, number: int) -> Kind:
        return self._function.graph.kinds[number]

    def _name(self, number: int) -> str:
        return self._names.setdefault(number, f"%v{number}")

    def _typed(self, number: int) -> str:
        return f"{_type(self._kind(number), self._width)} {self._name(number)}"

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
            else:
                self._define(instruction.results[0], self._expression(instruction))

    def _expression(self, instruction: Instruction) -> str:
        operation, arguments = instruction.operation, instruction.arguments
        first, real = _type(self._kind(arguments[0]), self._width), self._kind(arguments[0]) is Kind.REAL
        names = ", ".join(map(self._name, arguments))
        if operation in _ARITHMETIC:
            return f"{'f' if real else ''}{_ARITHMETIC[operation]} {first} {names}"
        if operation in _COMPARISON:
            return f"{_COMPARISON[operation][not real]} {first} {names}"
        typed = ", ".join(map(self._typed, arguments))
        if operation in _INTRINSIC:
            return f"call {first} @llvm.{_INTRINSIC[operation][0]}.{_suffix(self._width)}({typed})"
        if operation == "select":
            return f"select {typed}"
        if operation == "both":
            return f"and {first} {names}"
        if operation == "negate":
            return f"fneg {first} {names}" if real else f"sub {first} zeroinitializer, {names}"
        if operation == "to_real":
            return f"sitofp {first} {names} to {_type(Kind.REAL, self._width)}"
        assert operation == "to_integer", operation
        return f"fptosi {first} {names} to {_type(Kind.INTEGER, self._width)}"

    def _write_constant(self, instruction: Instruction) -> None:
        (number,) = instruction.results
        self._names[number] = _literal(instruction.literal, self._kind(number), self._width)

    def _write_exp(self, instruction: Instruction) -> None:
        self._write_library_call(instruction)

    def _write_power(self, instruction: Instruction) -> None:
        self._write_library_call(instruction)

    def _write_library_call(self, instruction: Instruction) -> None:
        """Write a call of the C library, lane by lane."""
        (number,), name = instruction.results, _LIBRARY[instruction.operation][0]
        if self._width == 1:
            self._define(number, f"call double @{name}({', '.join(map(self._typed, instruction.arguments))})")
            return
        whole, vector = "undef", _type(Kind.REAL, self._width)
        for lane in range(self._width):
            for i, argument in enumerate(instruction.arguments):
                self._write(f"%e{number}.{lane}.{i} = extractelement {self._typed(argument)}, i32 {lane}")
            arguments = ", ".join(f"double %e{number}.{lane}.{i}" for i in range(len(instruction.arguments)))
            self._write(f"%e{number}.{lane} = call double @{name}({arguments})")
            target = self._name(number) if lane == self._width - 1 else f"%w{number}.{lane}"
            self._write(f"{target} = insertelement {vector} {whole}, double %e{number}.{lane}, i32 {lane}")
            whole = target

    def _write_call(self, instruction: Instruction) -> None:
        callee: Function = instruction.literal
        self._write_call_of(instruction, f"@{callee.name}", callee.result_kinds, instruction.arguments)

    def _write_call_address(self, instruction: Instruction) -> None:
        address, *arguments = instruction.arguments
        self._write_call_of(instruction, self._name(address), instruction.literal, tuple(arguments))

    def _write_call_of(
        self, instruction: Instruction, callee: str, result: tuple[Kind, ...], arguments: tuple[int, ...]
    ) -> None:
        kind = _result_type(result, self._width)
        call = f"call {kind} {callee}({', '.join(map(self._typed, arguments))})"
        if len(instruction.results) <= 1:
            self._write(f"{self._name(instruction.results[0])} = {call}" if instruction.results else call)
            return
        whole = f"%c{instruction.results[0]}"
        self._write(f"{whole} = {call}")
        for i, number in enumerate(instruction.results):
            self._define(number, f"extractvalue {kind} {whole}, {i}")

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
        self._define(number, f"load {_type(Kind.REAL, self._width)}, ptr %p{number}, align 8")

    def _write_store(self, instruction: Instruction) -> None:
        address = f"%{self._new_label('s')}"
        self._write_element(instruction.arguments[1:], instruction.literal, address)
        self._write(f"store {self._typed(instruction.arguments[0])}, ptr {address}, align 8")

    def _write_branch(self, instruction: Instruction) -> None:
        if self._width > 1:
            self._write_both_sides(instruction)
            return
        then, otherwise, end = self._new_label("then"), self._new_label("else"), self._new_label("end")
        self._write(f"br {self._typed(instruction.arguments[0])}, label %{then}, label %{otherwise}")
        origins = []
        for label, block in zip((then, otherwise), instruction.literal, strict=True):
            self._begin(label)
            self._write_block(block)
            self._write(f"br label %{end}")
            origins.append(self._label)
        self._begin(end)
        for i, number in enumerate(instruction.results):
            sides = zip(instruction.literal, origins, strict=True)
            values = ", ".join(f"[{self._name(block.results[i])}, %{origin}]" for block, origin in sides)
            self._define(number, f"phi {_type(self._kind(number), 1)} {values}")

    def _write_both_sides(self, instruction: Instruction) -> None:
        for block in instruction.literal:
            self._check_purity(block)
            self._write_block(block)
        then, otherwise = instruction.literal
        condition = self._typed(instruction.arguments[0])
        for number, a, b in zip(instruction.results, then.results, otherwise.results, strict=True):
            self._define(number, f"select {condition}, {self._typed(a)}, {self._typed(b)}")

    def _check_purity(self, block: Block) -> None:
        stores = [i for i in block.instructions if i.operation in IMPURE and i.operation == "store"]
        if stores:
            raise TraceError(f"{self._function.name}: a store in a branch or loop, which in lanes all would carry out")

    def _write_loop(self, instruction: Instruction) -> None:
        proceed, body = instruction.literal
        head, inside, end = self._new_label("head"), self._new_label("body"), self._new_label("end")
        before = self._label
        self._write(f"br label %{head}")
        self._begin(head)
        place = len(self._lines)  # of the phis, which name what the body results in
        condition = self._write_turn(proceed, instruction)[0]
        self._write(f"br i1 {self._any_lane(condition)}, label %{inside}, label %{end}")
        self._begin(inside)
        following = self._write_turn(body, instruction)
        if self._width > 1:
            self._check_purity(body)
            following = self._keep_ended_lanes(condition, instruction.results, following)
        self._write(f"br label %{head}")
        starts = zip(instruction.results, instruction.arguments, following, strict=True)
        self._lines[place:place] = [self._phi(number, first, before, after) for number, first, after in starts]
        self._begin(end)

    def _write_turn(self, block: Block, loop: Instruction) -> tuple[int, ...]:
        for number, parameter in zip(loop.results, block.parameters, strict=True):
            self._names[parameter] = self._name(number)
        self._write_block(block)
        return block.results

    def _any_lane(self, condition: int) -> str:
        if self._width == 1:
            return self._name(condition)
        lanes, flag = f"%{self._new_label('l')}", f"%{self._new_label('l')}"
        self._write(f"{lanes} = bitcast {self._typed(condition)} to i{self._width}")
        self._write(f"{flag} = icmp ne i{self._width} {lanes}, 0")
        return flag

    def _keep_ended_lanes(self, condition: int, old: Any, new: tuple[int, ...]) -> tuple[int, ...]:
        """Write selections of the new state where a lane goes on; return the numbers of new values."""
        kept = []
        for before, after in zip(old, new, strict=True):
            value = self._function.graph.new_value(self._kind(after))
            choice = f"select {self._typed(condition)}, {self._typed(after)}, {self._typed(before)}"
            self._define(value.number, choice)
            kept.append(value.number)
        return tuple(kept)

    def _phi(self, number: int, first: int, before: str, after: int) -> str:
        pair = f"[{self._name(first)}, %{before}], [{self._name(after)}, %{self._label}]"
        return f" {self._name(number)} = phi {_type(self._kind(number), self._width)} {pair}"
