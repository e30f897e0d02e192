"""Traced functions, and which of them call which."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from crane_sim.tracing.graph import Graph
from crane_sim.tracing.instructions import Block, Kind
from crane_sim.tracing.trace_error import TraceError


class Function(NamedTuple):
    """A function as a list of instructions, and the Python function that it was traced from."""

    name: str
    python: Callable[..., Any]
    graph: Graph
    block: Block
    inlined: bool  # into what calls it
    without_lanes: Any = None  # a function with the same results, where no loop around it becomes
    # lanes

    @property
    def parameter_kinds(self) -> tuple[Kind, ...]:
        """Return the kinds of the arguments."""
        return tuple(self.graph.kinds[number] for number in self.block.parameters)

    @property
    def result_kinds(self) -> tuple[Kind, ...]:
        """Return the kinds of what it returns, leaf by leaf."""
        return tuple(self.graph.kinds[number] for number in self.block.results)


def functions_with_callees(
    *functions: Function, follows: Callable[[Function], bool] = lambda function: True
) -> list[Function]:
    """Return functions and all that they call, each after what it calls.

    Args:
        functions: where the calls begin.
        follows: whether what is called is one of them.

    Raises:
        TraceError: two of them have one name.
    """
    found: dict[str, Function] = {}
    for function in functions:
        _collect(function, follows, found)
    return list(found.values())


def _collect(
    function: Function, follows: Callable[[Function], bool], found: dict[str, Function]
) -> None:
    if function.name not in found:
        for callee in callees(function.block):
            if follows(callee):
                _collect(callee, follows, found)
        found[function.name] = function
    elif found[function.name] is not function:
        raise TraceError(f"two functions are called {function.name}")


def callees(block: Block) -> Iterator[Function]:
    """Yield what a block calls, once for each call."""
    for instruction in block.instructions:
        if instruction.operation == "call":
            yield instruction.literal
        elif instruction.operation in ("branch", "loop"):
            for inner in instruction.literal:
                yield from callees(inner)
