"""Calls, branches and loops as text in LLVM's language.

In lanes a branch computes both sides and selects, and a loop goes on until no lane does.
"""

from crane_sim.tracing.function import Function
from crane_sim.tracing.instructions import Block, Instruction, Kind
from crane_sim.tracing.llvm_memory import MemoryText
from crane_sim.tracing.llvm_types import argument_type, literal_text, result_type, symbol_of, type_of
from crane_sim.tracing.memory import allocates
from crane_sim.tracing.trace_error import TraceError


def _stores(block: Block) -> bool:
    """Return whether a block, or what it calls, may write memory."""
    for instruction in block.instructions:
        operation, literal = instruction.operation, instruction.literal
        inner = literal if operation in ("branch", "loop") else (literal.block,) if operation == "call" else ()
        if operation in ("store", "call_address") or any(map(_stores, inner)):
            return True
    return False


class ControlText(MemoryText):
    """Writes what decides on the order of instructions."""

    def _write_call(self, instruction: Instruction) -> None:
        callee: Function = instruction.literal
        memory = "ptr %memory" if callee.graph.has_allocations else ""
        symbol = f"@{symbol_of(callee, self._width)}"
        self._write_call_of(instruction, symbol, result_type(callee, self._width), instruction.arguments, memory)

    def _write_call_address(self, instruction: Instruction) -> None:
        address, *arguments = instruction.arguments
        if self._width > 1:
            raise TraceError(f"{self._function.name}: a function at an address has no lanes")
        kind = type_of(instruction.literal[0], 1) if instruction.literal else "void"
        self._write_call_of(instruction, self._name(address), kind, tuple(arguments))

    def _write_call_of(
        self,
        instruction: Instruction,
        callee: str,
        kind: str,
        arguments: tuple[int, ...],
        memory: str = "",
    ) -> None:
        lanes = [f"<{self._width} x i1> {self._lanes}"] if self._width > 1 else []
        passed = [f"{argument_type(self._kind(number), self._width)} {self._name(number)}" for number in arguments]
        passed += [memory] if memory else []
        call = f"call {'zeroext ' if kind == 'i1' else ''}{kind} {callee}({', '.join([*lanes, *passed])}){self._access}"
        if len(instruction.results) <= 1:
            self._write(f"{self._name(instruction.results[0])} = {call}" if instruction.results else call)
            return
        whole = f"%c{instruction.results[0]}"
        self._write(f"{whole} = {call}")
        for i, number in enumerate(instruction.results):
            self._define(number, f"extractvalue {kind} {whole}, {i}")

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
            self._define(number, f"phi {type_of(self._kind(number), 1)} {values}")

    def _write_both_sides(self, instruction: Instruction) -> None:
        then, otherwise = instruction.literal
        condition, outside = self._typed(instruction.arguments[0]), self._lanes
        opposite = f"%{self._new_label('l')}"
        self._write(f"{opposite} = xor {condition}, {literal_text(1, Kind.BOOLEAN, self._width)}")
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
        access, hint = self._access, self._loop_hint(instruction)
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

    def _loop_hint(self, loop: Instruction) -> str:
        """Have what follows marked where a loop's turns are independent; return what marks the loop's end."""
        hint, node = next(self._nodes), next(self._nodes)
        if not self._is_simd(loop):
            self._metadata += [
                f'!{hint} = !{{!"llvm.loop.vectorize.enable", i1 false}}',  # most are short: lanes take long to compile
                f"!{node} = distinct !{{!{node}, !{hint}}}",
            ]
            return f", !llvm.loop !{node}"
        accesses = next(self._nodes)
        self._access = f", !llvm.access.group !{accesses}"
        self._metadata += [
            f"!{accesses} = distinct !{{}}",
            f'!{hint} = !{{!"llvm.loop.parallel_accesses", !{accesses}}}',
            f"!{node} = distinct !{{!{node}, !{hint}}}",
        ]
        return f", !llvm.loop !{node}"

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
            kind = type_of(self._kind(number), self._width)
            choice = f"select <{self._width} x i1> {self._lanes}, {kind} {new}, {self._typed(number)}"
            self._write(f"{kept[-1]} = {choice}")
        return kept

    def _phi(self, number: int, first: int, before: str, after: str) -> str:
        pair = f"[{self._name(first)}, %{before}], [{after}, %{self._label}]"
        return f" {self._name(number)} = phi {type_of(self._kind(number), self._width)} {pair}"
