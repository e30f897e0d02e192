"""Traced functions as C source (C99) that needs nothing but the C library.

Compile it without contraction of products and sums (`-ffp-contract=off`): what is rounded once stands there as `fma`;
and without another way to powers (`-fno-builtin-pow`): x x has not always the bits of pow(x, 2).
"""

import math
from collections.abc import Callable

from crane_sim.tracing.function import Function, functions_with_callees
from crane_sim.tracing.instructions import Block, Instruction, Kind

_TYPES = {
    Kind.REAL: "double",
    Kind.INTEGER: "int64_t",
    Kind.BOOLEAN: "int",
    Kind.ARRAY: "double *",
    Kind.FUNCTION: "function",
}
_HEAD = "#include <math.h>\n#include <stdint.h>\n\ntypedef void (*function)(void);"
_BINARY = {
    "add": "+",
    "subtract": "-",
    "multiply": "*",
    "divide": "/",
    "less": "<",
    "less_equal": "<=",
    "equal": "==",
    "unequal": "!=",
    "both": "&",
}
_CALLED = {"sqrt": "sqrt", "absolute": "fabs", "fma": "fma", "exp": "exp", "power": "pow"}


def c_source(*functions: Function) -> str:
    """Return the source of functions that can be called from outside, and of all that they call."""
    exported = {function.name for function in functions}
    texts = [_FunctionSource(f, f.name in exported).text for f in functions_with_callees(*functions)]
    return "\n\n".join((_HEAD, *texts)) + "\n"


class _FunctionSource:
    """Writes one function; a value is named by its number."""

    def __init__(self, function: Function, exported: bool) -> None:
        self._function = function
        self._lines: list[str] = []
        self._indent = 1
        parameters = ", ".join(self._declaration(number) for number in function.block.parameters)
        self._write_block(function.block)
        self._write_results(function.block.results)
        head = f"{'' if exported else 'static '}{self._result_type(function)} {function.name}({parameters or 'void'})"
        self.text = "\n".join((*self._result_struct(function), f"{head} {{", *self._lines, "}"))

    def _result_type(self, function: Function) -> str:
        kinds = function.result_kinds
        if len(kinds) > 1:
            return f"struct {function.name}_result"
        return _TYPES[kinds[0]] if kinds else "void"

    def _result_struct(self, function: Function) -> list[str]:
        kinds = function.result_kinds
        if len(kinds) < 2:
            return []
        fields = " ".join(f"{_TYPES[kind]} r{i};" for i, kind in enumerate(kinds))
        return [f"struct {function.name}_result {{ {fields} }};"]

    def _kind(self, number: int) -> Kind:
        return self._function.graph.kinds[number]

    def _declaration(self, number: int) -> str:
        return f"{_TYPES[self._kind(number)]} v{number}"

    def _write(self, line: str) -> None:
        self._lines.append("    " * self._indent + line)

    def _write_results(self, results: tuple[int, ...]) -> None:
        if len(results) == 1:
            self._write(f"return v{results[0]};")
        elif results:
            values = ", ".join(f"v{number}" for number in results)
            self._write(f"return ({self._result_type(self._function)}){{ {values} }};")

    def _write_block(self, block: Block) -> None:
        for instruction in block.instructions:
            writer: Callable[[Instruction], None] | None = getattr(self, f"_write_{instruction.operation}", None)
            if writer:
                writer(instruction)
            else:
                self._write(f"const {self._declaration(instruction.results[0])} = {self._expression(instruction)};")

    def _expression(self, instruction: Instruction) -> str:
        operation, names = instruction.operation, [f"v{number}" for number in instruction.arguments]
        if operation == "constant":
            return _literal(instruction.literal)
        if operation in _BINARY:
            return f"{names[0]} {_BINARY[operation]} {names[1]}"
        if operation in _CALLED:
            return f"{_CALLED[operation]}({', '.join(names)})"
        if operation == "select":
            return f"{names[0]} ? {names[1]} : {names[2]}"
        if operation == "negate":
            return f"-{names[0]}"
        if operation == "load":
            return f"*({self._place(instruction.arguments, instruction.literal)})"
        if operation == "to_real":
            return f"(double){names[0]}"
        assert operation == "to_integer", operation
        return f"(int64_t){names[0]}"

    def _place(self, arguments: tuple[int, ...], offset: int) -> str:
        return " + ".join([f"v{number}" for number in arguments] + ([str(offset)] if offset else []))

    def _write_address(self, instruction: Instruction) -> None:
        place = self._place(instruction.arguments, instruction.literal)
        self._write(f"{self._declaration(instruction.results[0])} = {place};")

    def _write_store(self, instruction: Instruction) -> None:
        value, *place = instruction.arguments
        self._write(f"*({self._place(tuple(place), instruction.literal)}) = v{value};")

    def _write_call(self, instruction: Instruction) -> None:
        callee: Function = instruction.literal
        call = f"{callee.name}({', '.join(f'v{number}' for number in instruction.arguments)})"
        results = instruction.results
        if len(results) < 2:
            self._write(f"const {self._declaration(results[0])} = {call};" if results else f"{call};")
            return
        self._write(f"const {self._result_type(callee)} c{results[0]} = {call};")
        for i, number in enumerate(results):
            self._write(f"const {self._declaration(number)} = c{results[0]}.r{i};")

    def _write_call_address(self, instruction: Instruction) -> None:
        address, *arguments = instruction.arguments
        result = _TYPES[instruction.literal[0]] if instruction.literal else "void"
        kinds = ", ".join(_TYPES[self._kind(number)] for number in arguments) or "void"
        call = f"(({result} (*)({kinds}))v{address})({', '.join(f'v{number}' for number in arguments)})"
        results = instruction.results
        self._write(f"const {self._declaration(results[0])} = {call};" if results else f"{call};")

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
            self._write(f"{self._declaration(number)} = v{start};")
        self._write("for (;;) {")
        self._name_parameters(proceed, instruction.results)
        self._indent += 1
        self._write_block(proceed)
        self._write(f"if (!v{proceed.results[0]}) break;")
        self._indent -= 1
        self._name_parameters(body, instruction.results)
        self._write_inner(body, instruction.results)
        self._write("}")

    def _name_parameters(self, block: Block, state: tuple[int, ...]) -> None:
        self._indent += 1
        for parameter, number in zip(block.parameters, state, strict=True):
            self._write(f"const {self._declaration(parameter)} = v{number};")
        self._indent -= 1

    def _write_inner(self, block: Block, targets: tuple[int, ...]) -> None:
        self._indent += 1
        self._write_block(block)
        for number, result in zip(targets, block.results, strict=True):
            self._write(f"v{number} = v{result};")
        self._indent -= 1


def _literal(number: float | int) -> str:
    if isinstance(number, int):
        return f"INT64_C({int(number)})"
    if math.isnan(number):
        return "NAN"
    if math.isinf(number):
        return "INFINITY" if number > 0.0 else "-INFINITY"
    return number.hex()
