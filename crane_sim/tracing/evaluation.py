"""A traced function computed by other rules: with derivatives, or with numbers of another kind."""

from collections.abc import Callable
from typing import Any, NamedTuple

from crane_sim.tracing import operations
from crane_sim.tracing.function import Function
from crane_sim.tracing.instructions import Block, Instruction
from crane_sim.tracing.trace_error import TraceError


class Rules(NamedTuple):
    """How instructions are computed.

    Attributes:
        lift: a constant as an operand.
        operations: by name, of operands.
        functions: by name, instead of their instructions.
        condition: what a branch or loop goes by, of an operand.
    """

    lift: Callable[[Any], Any]
    operations: dict[str, Callable[..., Any]]
    functions: dict[str, Callable[..., tuple[Any, ...]]] = {}
    condition: Callable[[Any], Any] = lambda operand: operand


class Location(NamedTuple):
    """An array that elements are read from and written to, from an element on."""

    elements: Any  # with integer indices
    offset: int = 0


def evaluate(function: Function, arguments: tuple[Any, ...], rules: Rules) -> tuple[Any, ...]:
    """Return the results of a function, leaf by leaf; arguments that are arrays are of class `Location`.

    Raises:
        TraceError: it uses an index that it computes, stores in a branch or loop, or calls a function at an address.
    """
    return _Evaluation(rules).run(function.block, arguments, {})


class _Evaluation:
    def __init__(self, rules: Rules) -> None:
        self._rules = rules
        self._depth = 0  # of branches and loops

    def run(self, block: Block, arguments: tuple[Any, ...], known: dict[int, Any]) -> tuple[Any, ...]:
        """Return what a block results in, given the operands of enclosing blocks by number."""
        values = known | dict(zip(block.parameters, arguments, strict=True))
        for instruction in block.instructions:
            results = self._compute(instruction, values)
            values.update(zip(instruction.results, results, strict=True))
        return tuple(values[number] for number in block.results)

    def _compute(self, instruction: Instruction, values: dict[int, Any]) -> tuple[Any, ...]:
        operation, numbers, _, literal = instruction
        operands = tuple(values[number] for number in numbers)
        if operation == "constant":
            return (self._rules.lift(literal),)
        if operation in ("load", "store", "address"):
            return self._access(operation, operands, literal)
        if operation == "call":
            replaced = self._rules.functions.get(literal.name)
            return replaced(*operands) if replaced else self.run(literal.block, operands, {})
        if operation == "call_address":
            raise TraceError("a call of a function at an address, whose instructions are not known")
        if operation in ("branch", "loop"):
            enter = self._branch if operation == "branch" else self._repeat
            self._depth += 1
            results = enter(operands, literal, values)
            self._depth -= 1
            return results
        return (self._rules.operations[operation](*operands),)

    def _access(self, operation: str, operands: tuple[Any, ...], offset: int) -> tuple[Any, ...]:
        if len(operands) > (2 if operation == "store" else 1):
            raise TraceError("an index that is computed: unroll the loop")
        place: Location = operands[-1]
        at = place.offset + offset
        if operation == "load":
            return (place.elements[at],)
        if operation == "address":
            return (Location(place.elements, at),)
        if self._depth:
            raise TraceError("a store in a branch or loop")
        place.elements[at] = operands[0]
        return ()

    def _branch(self, operands: tuple[Any, ...], blocks: Any, values: dict[int, Any]) -> tuple[Any, ...]:
        condition = self._rules.condition(operands[0])
        sides = [lambda block=block: self.run(block, (), values) for block in blocks]
        return operations.branch(condition, *sides)

    def _repeat(self, operands: tuple[Any, ...], blocks: Any, values: dict[int, Any]) -> tuple[Any, ...]:
        proceed, body = blocks
        return operations.repeat_while(
            lambda state: self._rules.condition(self.run(proceed, state, values)[0]),
            lambda state: self.run(body, state, values),
            operands,
        )
