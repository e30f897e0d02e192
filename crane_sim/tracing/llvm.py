"""Text of traced functions in LLVM's language: for one crane, or for several, one in each lane of vectors.

In lanes, every real, integer and condition is a vector; element i of an array is the `width` reals from i × width on.
A branch computes both sides and selects, a loop goes on until no lane does. Each function is given the lanes whose
results are used, so that a loop on the side that a lane does not take ends. What is called from outside passes all.

Arrays of one call are distinct memory: where they overlap, an element that is written may be read as it was.
"""

import itertools
from collections import Counter
from collections.abc import Iterator

from crane_sim.tracing.elementary import OFTEN_SMALL_SINCOS, SINCOS
from crane_sim.tracing.function import Function, callees, functions_with_callees
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.llvm_control import ControlText
from crane_sim.tracing.llvm_types import (
    TYPES,
    all_lanes,
    argument_type,
    declaration,
    declarations,
    result_definition,
    result_type,
    symbol_of,
    type_of,
)
from crane_sim.tracing.trace_error import TraceError


def module_text(*functions: Function, width: int = 1) -> str:
    """Return a module in which these functions can be called from outside.

    In lanes they take a real as one for all lanes, and return nothing.

    Raises:
        TraceError: two functions have one name, or one returns what a caller outside could not take.
    """
    for function in functions:
        if len(function.block.results) > 1:
            raise TraceError(f"{function.name} returns several numbers, which no caller outside could take")
    everything = functions_with_callees(*functions)
    entries = [_entry(f, width) for f in functions if width > 1]
    return _module(everything, {f.name for f in functions}, [], width) + "\n".join((*entries, ""))


def module_texts(entry: Function) -> tuple[str, str]:
    """Return (the module of a function, that of its loops that are to become lanes), which are linked.

    LLVM makes lanes in a sequence of passes that takes three times as long as those that other code needs.
    """
    loops = functions_with_callees(*_functions_with_lanes(entry), follows=_is_with_loops)
    outer = [f for loop in loops for f in callees(loop.block) if not _is_with_loops(f)]
    rest = functions_with_callees(entry, *outer, follows=lambda f: not f.graph.simd_loops)
    rest = [OFTEN_SMALL_SINCOS if f is SINCOS else f for f in rest]
    inner = [f for f in loops if f.graph.simd_loops]
    main = _module(rest, {entry.name, *(f.name for f in outer)}, inner)
    return main, _module(loops, {f.name for f in inner}, outer) if loops else ""


def _functions_with_lanes(entry: Function) -> list[Function]:
    return [f for f in functions_with_callees(entry) if f.graph.simd_loops]


def _is_with_loops(function: Function) -> bool:
    """Return whether a function that one with lanes calls is part of their module."""
    return function.inlined or bool(function.graph.simd_loops)


def _module(functions: list[Function], exported: set[str], outer: list[Function], width: int = 1) -> str:
    """Return the module of functions, each after those that it calls; `outer` are those of another module."""
    nodes = itertools.count()  # of metadata
    inlined = _inlined_names(functions, exported)
    others = {f.name: f for f in outer}
    texts = [_FunctionText(f, f.name in exported, f.name in inlined, width, nodes).text for f in functions]
    heads = [declaration(f) for f in others.values()]
    types = [result_definition(f, width) for f in (*others.values(), *functions) if len(f.block.results) > 1]
    return "\n".join((*declarations(width), *types, *heads, *texts, ""))


def _inlined_names(functions: list[Function], exported: set[str]) -> set[str]:
    """Return the functions that are inlined: those that are marked, and those that are called at one place then."""
    calls, names = Counter[str](), set[str]()
    for function in reversed(functions):
        copies = 1
        if function.name not in exported and (function.inlined or calls[function.name] == 1):
            names.add(function.name)
            copies = calls[function.name]
        for callee in callees(function.block):
            calls[callee.name] += copies
    return names


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

    def __init__(self, function: Function, exported: bool, inlined: bool, width: int, nodes: Iterator[int]) -> None:
        super().__init__(function, width, nodes)
        body, head = self._body(), self._head(exported, inlined)
        self.text = "\n".join((*self.tables, head, "entry:", *self._slots, *body, "}", *self._metadata))

    def _head(self, exported: bool, inlined: bool) -> str:
        function, internal = self._function, not exported or self._width > 1
        parameters = [self._parameter(number) for number in function.block.parameters]
        parameters += ["ptr %memory"] if function.graph.has_allocations else []
        lanes = [f"<{self._width} x i1> %lanes"] if self._width > 1 else []
        linkage, inlining = "internal " if internal else "", " alwaysinline" if inlined else ""
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
        return result_type(self._function, self._width)

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
