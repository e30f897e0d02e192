"""Text of traced functions in LLVM's language: for one crane, or for several, one in each lane of vectors.

In lanes, every real, integer and condition is a vector; element i of an array is the `width` reals from i × width on.
A branch computes both sides and selects, a loop goes on until no lane does. Each function is given the lanes whose
results are used, so that a loop on the side that a lane does not take ends. What is called from outside passes all.

Arrays of one call are distinct memory: where they overlap, an element that is written may be read as it was.
"""

import itertools
import struct
from collections.abc import Callable, Iterator

from crane_sim.tracing.function import Function, functions_with_callees
from crane_sim.tracing.graph import DIRECTIONS, Block, Instruction, Kind, TraceError
from crane_sim.tracing.memory import MEMORY, allocates

_TYPES = {
    Kind.REAL: "double",
    Kind.INTEGER: "i64",
    Kind.BOOLEAN: "i1",
    Kind.WORD: "i64",
    Kind.ARRAY: "ptr",
    Kind.FUNCTION: "ptr",
    Kind.TANGENT: f"<{DIRECTIONS} x double>",
}
_ARITHMETIC = {"add": "add", "subtract": "sub", "multiply": "mul", "divide": "div"}
_COMPARISON = {
    "less": ("fcmp olt", "icmp slt", "icmp ult"),
    "less_equal": ("fcmp ole", "icmp sle", "icmp ule"),
    "equal": ("fcmp oeq", "icmp eq", "icmp eq"),
    "unequal": ("fcmp une", "icmp ne", "icmp ne"),
}
_BITS = {"both": "and", "either": "or", "differ": "xor", "shift_right": "ashr", "shift_left": "shl"}
_INTRINSIC = {
    "sqrt": ("sqrt", 1),
    "absolute": ("fabs", 1),
    "fma": ("fma", 3),
    "floor": ("floor", 1),
    "ceil": ("ceil", 1),
    "round": ("rint", 1),
    "copy_sign": ("copysign", 2),
}
_LIBRARY = {
    **{name: (name, 1) for name in ("exp", "log", "sin", "cos", "tan", "asin", "acos", "atan", "tanh", "sinh", "cosh")},
    **{name: (name, 2) for name in ("atan2", "hypot", "fmod")},
    "power": ("pow", 2),
}
"""Operations on reals: instructions of processors, and functions of the C library, with their numbers of arguments."""


def module_text(*functions: Function, width: int = 1) -> str:
    """Return a module in which these functions can be called from outside.

    In lanes they take a real as one for all lanes, and return nothing.
    """
    exported = {function.name for function in functions}
    nodes = itertools.count()  # of metadata
    texts = [_FunctionText(f, f.name in exported, width, nodes).text for f in functions_with_callees(*functions)]
    entries = [_entry(f, width) for f in functions if width > 1]
    return "\n".join((*_declarations(width), *texts, *entries, ""))


_MEMORY = {"f8": "double", "i8": "i64", "u8": "i64", "i4": "i32", "b1": "i8", "p8": "ptr", "t8": _TYPES[Kind.TANGENT]}
"""Types of what arrays hold, by the codes of NumPy."""


def _declarations(width: int) -> Iterator[str]:
    tangent = _TYPES[Kind.TANGENT]
    fma = f"declare {tangent} @llvm.fma.v{DIRECTIONS}f64({tangent}, {tangent}, {tangent})"
    yield f"{MEMORY}\n{fma}" if width == 1 else ""
    real = _type(Kind.REAL, width)
    for name, count in _INTRINSIC.values():
        yield f"declare {real} @llvm.{name}.{_suffix(width)}({', '.join([real] * count)})"
    for name, count in _LIBRARY.values():
        known = "nobuiltin" if name == "pow" else "memory(none) nounwind willreturn"  # pow(x, 2) is not always x x
        yield f"declare double @{name}({', '.join(['double'] * count)}) {known}"


def _suffix(width: int) -> str:
    return "f64" if width == 1 else f"v{width}f64"


def _type(kind: Kind, width: int) -> str:
    scalar = _TYPES[kind]
    return scalar if width == 1 or scalar == "ptr" else f"<{width} x {scalar}>"


def _result_type(kinds: tuple[Kind, ...], width: int) -> str:
    if len(kinds) == 1:
        return _type(kinds[0], width)
    return "{" + ", ".join(_type(kind, width) for kind in kinds) + "}" if kinds else "void"


def _literal(number: float | int, kind: Kind, width: int) -> str:
    if kind is Kind.TANGENT:
        return "zeroinitializer"
    text = f"0x{struct.unpack('<Q', struct.pack('<d', number))[0]:016X}" if kind is Kind.REAL else str(int(number))
    return text if width == 1 else "<" + ", ".join([f"{_TYPES[kind]} {text}"] * width) + ">"


def _entry(function: Function, width: int) -> str:
    """Return the function that is called from outside, in lanes."""
    if function.block.results:
        raise TraceError(f"{function.name} returns a number, which in lanes no caller outside could take")
    kinds, lines, zeros = function.parameter_kinds, [], f"<{width} x i32> zeroinitializer"
    for i, kind in enumerate(kinds):
        scalar, vector = _TYPES[kind], _type(kind, width)
        if vector != scalar:
            lines.append(f" %first{i} = insertelement {vector} undef, {scalar} %a{i}, i32 0")
            lines.append(f" %v{i} = shufflevector {vector} %first{i}, {vector} undef, {zeros}")
    parameters = ", ".join(f"{_passed(kind, 1)} %{'a' if _type(kind, width) != _TYPES[kind] else 'v'}{i}"
                           for i, kind in enumerate(kinds))  # fmt: skip
    arguments = ", ".join([_all_lanes(width), *(f"{_type(kind, width)} %v{i}" for i, kind in enumerate(kinds))])
    lines.append(f" call void @{_symbol(function, width)}({arguments})")
    return "\n".join((f"define void @{function.name}({parameters}) nounwind {{", *lines, " ret void", "}"))


def _symbol(function: Function, width: int) -> str:
    return function.name if width == 1 else f"{function.name}.lanes"


def _all_lanes(width: int) -> str:
    return f"<{width} x i1> {_literal(1, Kind.BOOLEAN, width)}"


def _passed(kind: Kind, width: int) -> str:
    """Return the type of an argument or a result; a condition from and to C is a byte, 0 or 1."""
    return _type(kind, width) + (" zeroext" if kind is Kind.BOOLEAN and width == 1 else "")


def _stores(block: Block) -> bool:
    """Return whether a block, or what it calls, may write memory."""
    for instruction in block.instructions:
        operation, literal = instruction.operation, instruction.literal
        inner = literal if operation in ("branch", "loop") else (literal.block,) if operation == "call" else ()
        if operation in ("store", "call_address") or any(map(_stores, inner)):
            return True
    return False


class _FunctionText:
    """Writes one function; a value is named by its number, a label by the order of labels."""

    def __init__(self, function: Function, exported: bool, width: int, nodes: Iterator[int]) -> None:
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
        self.text = self._text(exported)

    def _text(self, exported: bool) -> str:
        body = self._body()
        return "\n".join((*self.tables, self._head(exported), "entry:", *self._slots, *body, "}", *self._metadata))

    def _head(self, exported: bool) -> str:
        function, internal = self._function, not exported or self._width > 1
        parameters = [self._parameter(number) for number in function.block.parameters]
        parameters += ["ptr %memory"] if function.graph.has_allocations else []
        if not internal and len(function.block.results) > 1:
            raise TraceError(f"{function.name} returns several numbers, which no caller outside could take")
        lanes = [f"<{self._width} x i1> %lanes"] if self._width > 1 else []
        linkage, inlining = "internal " if internal else "", " alwaysinline" if function.inlined and internal else ""
        zeroext = "zeroext " if self._result == "i1" else ""
        signature = f"{self._result} @{_symbol(function, self._width)}({', '.join([*lanes, *parameters])})"
        vectors = ' "prefer-vector-width"="512"' if function.graph.has_wide_vectors else ""
        return f"define {linkage}{zeroext}{signature} nounwind{inlining}{vectors} {{"

    def _parameter(self, number: int) -> str:
        kind = self._kind(number)
        distinct = kind is Kind.ARRAY and self._function.distinct
        passed = "ptr noalias" if distinct else _passed(kind, self._width)
        return f"{passed} {self._name(number)}"

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
            elif instruction.operation in _LIBRARY:
                self._write_library_call(instruction)
            else:
                self._define(instruction.results[0], self._expression(instruction))

    def _expression(self, instruction: Instruction) -> str:
        operation, arguments = instruction.operation, instruction.arguments
        typed = ", ".join(map(self._typed, arguments))
        if operation in _INTRINSIC:
            first = _type(self._kind(arguments[0]), self._width)
            return f"call {first} @llvm.{_INTRINSIC[operation][0]}.{_suffix(self._width)}({typed})"
        if operation == "select":
            return f"select {typed}"
        names = ", ".join(map(self._name, arguments))
        kind = self._kind(arguments[0])
        return self._conversion(operation, kind, names) or self._operation(operation, kind, names)

    def _conversion(self, operation: str, kind: Kind, name: str) -> str:
        """Return the expression of an operation that changes the kind of a value, empty for another one."""
        first = _type(kind, self._width)
        integer, real = _type(Kind.INTEGER, self._width), _type(Kind.REAL, self._width)
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
        first, real = _type(kind, self._width), kind is Kind.REAL
        if operation in _ARITHMETIC:
            return f"{'f' if real else ''}{_ARITHMETIC[operation]} {first} {names}"
        if operation in _COMPARISON:
            return f"{_COMPARISON[operation][0 if real else 2 if kind is Kind.WORD else 1]} {first} {names}"
        if operation in _BITS:
            logical = operation == "shift_right" and kind is Kind.WORD
            return f"{'lshr' if logical else _BITS[operation]} {first} {names}"
        if operation in ("quotient", "remainder"):
            return f"{'u' if kind is Kind.WORD else 's'}{'div' if operation == 'quotient' else 'rem'} {first} {names}"
        assert operation == "negate", operation
        return f"fneg {first} {names}" if real else f"sub {first} zeroinitializer, {names}"

    def _write_constant(self, instruction: Instruction) -> None:
        (number,) = instruction.results
        self._names[number] = _literal(instruction.literal, self._kind(number), self._width)

    def _write_scale(self, instruction: Instruction) -> None:
        factor, tangent = instruction.arguments
        self._define(instruction.results[0], f"fmul {self._spread(factor, instruction)}, {self._name(tangent)}")

    def _write_add_scaled(self, instruction: Instruction) -> None:
        summand, factor, tangent = instruction.arguments
        operands = f"{self._spread(factor, instruction)}, {self._typed(tangent)}, {self._typed(summand)}"
        kind = self._kind(tangent)
        self._define(instruction.results[0], f"call {_type(kind, 1)} @llvm.fma.v{DIRECTIONS}f64({operands})")

    def _spread(self, factor: int, instruction: Instruction) -> str:
        """Write a tangent of which every element is a real; return it with its type."""
        kind, name = _type(Kind.TANGENT, self._width), f"%t{instruction.results[0]}"
        self._write(f"{name}.first = insertelement {kind} poison, {self._typed(factor)}, i32 0")
        zeros = f"<{DIRECTIONS} x i32> zeroinitializer"
        self._write(f"{name} = shufflevector {kind} {name}.first, {kind} poison, {zeros}")
        return f"{kind} {name}"

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
        memory = "ptr %memory" if callee.graph.has_allocations else ""
        symbol = f"@{_symbol(callee, self._width)}"
        self._write_call_of(instruction, symbol, callee.result_kinds, instruction.arguments, memory)

    def _write_call_address(self, instruction: Instruction) -> None:
        address, *arguments = instruction.arguments
        if self._width > 1:
            raise TraceError(f"{self._function.name}: a function at an address has no lanes")
        self._write_call_of(instruction, self._name(address), instruction.literal, tuple(arguments))

    def _write_call_of(
        self,
        instruction: Instruction,
        callee: str,
        result: tuple[Kind, ...],
        arguments: tuple[int, ...],
        memory: str = "",
    ) -> None:
        kind = _result_type(result, self._width)
        lanes = [f"<{self._width} x i1> {self._lanes}"] if self._width > 1 else []
        passed = [f"{_passed(self._kind(number), self._width)} {self._name(number)}" for number in arguments]
        passed += [memory] if memory else []
        call = f"call {'zeroext ' if kind == 'i1' else ''}{kind} {callee}({', '.join([*lanes, *passed])}){self._access}"
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
        kind, place = _MEMORY[code], f"%p{number}"
        self._write_place(instruction.arguments, offset, place)
        if code not in ("i4", "b1"):
            self._define(number, f"load {kind}, ptr {place}, align 8{self._access}")
            return
        self._write(f"{place}n = load {kind}, ptr {place}, align {4 if code == 'i4' else 1}{self._access}")
        self._define(number, f"sext i32 {place}n to i64" if code == "i4" else f"trunc i8 {place}n to i1")

    def _write_write(self, instruction: Instruction) -> None:
        (value, *address), (offset, code) = instruction.arguments, instruction.literal
        self._elements += 1
        kind, place, typed = _MEMORY[code], f"%q{self._elements}", self._typed(value)
        self._write_place(tuple(address), offset, place)
        if code in ("i4", "b1"):
            self._write(f"{place}n = " + (f"trunc {typed} to i32" if code == "i4" else f"zext {typed} to i8"))
            typed = f"{kind} {place}n"
        self._write(f"store {typed}, ptr {place}, align {dict(i4=4, b1=1).get(code, 8)}{self._access}")

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
        then, otherwise = instruction.literal
        condition, outside = self._typed(instruction.arguments[0]), self._lanes
        opposite = f"%{self._new_label('l')}"
        self._write(f"{opposite} = xor {condition}, {_literal(1, Kind.BOOLEAN, self._width)}")
        for block, side in ((then, self._name(instruction.arguments[0])), (otherwise, opposite)):
            self._check_purity(block)
            self._lanes = self._both(outside, side)
            self._write_block(block)
        self._lanes = outside
        for number, a, b in zip(instruction.results, then.results, otherwise.results, strict=True):
            self._define(number, f"select {condition}, {self._typed(a)}, {self._typed(b)}")

    def _check_purity(self, block: Block) -> None:
        if _stores(block):
            raise TraceError(f"{self._function.name}: a store in a branch or loop, which in lanes all would carry out")

    def _write_loop(self, instruction: Instruction) -> None:
        proceed, body = instruction.literal
        head, inside, end = self._new_label("head"), self._new_label("body"), self._new_label("end")
        before, mark = self._label, self._mark_memory(instruction)
        self._write(f"br label %{head}")
        self._begin(head)
        place = len(self._lines)  # of the phis, which name what the body results in
        condition, outside = self._name(self._write_turn(proceed, instruction)[0]), self._lanes
        if self._width > 1:
            self._lanes = self._both(outside, condition)
            condition = self._any_lane(self._lanes)
        self._write(f"br i1 {condition}, label %{inside}, label %{end}")
        self._begin(inside)
        self._sweep_memory(mark, instruction)
        access, hint = self._access, self._simd_hint() if self._is_simd(instruction) else ""
        following = [self._name(number) for number in self._write_turn(body, instruction)]
        self._access = access
        if self._width > 1:
            for block in instruction.literal:
                self._check_purity(block)
            following = self._keep_ended_lanes(instruction.results, following)
        self._lanes = outside
        self._write(f"br label %{head}{hint}")
        starts = zip(instruction.results, instruction.arguments, following, strict=True)
        self._lines[place:place] = [self._phi(number, first, before, after) for number, first, after in starts]
        self._begin(end)

    def _mark_memory(self, loop: Instruction) -> str:
        """Return the name of the last block of memory before a loop, none where it allocates nothing."""
        if self._is_simd(loop) or not any(map(allocates, loop.literal)):
            return ""
        mark = f"%{self._new_label('m')}"
        self._write(f"{mark} = load ptr, ptr %memory, align 8")
        return mark

    def _sweep_memory(self, mark: str, loop: Instruction) -> None:
        """Free what earlier turns of a loop have allocated and the turn that begins cannot reach."""
        if not mark:
            return
        roots = [self._name(number) for number in loop.results if self._kind(number) is Kind.ARRAY]
        sweep, swept, place = self._new_label("sweep"), self._new_label("swept"), f"%{self._new_label('roots')}"
        self._slots.append(f" {place} = alloca [{max(len(roots), 1)} x ptr], align 16")
        self._write(f"{place}.last = load ptr, ptr %memory, align 8")
        self._write(f"{place}.none = icmp eq ptr {place}.last, {mark}")
        self._write(f"br i1 {place}.none, label %{swept}, label %{sweep}")
        self._begin(sweep)
        for i, root in enumerate(roots):
            self._write(f"{place}.{i} = getelementptr inbounds ptr, ptr {place}, i64 {i}")
            self._write(f"store ptr {root}, ptr {place}.{i}, align 8")
        self._write(f"call void @sweep(ptr %memory, ptr {mark}, ptr {place}, i64 {len(roots)})")
        self._write(f"br label %{swept}")
        self._begin(swept)

    def _is_simd(self, loop: Instruction) -> bool:
        return bool(loop.results) and loop.results[0] in self._function.graph.simd_loops

    def _simd_hint(self) -> str:
        """Have what follows marked as part of a loop of independent turns; return what marks the loop's end."""
        accesses, independent, whole, loop = (next(self._nodes) for _ in range(4))
        self._access = f", !llvm.access.group !{accesses}"
        self._metadata += [
            f"!{accesses} = distinct !{{}}",
            f'!{independent} = !{{!"llvm.loop.parallel_accesses", !{accesses}}}',
            f'!{whole} = !{{!"llvm.loop.unroll.disable"}}',  # turns that were written out would become no lanes
            f"!{loop} = distinct !{{!{loop}, !{independent}, !{whole}}}",
        ]
        return f", !llvm.loop !{loop}"

    def _write_turn(self, block: Block, loop: Instruction) -> tuple[int, ...]:
        for number, parameter in zip(loop.results, block.parameters, strict=True):
            self._names[parameter] = self._name(number)
        self._write_block(block)
        return block.results

    def _both(self, lanes: str, condition: str) -> str:
        """Write which of the lanes a condition holds in; return its name."""
        name = f"%{self._new_label('l')}"
        self._write(f"{name} = and <{self._width} x i1> {lanes}, {condition}")
        return name

    def _any_lane(self, lanes: str) -> str:
        bits, flag = f"%{self._new_label('l')}", f"%{self._new_label('l')}"
        self._write(f"{bits} = bitcast <{self._width} x i1> {lanes} to i{self._width}")
        self._write(f"{flag} = icmp ne i{self._width} {bits}, 0")
        return flag

    def _keep_ended_lanes(self, state: tuple[int, ...], following: list[str]) -> list[str]:
        """Write selections of the new state where a lane goes on; return their names."""
        kept = []
        for number, new in zip(state, following, strict=True):
            kept.append(f"%{self._new_label('l')}")
            kind = _type(self._kind(number), self._width)
            choice = f"select <{self._width} x i1> {self._lanes}, {kind} {new}, {self._typed(number)}"
            self._write(f"{kept[-1]} = {choice}")
        return kept

    def _phi(self, number: int, first: int, before: str, after: str) -> str:
        pair = f"[{self._name(first)}, %{before}], [{after}, %{self._label}]"
        return f" {self._name(number)} = phi {_type(self._kind(number), self._width)} {pair}"
