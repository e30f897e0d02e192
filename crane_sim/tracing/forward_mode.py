"""Forward mode: functions traced anew, with derivatives of their numbers along directions.

Each instruction is kept as it is, so values have the bits of the function itself; beside it stand
those of the rule of its derivative. A real that moves has a tangent, its derivatives along
`DIRECTIONS` directions at once; memory of reals that move has memory of their tangents,
`DIRECTIONS` times as large, at the same places. What does not move has neither, and costs nothing:
that memory needs tangents is found where one is to be stored in it, and the function is transformed
again.
"""

from collections.abc import Iterable
from itertools import count
from typing import Any, NamedTuple

from crane_sim.tracing.arithmetic import combine
from crane_sim.tracing.derivative_rules import FLAT, RULES
from crane_sim.tracing.function import Function
from crane_sim.tracing.graph import Graph, OpenBlock, Value, numbers_of
from crane_sim.tracing.instructions import DIRECTIONS, Block, Instruction, Kind
from crane_sim.tracing.trace_error import TraceError

Origin = Any
"""What an address comes from: the number of a value, or (number of a slot, offset of an address
that it keeps)."""


_NUMBERS = count()
"""Of derivatives: traces of several entry points share functions, whose names differ."""


class Dual(NamedTuple):
    """A value and its tangent: derivatives of a real, tangents' address of an address, or None.

    None stands for a value that does not move.
    """

    value: Value
    tangent: Value | None = None


class Transformed(NamedTuple):
    """A function with derivatives: tangents of moving arguments stand behind all arguments."""

    function: Function
    moved: tuple[bool, ...]  # results that have a tangent, which stand behind all results


class ArgumentsNeeded(Exception):
    """Tangents are stored in arguments that have none."""

    def __init__(self, indices: frozenset[int]) -> None:
        super().__init__(str(sorted(indices)))
        self.indices = indices


class _TangentsNeeded(Exception):
    """What comes from some origins needs tangents."""

    def __init__(self, origins: Iterable[Origin]) -> None:
        super().__init__()
        self.origins = set(origins)


class ForwardMode:
    """Functions with derivatives, each transformed once for the arguments that move."""

    def __init__(self) -> None:
        """Begin without functions."""
        self._transformed: dict[Any, Transformed | frozenset[int]] = {}

    def transform(
        self, function: Function, moved: tuple[bool, ...], needed: frozenset[int]
    ) -> Transformed:
        """Return a function with derivatives.

        Args:
            function: to be transformed.
            moved: arguments that have a tangent.
            needed: results, addresses, that need one.

        Raises:
            ArgumentsNeeded: other arguments need a tangent.
            TraceError: an operation has no derivative.
        """
        key = function.name, id(function), moved, needed
        if key not in self._transformed:
            self._transformed[key] = self._transform(function, moved, needed)
        found = self._transformed[key]
        if isinstance(found, frozenset):
            raise ArgumentsNeeded(found)
        return found

    def _transform(
        self, function: Function, moved: tuple[bool, ...], needed: frozenset[int]
    ) -> Transformed | frozenset[int]:
        origins, parameters = set[Origin](), function.block.parameters
        while True:
            try:
                transformation = _Transformation(self, function, moved, origins)
                graph, block, moves = transformation.run(needed)
                break
            except _TangentsNeeded as error:
                if arguments := frozenset(
                    i for i, number in enumerate(parameters) if number in error.origins
                ):
                    return arguments
                if not error.origins - origins:
                    raise TraceError(
                        "a number that moves is stored where constants are kept"
                    ) from error
                origins |= error.origins
        name = f"{function.name}.derivative{next(_NUMBERS)}"
        return Transformed(Function(name, function.python, graph, block, function.inlined), moves)


class _Transformation:
    """Transforms one function, given the origins whose memory has tangents."""

    def __init__(
        self,
        functions: ForwardMode,
        function: Function,
        moved: tuple[bool, ...],
        origins: set[Origin],
    ) -> None:
        self._functions, self._function, self._moved, self._active = (
            functions,
            function,
            moved,
            origins,
        )
        self._graph = Graph()
        self._graph.has_wide_vectors = function.graph.has_wide_vectors
        self._duals: dict[int, Dual] = {}
        self._origins: dict[int, Origin] = {}  # of addresses

    def run(self, needed: frozenset[int]) -> tuple[Graph, Block, tuple[bool, ...]]:
        """Return (the graph, the block, which results have a tangent)."""
        numbers, kinds = self._function.block.parameters, self._function.parameter_kinds
        tangents = [
            _tangent_kind(kind) for kind, moved in zip(kinds, self._moved, strict=True) if moved
        ]
        moves: list[bool] = []

        def values(*symbols: Value) -> tuple[Value, ...]:
            rest = iter(symbols[len(numbers) :])
            for number, symbol, moved in zip(numbers, symbols, self._moved, strict=False):
                self._duals[number] = Dual(symbol, next(rest) if moved else None)
                self._origins[number] = number
            self._run(self._function.block)
            results = [self._duals[number] for number in self._function.block.results]
            missing = [
                self._function.block.results[i] for i in needed if results[i].tangent is None
            ]
            self._need(missing)
            moves.extend(dual.tangent is not None for dual in results)
            return (
                *(dual.value for dual in results),
                *(dual.tangent for dual in results if dual.tangent is not None),
            )

        block = self._graph.trace_block(values, (*kinds, *tangents))
        return self._graph, block, tuple(moves)

    def _need(self, addresses: Iterable[int]) -> None:
        """Have the memory at addresses, values without a tangent, have tangents."""
        numbers = list(addresses)
        if numbers:
            raise _TangentsNeeded(
                self._origins[number] for number in numbers if number in self._origins
            )

    def _kind(self, number: int) -> Kind:
        return self._function.graph.kinds[number]

    def _append(
        self, operation: str, arguments: tuple[Value, ...], kind: Kind, literal: Any = None
    ) -> Value:
        return self._graph.append(operation, numbers_of(arguments), (kind,), literal)[0]

    def _copy(self, instruction: Instruction) -> Dual:
        operands = tuple(self._duals[number].value for number in instruction.arguments)
        kinds = tuple(map(self._kind, instruction.results))
        results = self._graph.append(
            instruction.operation, numbers_of(operands), kinds, instruction.literal
        )
        return Dual(results[0]) if results else Dual(self._graph.constant(0, Kind.INTEGER))

    def _run(self, block: Block) -> None:
        for instruction in block.instructions:
            transform = getattr(
                self, f"_transform_{instruction.operation}", self._transform_operation
            )
            transform(instruction)

    # arithmetic

    def _transform_operation(self, instruction: Instruction) -> None:
        dual, (number,) = self._copy(instruction), instruction.results
        operands = [self._duals[i] for i in instruction.arguments]
        self._duals[number] = dual
        operation = instruction.operation
        if all(x.tangent is None for x in operands):
            return
        if dual.value.kind is Kind.TANGENT:
            raise TraceError("the derivative of a derivative is not known")
        if dual.value.kind is not Kind.REAL or operation in FLAT:
            return
        if operation not in RULES:
            raise TraceError(f"the derivative of {operation} is not known")
        values = [x.value for x in operands]
        moved = [(slope, x.tangent) for slope, x in zip(RULES[operation], operands, strict=True)
                 if x.tangent is not None]  # fmt: skip
        slopes = [(slope(dual.value, *values), tangent) for slope, tangent in moved]
        self._duals[number] = Dual(dual.value, self._weighted_sum(slopes))

    def _weighted_sum(self, terms: list[tuple[Any, Value]]) -> Value:
        """Return the sum of products of slopes, reals or 1, and tangents."""
        slope, total = terms[0]
        if not (isinstance(slope, float) and slope == 1.0):
            total = self._append("scale", (self._graph.lift(slope), total), Kind.TANGENT)
        for slope, tangent in terms[1:]:
            total = self._append(
                "add_scaled", (total, self._graph.lift(slope), tangent), Kind.TANGENT
            )
        return total

    def _transform_select(self, instruction: Instruction) -> None:
        dual, (number,) = self._copy(instruction), instruction.results
        condition, a, b = (self._duals[i] for i in instruction.arguments)
        tangent = None
        if a.tangent is not None or b.tangent is not None:
            sides = condition.value, self._tangent_or_zero(a), self._tangent_or_zero(b)
            tangent = self._append("select", sides, Kind.TANGENT)
        self._duals[number] = Dual(dual.value, tangent)

    def _tangent_or_zero(self, dual: Dual) -> Value:
        return self._graph.constant(0.0, Kind.TANGENT) if dual.tangent is None else dual.tangent

    # memory

    def _new_address(
        self, number: int, value: Value, tangent: Value | None, origin: Origin = None
    ) -> None:
        self._duals[number], self._origins[number] = (
            Dual(value, tangent),
            number if origin is None else origin,
        )

    def _transform_slot(self, instruction: Instruction) -> None:
        (number,), count = instruction.results, instruction.literal
        kept = any(
            origin == number or (isinstance(origin, tuple) and origin[0] == number)
            for origin in self._active
        )
        tangent = self._graph.new_slot(DIRECTIONS * count) if kept else None
        self._new_address(number, self._graph.new_slot(count), tangent)

    def _transform_allocate(self, instruction: Instruction) -> None:
        (number,), size, tangent = (
            instruction.results,
            self._duals[instruction.arguments[0]].value,
            None,
        )
        self._graph.has_allocations = True
        if number in self._active:
            tangent = self._append("allocate", (combine("multiply", size, DIRECTIONS),), Kind.ARRAY)
        self._new_address(number, self._append("allocate", (size,), Kind.ARRAY), tangent)

    def _transform_table(self, instruction: Instruction) -> None:
        self._duals[instruction.results[0]] = self._copy(instruction)

    def _transform_move(self, instruction: Instruction) -> None:
        (number,), (base, *distance) = instruction.results, instruction.arguments
        tangent = self._duals[base].tangent
        if tangent is not None:
            steps = [combine("multiply", self._duals[i].value, DIRECTIONS) for i in distance]
            tangent = self._append(
                "move", (tangent, *steps), Kind.ARRAY, DIRECTIONS * instruction.literal
            )
        self._duals[number] = Dual(self._copy(instruction).value, tangent)
        if base in self._origins:
            self._origins[number] = self._origins[base]

    def _transform_read(self, instruction: Instruction) -> None:
        (number,), (address,), (offset, code) = (
            instruction.results,
            instruction.arguments,
            instruction.literal,
        )
        value, place, kind = (
            self._copy(instruction).value,
            self._duals[address].tangent,
            self._kind(number),
        )
        tangent = None
        if kind is Kind.TANGENT and place is not None:
            raise TraceError("derivatives of derivatives are not computed")
        if kind is Kind.ARRAY:
            origin = (self._origins[address], offset)
            if origin in self._active and place is not None:
                tangent = self._append("read", (place,), Kind.ARRAY, (DIRECTIONS * offset, code))
            self._new_address(number, value, tangent, origin)
            return
        if kind is Kind.REAL and place is not None:
            tangent = self._append("read", (place,), Kind.TANGENT, (DIRECTIONS * offset, "t8"))
        self._duals[number] = Dual(value, tangent)

    def _transform_write(self, instruction: Instruction) -> None:
        (number, address), (offset, code) = instruction.arguments, instruction.literal
        self._copy(instruction)
        dual, place = self._duals[number], self._duals[address].tangent
        if code == "p8":
            self._keep_address(number, address, offset)
        elif code == "f8" and place is not None:
            self._store(self._tangent_or_zero(dual), place, (DIRECTIONS * offset, "t8"))
        elif code == "f8" and dual.tangent is not None:
            self._need([address])

    def _keep_address(self, number: int, address: int, offset: int) -> None:
        """Keep an address's tangents with it; of all kept in one place each has them, or none."""
        dual, place, origin = (
            self._duals[number],
            self._duals[address].tangent,
            (self._origins[address], offset),
        )
        if origin in self._active and place is not None:
            if dual.tangent is None:
                self._need([number])
            self._store(self._tangent_or_zero(dual), place, (DIRECTIONS * offset, "p8"))
        elif dual.tangent is not None:
            raise _TangentsNeeded([origin])

    def _store(self, value: Value, place: Value, literal: tuple[int, str]) -> None:
        self._graph.append("write", numbers_of((value, place)), (), literal)

    # calls

    def _transform_call(self, instruction: Instruction) -> None:
        callee: Function = instruction.literal
        operands = [self._duals[number] for number in instruction.arguments]
        self._graph.has_allocations |= callee.graph.has_allocations
        if operands and hasattr(callee.python, "slopes"):  # without: of a number that is known
            self._transform_smooth(instruction)
            return
        moved = tuple(dual.tangent is not None for dual in operands)
        numbers = instruction.results
        needed = frozenset(i for i, number in enumerate(numbers) if number in self._active)
        if not any(moved) and not needed:
            transformed = Transformed(callee, (False,) * len(numbers))
        else:
            transformed = self._transform_callee(instruction, moved, needed)
        function = transformed.function
        self._graph.has_allocations |= function.graph.has_allocations
        arguments = (
            *(x.value for x in operands),
            *(x.tangent for x in operands if x.tangent is not None),
        )
        results = self._graph.append("call", numbers_of(arguments), function.result_kinds, function)
        rest = iter(results[len(numbers) :])
        for number, value, moves in zip(numbers, results, transformed.moved, strict=False):
            self._new_address(number, value, next(rest) if moves else None)

    def _transform_callee(
        self, instruction: Instruction, moved: tuple[bool, ...], needed: frozenset[int]
    ) -> Transformed:
        try:
            return self._functions.transform(instruction.literal, moved, needed)
        except ArgumentsNeeded as error:
            raise _TangentsNeeded(
                self._origins[number] for i, number in enumerate(instruction.arguments)
                if i in error.indices and number in self._origins
            ) from error  # fmt: skip

    def _transform_smooth(self, instruction: Instruction) -> None:
        """Note the derivatives of a function of one real that has the slopes of its results."""
        (x,), callee = (
            (self._duals[number] for number in instruction.arguments),
            instruction.literal,
        )
        values = self._graph.append("call", (x.value.number,), callee.result_kinds, callee)
        for number, value, slope in zip(
            instruction.results, values, callee.python.slopes(*values), strict=True
        ):
            tangent = None if x.tangent is None else self._weighted_sum([(slope, x.tangent)])
            self._duals[number] = Dual(value, tangent)

    # branches and loops

    def _transform_branch(self, instruction: Instruction) -> None:
        graph, blocks = self._graph, instruction.literal
        sides = [self._record(block) for block in blocks]
        duals = [[self._duals[number] for number in block.results] for block in blocks]
        moved = [number in self._active or any(side[i].tangent is not None for side in duals)
                 for i, number in enumerate(instruction.results)]  # fmt: skip
        closed = [Block(open_.instructions, (), self._close(open_, block.results, moved))
                  for open_, block in zip(sides, blocks, strict=True)]  # fmt: skip
        condition = self._duals[instruction.arguments[0]].value
        kinds = self._kinds_with_tangents(instruction.results, moved)
        self._take(
            instruction, graph.append("branch", (condition.number,), kinds, tuple(closed)), moved
        )

    def _transform_loop(self, instruction: Instruction) -> None:
        graph, results = self._graph, instruction.results
        starts = [self._duals[number] for number in instruction.arguments]
        pairs = zip(results, starts, strict=True)
        moved = [number in self._active or dual.tangent is not None for number, dual in pairs]
        first = self._leaves(instruction.arguments, moved)
        kinds = self._kinds_with_tangents(results, moved)
        proceed, body = (
            self._record_turn(block, instruction, kinds, moved) for block in instruction.literal
        )
        self._take(
            instruction, graph.append("loop", numbers_of(first), kinds, (proceed, body)), moved
        )

    def _record_turn(
        self, block: Block, loop: Instruction, kinds: tuple[Kind, ...], moved: list[bool]
    ) -> Block:
        graph, opened = self._graph, self._graph.new_block()
        with graph.recording(opened):
            parameters = tuple(graph.new_value(kind) for kind in kinds)
            rest = iter(parameters[len(block.parameters) :])
            for number, value, moves, origin in zip(
                block.parameters, parameters, moved, loop.results, strict=False
            ):
                self._new_address(number, value, next(rest) if moves else None, origin)
            self._run(block)
        if block is loop.literal[0]:
            return Block(
                opened.instructions,
                numbers_of(parameters),
                (self._duals[block.results[0]].value.number,),
            )
        late = [n for n, i, moves in zip(loop.results, block.results, moved, strict=True)
                if self._duals[i].tangent is not None and not moves]  # fmt: skip
        if late:
            raise _TangentsNeeded(late)
        return Block(
            opened.instructions, numbers_of(parameters), self._close(opened, block.results, moved)
        )

    def _record(self, block: Block) -> OpenBlock:
        opened = self._graph.new_block()
        with self._graph.recording(opened):
            self._run(block)
        return opened

    def _close(
        self, opened: OpenBlock, results: tuple[int, ...], moved: list[bool]
    ) -> tuple[int, ...]:
        with self._graph.recording(opened):
            return numbers_of(self._leaves(results, moved))

    def _leaves(self, numbers: tuple[int, ...], moved: list[bool]) -> tuple[Value, ...]:
        """Return values, and tangents of those that move."""
        duals = [self._duals[number] for number in numbers]
        pairs = list(zip(numbers, duals, moved, strict=True))
        self._need(
            number
            for number, dual, moves in pairs
            if moves and dual.tangent is None and self._kind(number) is Kind.ARRAY
        )
        return (
            *(dual.value for dual in duals),
            *(self._tangent_or_zero(dual) for _, dual, moves in pairs if moves),
        )

    def _kinds_with_tangents(self, numbers: tuple[int, ...], moved: list[bool]) -> tuple[Kind, ...]:
        kinds = tuple(map(self._kind, numbers))
        return *kinds, *(
            _tangent_kind(kind) for kind, moves in zip(kinds, moved, strict=True) if moves
        )

    def _take(
        self, instruction: Instruction, results: tuple[Value, ...], moved: list[bool]
    ) -> None:
        rest = iter(results[len(moved) :])
        for number, value, moves in zip(instruction.results, results, moved, strict=False):
            self._new_address(number, value, next(rest) if moves else None)


def _tangent_kind(kind: Kind) -> Kind:
    return Kind.ARRAY if kind is Kind.ARRAY else Kind.TANGENT
