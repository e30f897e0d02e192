"""Traced functions as C source (C99) that needs nothing but the C library.

Compile it without contraction of products and sums (`-ffp-contract=off`): what is rounded once
stands there as `fma`; and without another way to powers (`-fno-builtin-pow`): x x has not always
the bits of pow(x, 2).
"""

import math
import struct
from collections.abc import Callable

from crane_sim.tracing.function import Function, functions_with_callees
from crane_sim.tracing.instructions import DIRECTIONS, Block, Instruction, Kind

_TYPES = {
    Kind.REAL: "double",
    Kind.INTEGER: "int64_t",
    Kind.WORD: "uint64_t",
    Kind.BOOLEAN: "uint8_t",
    Kind.ARRAY: "char *",
    Kind.TANGENT: "struct tangent",
}
_MEMORY_TYPES = {
    **{
        "f8": "double",
        "i8": "int64_t",
        "u8": "uint64_t",
        "i4": "int32_t",
        "b1": "uint8_t",
        "p8": "char *",
    },
    "t8": "struct tangent",
}
_ARITHMETIC = {"add": "+", "subtract": "-", "multiply": "*", "divide": "/"}
_BINARY = {
    **{
        "less": "<",
        "less_equal": "<=",
        "equal": "==",
        "unequal": "!=",
        "both": "&",
        "either": "|",
        "differ": "^",
    },
    **{"shift_right": ">>", "quotient": "/", "remainder": "%"},
}
_CALLED = {
    **{
        name: name
        for name in (
            "sqrt",
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
        )
    },
    **{name: name for name in ("cosh", "atan2", "hypot", "fmod", "fma", "floor", "ceil")},
    **{
        "add_scaled": "add_scaled",
        "scale": "scale",
        "absolute": "fabs",
        "power": "pow",
        "round": "rint",
        "copy_sign": "copysign",
    },
}
_CONVERSIONS = {
    "to_real": "double",
    "to_integer": "int64_t",
    "flag_to_integer": "int64_t",
    "to_word": "uint64_t",
    "word_to_integer": "int64_t",
}
_HEAD = f"""#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct block {{ struct block *next; }};

struct tangent {{ double along[{DIRECTIONS}]; }};

static inline struct tangent add_scaled(struct tangent x, double factor, struct tangent y) {{
    for (int i = 0; i < {DIRECTIONS}; i++) x.along[i] = fma(factor, y.along[i], x.along[i]);
    return x;
}}

static inline struct tangent scale(double factor, struct tangent x) {{
    for (int i = 0; i < {DIRECTIONS}; i++) x.along[i] *= factor;
    return x;
}}

static inline char *allocate(struct block **memory, int64_t size) {{
    struct block *block = malloc(64 + (size_t)size);
    block->next = *memory;
    *memory = block;
    return (char *)block + 64;
}}

static inline void release(struct block *block) {{
    while (block) {{
        struct block *next = block->next;
        free(block);
        block = next;
    }}
}}
"""


def c_source(function: Function, name: str) -> str:
    """Return the source of a function that C calls by a name, of no result, and of its callees."""
    functions = functions_with_callees(function)
    texts = [_FunctionSource(f).text for f in functions]
    kinds = list(zip(function.block.parameters, function.parameter_kinds, strict=True))
    parameters = ", ".join(_parameter(kind, number) for number, kind in kinds)
    passed = "".join(
        f", (char *)v{number}" if kind is Kind.ARRAY else f", v{number}" for number, kind in kinds
    )
    entry = (
        f"void {name}({parameters}) {{\n    struct block *memory = NULL;\n"
        f"    {_name_of(function)}(&memory{passed});\n    release(memory);\n}}"
    )
    readers = [_ACCESS.format(code=code, kind=kind) for code, kind in _MEMORY_TYPES.items()]
    return "\n".join((_HEAD, *readers, *texts, entry, ""))


_ACCESS = """static inline {kind} read_{code}(const char *place) {{
    {kind} value;
    memcpy(&value, place, sizeof value);
    return value;
}}

static inline void write_{code}(char *place, {kind} value) {{
    memcpy(place, &value, sizeof value);
}}
"""


def _parameter(kind: Kind, number: int) -> str:
    return f"double *v{number}" if kind is Kind.ARRAY else f"{_TYPES[kind]} v{number}"


def _name_of(function: Function) -> str:
    return function.name.replace(".", "_")


class _FunctionSource:
    """Writes one function; a value is named by its number."""

    def __init__(self, function: Function) -> None:
        self._function = function
        self._lines: list[str] = []
        self._slots: list[str] = []
        self._tables: list[str] = []
        self._indent = 1
        self._write_block(function.block)
        self._write_results(function.block.results)
        parameters = "".join(
            f", {self._declaration(number)}" for number in function.block.parameters
        )
        name = f"static {self._result_type(function)} {_name_of(function)}"
        head = f"{name}(struct block **memory{parameters}) {{"
        top = (*self._result_struct(), *self._tables, head, *self._slots)
        self.text = "\n".join((*top, *self._lines, "}", ""))

    def _result_type(self, function: Function) -> str:
        kinds = function.result_kinds
        if len(kinds) > 1:
            return f"struct {_name_of(function)}_result"
        return _TYPES[kinds[0]] if kinds else "void"

    def _result_struct(self) -> list[str]:
        kinds = self._function.result_kinds
        if len(kinds) < 2:
            return []
        fields = " ".join(f"{_TYPES[kind]} r{i};" for i, kind in enumerate(kinds))
        return [f"{self._result_type(self._function)} {{ {fields} }};"]

    def _kind(self, number: int) -> Kind:
        return self._function.graph.kinds[number]

    def _declaration(self, number: int) -> str:
        return f"{_TYPES[self._kind(number)]} v{number}"

    def _write(self, line: str) -> None:
        self._lines.append("    " * self._indent + line)

    def _define(self, number: int, expression: str) -> None:
        self._write(f"{self._declaration(number)} = {expression};")

    def _write_results(self, results: tuple[int, ...]) -> None:
        self._write("(void)memory;")
        if len(results) == 1:
            self._write(f"return v{results[0]};")
        elif results:
            values = ", ".join(f"v{number}" for number in results)
            self._write(f"return ({self._result_type(self._function)}){{ {values} }};")

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
        operation, names = instruction.operation, [f"v{number}" for number in instruction.arguments]
        if operation == "constant":
            tangent = self._kind(instruction.results[0]) is Kind.TANGENT
            return "{ { 0.0 } }" if tangent else _literal(instruction.literal)
        if operation in _ARITHMETIC:
            return self._arithmetic(_ARITHMETIC[operation], instruction)
        if operation in _BINARY:
            return f"{names[0]} {_BINARY[operation]} {names[1]}"
        if operation in _CALLED:
            return f"{_CALLED[operation]}({', '.join(names)})"
        if operation in _CONVERSIONS:
            return f"({_CONVERSIONS[operation]}){names[0]}"
        if operation == "select":
            return f"{names[0]} ? {names[1]} : {names[2]}"
        if operation == "shift_left":
            return (
                f"({_TYPES[self._kind(instruction.results[0])]})((uint64_t){names[0]} << "
                f"{names[1]})"
            )
        if operation == "negate":
            real = self._kind(instruction.results[0]) is Kind.REAL
            return f"-{names[0]}" if real else f"(int64_t)(0 - (uint64_t){names[0]})"
        raise AssertionError(operation)

    def _arithmetic(self, operator: str, instruction: Instruction) -> str:
        """Return a sum, difference, product or quotient; of integers it wraps, as machine code."""
        a, b = (f"v{number}" for number in instruction.arguments)
        if self._kind(instruction.results[0]) is Kind.INTEGER:
            return f"(int64_t)((uint64_t){a} {operator} (uint64_t){b})"
        return f"{a} {operator} {b}"

    # memory

    def _write_table(self, instruction: Instruction) -> None:
        name = f"{_name_of(self._function)}_table{instruction.results[0]}"
        words = struct.unpack(f"<{len(instruction.literal) // 8}Q", instruction.literal)
        elements = ", ".join(f"UINT64_C({word})" for word in words)
        self._tables.append(f"static uint64_t {name}[] = {{ {elements} }};")
        self._define(instruction.results[0], f"(char *){name}")

    def _write_slot(self, instruction: Instruction) -> None:
        (number,) = instruction.results
        self._slots.append(f"    uint64_t s{number}[{max(instruction.literal, 1)}];")
        self._slots.append(f"    char *v{number} = (char *)s{number};")

    def _write_allocate(self, instruction: Instruction) -> None:
        self._define(instruction.results[0], f"allocate(memory, v{instruction.arguments[0]})")

    def _write_move(self, instruction: Instruction) -> None:
        self._define(
            instruction.results[0], self._place(instruction.arguments, instruction.literal)
        )

    def _place(self, arguments: tuple[int, ...], offset: int) -> str:
        return " + ".join(
            [f"v{number}" for number in arguments] + ([str(offset)] if offset else [])
        )

    def _write_read(self, instruction: Instruction) -> None:
        offset, code = instruction.literal
        self._define(
            instruction.results[0], f"read_{code}({self._place(instruction.arguments, offset)})"
        )

    def _write_write(self, instruction: Instruction) -> None:
        (value, *address), (offset, code) = instruction.arguments, instruction.literal
        self._write(f"write_{code}({self._place(tuple(address), offset)}, v{value});")

    # calls, branches and loops

    def _write_call(self, instruction: Instruction) -> None:
        callee: Function = instruction.literal
        results = instruction.results
        passed = "".join(f", v{number}" for number in instruction.arguments)
        call = f"{_name_of(callee)}(memory{passed})"
        if len(results) < 2:
            self._write(f"{self._declaration(results[0])} = {call};" if results else f"{call};")
            return
        self._write(f"{self._result_type(callee)} c{results[0]} = {call};")
        for i, number in enumerate(results):
            self._define(number, f"c{results[0]}.r{i}")

    def _write_branch(self, instruction: Instruction) -> None:
        then, otherwise = instruction.literal
        for number in instruction.results:
            self._write(f"{self._declaration(number)};")
        self._write(f"if (v{instruction.arguments[0]}) {{")
        self._write_inner(then, instruction.results)
        self._write("} else {")
        self._write_inner(otherwise, instruction.results)
        self._write("}")

    def _write_loop(self, instruction: Instruction) -> None:
        proceed, body = instruction.literal
        for number, start in zip(instruction.results, instruction.arguments, strict=True):
            self._define(number, f"v{start}")
        self._write("for (;;) {")
        self._indent += 1
        self._name_parameters(proceed, instruction.results)
        self._write_block(proceed)
        self._write(f"if (!v{proceed.results[0]}) break;")
        self._name_parameters(body, instruction.results)
        self._indent -= 1
        self._write_inner(body, instruction.results)
        self._write("}")

    def _name_parameters(self, block: Block, state: tuple[int, ...]) -> None:
        for parameter, number in zip(block.parameters, state, strict=True):
            self._define(parameter, f"v{number}")

    def _write_inner(self, block: Block, targets: tuple[int, ...]) -> None:
        self._indent += 1
        self._write_block(block)
        for number, result in zip(targets, block.results, strict=True):
            self._write(f"v{number} = v{result};")
        self._indent -= 1


def _literal(number: float | int) -> str:
    if isinstance(number, bool):
        return str(int(number))
    if isinstance(number, int):
        return f"(int64_t)UINT64_C({number % 2**64})"
    if math.isnan(number):
        return "NAN"
    if math.isinf(number):
        return "INFINITY" if number > 0.0 else "-INFINITY"
    return number.hex()
