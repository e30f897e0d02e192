"""Text of traced functions in LLVM's language: for one crane, or for several, one in each lane of vectors.

In lanes, every real, integer and condition is a vector; element i of an array is the `width` reals from i × width on.
A branch computes both sides and selects, a loop goes on until no lane does. Each function is given the lanes whose
results are used, so that a loop on the side that a lane does not take ends. What is called from outside passes all.

Arrays of one call are distinct memory: where they overlap, an element that is written may be read as it was.
"""

import itertools
from collections.abc import Iterator

from crane_sim.tracing.function import Function, functions_with_callees
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.llvm_control import ControlText
from crane_sim.tracing.llvm_types import TYPES, all_lanes, argument_type, declarations, result_type, symbol_of, type_of
from crane_sim.tracing.trace_error import TraceError


def module_text(*functions: Function, width: int = 1) -> str:
    """Return a module in which these functions can be called from outside.

    In lanes they take a real as one for all lanes, and return nothing.
    """
    exported = {function.name for function in functions}
    nodes = itertools.count()  # of metadata
    texts = [_FunctionText(f, f.name in exported, width, nodes).text for f in functions_with_callees(*functions)]
    entries = [_entry(f, width) for f in functions if width > 1]
    return "\n".join((*declarations(width), *texts, *entries, ""))


def _entry(function: Function, width: int) -> str:
    """Return the function that is called from outside, in lanes."""
    if function.block.results:
        raise TraceError(f"{function.name} returns a number, which in lanes no caller outside could take")
    kinds, lines, zeros = function.parameter_kinds, [], f"<{width} x i32> zeroinitializer"
    for i, kind in enumerate(kinds):
        scalar, vector = TYPES[kind], type_of(kind, width)
        if vector != scalar:
            lines.append(f" %first{i} = insertelement {vector} undef, {scalar} %a{i}, i32 0")
            lines.append(f" %v{i} = shufflevector {vector} %first{i}, {vector} undef, {zeros}")
    parameters = ", ".join(f"{argument_type(kind, 1)} %{'a' if type_of(kind, width) != TYPES[kind] else 'v'}{i}"
                           for i, kind in enumerate(kinds))  # fmt: skip
    arguments = ", ".join([all_lanes(width), *(f"{type_of(kind, width)} %v{i}" for i, kind in enumerate(kinds))])
    lines.append(f" call void @{symbol_of(function, width)}({arguments})")
    return "\n".join((f"define void @{function.name}({parameters}) nounwind {{", *lines, " ret void", "}"))


class _FunctionText(ControlText):
    """Writes one function."""

    def __init__(self, function: Function, exported: bool, width: int, nodes: Iterator[int]) -> None:
        super().__init__(function, width, nodes)
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
        signature = f"{self._result} @{symbol_of(function, self._width)}({', '.join([*lanes, *parameters])})"
        vectors = ' "prefer-vector-width"="512"' if function.graph.has_wide_vectors else ""
        return f"define {linkage}{zeroext}{signature} nounwind{inlining}{vectors} {{"

    def _parameter(self, number: int) -> str:
        kind = self._kind(number)
        distinct = kind is Kind.ARRAY and self._function.distinct
        passed = "ptr noalias" if distinct else argument_type(kind, self._width)
        return f"{passed} {self._name(number)}"

    @property
    def _result(self) -> str:
        return result_type(self._function.result_kinds, self._width)

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
