"""Traced functions, and calls of one from another."""

from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

from crane_sim.tracing.graph import Graph, Value, kind_of, numbers_of
from crane_sim.tracing.instructions import Block, Kind
from crane_sim.tracing.operations import graph_of
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import flatten, unflatten


class Function(NamedTuple):
    """A function as a list of instructions, and the Python function that it was traced from.

    Called with floats and arrays it computes; called with values of another traced function it becomes a call there.
    """

    name: str  # of letters, digits and underscores
    python: Callable[..., Any]
    graph: Graph
    block: Block
    result: Any  # a tree like what it returns
    inlined: bool  # into what calls it

    @property
    def parameter_kinds(self) -> tuple[Kind, ...]:
        """Return the kinds of the arguments."""
        return tuple(self.graph.kinds[number] for number in self.block.parameters)

    @property
    def result_kinds(self) -> tuple[Kind, ...]:
        """Return the kinds of what it returns, leaf by leaf."""
        return tuple(self.graph.kinds[number] for number in self.block.results)

    def __call__(self, *arguments: Any) -> Any:
        """Compute, or note a call."""
        graph = graph_of(*arguments)
        if graph is None:
            return self.python(*arguments)
        if len(arguments) != len(self.block.parameters):
            raise TraceError(f"{self.name} takes {len(self.block.parameters)} arguments, not {len(arguments)}")
        values = [graph.lift(x, kind) for x, kind in zip(arguments, self.parameter_kinds, strict=True)]
        results = graph.append("call", numbers_of(tuple(values)), self.result_kinds, self)
        return unflatten(self.result, iter(results))


def trace(function: Callable[..., Any], kinds: tuple[Kind, ...], name: str = "", inlined: bool = False) -> Function:
    """Return a function traced with symbols of these kinds.

    Raises:
        TraceError: it does with a number what only a float can do, such as a condition on it; or its name is none.
    """
    name = name or function.__name__
    if not (name.isascii() and name.isidentifier()):
        raise TraceError(f"{name} is no name of a function in C: letters, digits and underscores")
    graph, trees = Graph(), []

    def values(*symbols: Value) -> tuple[Value, ...]:
        trees.append(function(*symbols))
        return tuple(graph.lift(leaf, kind_of(leaf)) for leaf in flatten(trees[0]))

    block = graph.trace_block(values, kinds)
    return Function(name, function, graph, block, trees[0], inlined)


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


def _collect(function: Function, follows: Callable[[Function], bool], found: dict[str, Function]) -> None:
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
