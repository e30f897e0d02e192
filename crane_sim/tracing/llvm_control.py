"""Functions as text in LLVM's language: their heads, calls, branches and loops."""

from collections.abc import Iterator

from crane_sim.tracing.function import Function
from crane_sim.tracing.instructions import Instruction, Kind
from crane_sim.tracing.llvm_types import TYPES
from crane_sim.tracing.llvm_values import ValueText
from crane_sim.tracing.memory import allocates
from crane_sim.tracing.shared_arguments import Place

Places = dict[str, dict[int, Place]]
"""Parameters that functions read themselves, by the functions' names."""


def result_type(function: Function) -> str:
    """Return the type of what a function returns."""
    kinds = function.result_kinds
    if len(kinds) > 1:
        return f"%{function.name}.result"
    return TYPES[kinds[0]] if kinds else "void"


def result_definition(function: Function) -> str:
    """Return the definition of the type of what a function returns, several numbers."""
    members = ", ".join(TYPES[kind] for kind in function.result_kinds)
    return f"{result_type(function)} = type {{{members}}}"


def declaration(function: Function, places: Places) -> str:
    """Return the declaration of a function of another module."""
    known = places[function.name]
    kinds = [
        TYPES[function.graph.kinds[number]]
        for number in function.block.parameters
        if number not in known
    ]
    return (
        f"declare {result_type(function)} @{function.name}({', '.join((*kinds, 'ptr'))}) nounwind"
    )


class FunctionText(ValueText):
    """Writes one function."""

    def __init__(
        self,
        function: Function,
        exported: bool,
        inlined: bool,
        places: Places,
        nodes: Iterator[int],
    ) -> None:
        """Write it.

        Args:
            function: that is written.
            exported: it is called from outside the module.
            inlined: into what calls it.
            places: of all functions of the module, and of those that they call.
            nodes: numbers of metadata.
        """
        super().__init__(function, places[function.name], nodes)
        self._all_places = places
        self._write_block(function.block)
        self._write_results(function.block.results)
        parameters = [
            self._typed(number)
            for number in function.block.parameters
            if number not in self._places
        ]
        signature = (
            f"{result_type(function)} @{function.name}({', '.join((*parameters, 'ptr %memory'))})"
        )
        linkage, inlining = "" if exported else "internal ", " alwaysinline" if inlined else ""
        vectors = ' "prefer-vector-width"="512"' if function.graph.has_wide_vectors else ""
        head = f"define {linkage}{signature} nounwind{inlining}{vectors} {{"
        self.text = "\n".join(
            (*self.tables, head, "entry:", *self._head, *self._lines, "}", *self._metadata)
        )

    def _write_results(self, results: tuple[int, ...]) -> None:
        if len(results) <= 1:
            self._write("ret " + (self._typed(results[0]) if results else "void"))
            return
        kind, whole = result_type(self._function), "undef"
        for i, number in enumerate(results):
            self._write(f"%r{i} = insertvalue {kind} {whole}, {self._typed(number)}, {i}")
            whole = f"%r{i}"
        self._write(f"ret {kind} {whole}")

    def _write_call(self, instruction: Instruction) -> None:
        callee: Function = instruction.literal
        known, results = self._all_places[callee.name], instruction.results
        pairs = zip(callee.block.parameters, instruction.arguments, strict=True)
        passed = [self._typed(number) for parameter, number in pairs if parameter not in known]
        kind = result_type(callee)
        call = f"call {kind} @{callee.name}({', '.join((*passed, 'ptr %memory'))}){self._access}"
        if len(results) <= 1:
            self._write(f"{self._name(results[0])} = {call}" if results else call)
            return
        whole = f"%c{results[0]}"
        self._write(f"{whole} = {call}")
        for i, number in enumerate(results):
            self._define(number, f"extractvalue {kind} {whole}, {i}")

    def _write_branch(self, instruction: Instruction) -> None:
        then, otherwise, end = (
            self._new_label("then"),
            self._new_label("else"),
            self._new_label("end"),
        )
        self._write(
            f"br {self._typed(instruction.arguments[0])}, label %{then}, label %{otherwise}"
        )
        sides = []
        for label, block in zip((then, otherwise), instruction.literal, strict=True):
            self._begin(label)
            self._write_block(block)
            sides.append(self._origins(block.results))
            self._write(f"br label %{end}")
        self._begin(end)
        for number, *origins in zip(instruction.results, *sides, strict=True):
            self._lines.append(self._phi(number, *origins))

    def _origins(self, numbers: tuple[int, ...]) -> list[str]:
        """Return values as a phi takes them from the end of the present basic block."""
        names = list(map(self._name, numbers))  # which may read them
        return [f"[{name}, %{self._label}]" for name in names]

    def _phi(self, number: int, *origins: str) -> str:
        return f" {self._name(number)} = phi {TYPES[self._kind(number)]} {', '.join(origins)}"

    def _write_loop(self, loop: Instruction) -> None:
        proceed, body = loop.literal
        head, inside, end = self._new_label("head"), self._new_label("body"), self._new_label("end")
        mark, starts = self._mark_memory(loop), self._origins(loop.arguments)
        self._write(f"br label %{head}")
        self._begin(head)
        place = len(self._lines)  # of the phis, which name what the body results in
        for block in loop.literal:
            self._names.update(zip(block.parameters, map(self._name, loop.results), strict=True))
        self._write_block(proceed)
        self._write(f"br {self._typed(proceed.results[0])}, label %{inside}, label %{end}")
        self._begin(inside)
        self._sweep_memory(mark, loop)
        access, hint = self._access, self._loop_hint(loop)
        self._write_block(body)
        self._access, turns = access, self._origins(body.results)
        self._write(f"br label %{head}{hint}")
        self._lines[place:place] = map(self._phi, loop.results, starts, turns)
        self._begin(end)

    def _mark_memory(self, loop: Instruction) -> str:
        """Return the last memory block's name before a loop, or none without allocations."""
        if self._is_simd(loop) or not any(map(allocates, loop.literal)):
            return ""
        mark = f"%{self._new_label('m')}"
        self._write(f"{mark} = load ptr, ptr %memory, align 8")
        return mark

    def _sweep_memory(self, mark: str, loop: Instruction) -> None:
        """Free what a loop's earlier turns allocated and the beginning one cannot reach."""
        if not mark:
            return
        roots = [self._name(number) for number in loop.results if self._kind(number) is Kind.ARRAY]
        sweep, swept, place = (
            self._new_label("sweep"),
            self._new_label("swept"),
            f"%{self._new_label('roots')}",
        )
        self._head.append(f" {place} = alloca [{max(len(roots), 1)} x ptr], align 16")
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

    def _loop_hint(self, loop: Instruction) -> str:
        """Mark what follows where a loop's turns are independent; return its end's mark."""
        hint, node = next(self._nodes), next(self._nodes)
        if self._is_simd(loop):
            accesses = next(self._nodes)
            self._access = f", !llvm.access.group !{accesses}"
            self._metadata.append(f"!{accesses} = distinct !{{}}")
            says = f'!"llvm.loop.parallel_accesses", !{accesses}'
        else:
            # most are short: lanes take long to compile
            says = '!"llvm.loop.vectorize.enable", i1 false'
        self._metadata += [f"!{hint} = !{{{says}}}", f"!{node} = distinct !{{!{node}, !{hint}}}"]
        return f", !llvm.loop !{node}"
