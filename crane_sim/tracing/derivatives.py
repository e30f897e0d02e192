"""Derivatives of traced functions by forward mode: every number carries its derivatives along several directions.

They are traced, too: a literal zero, along a direction that does not move a number, costs nothing. Integers and
conditions have none.
"""

import operator
from collections.abc import Callable
from typing import Any, NamedTuple

from crane_sim.tracing import operations
from crane_sim.tracing.elementary import SINCOS, sincos
from crane_sim.tracing.evaluation import Location, Rules, evaluate
from crane_sim.tracing.function import Function, trace
from crane_sim.tracing.graph import Array, Value, kind_of
from crane_sim.tracing.instructions import Kind
from crane_sim.tracing.trace_error import TraceError


class Dual(NamedTuple):
    """A real and its derivatives."""

    value: Any
    tangents: tuple[Any, ...]


def differentiate(function: Function, parameter: int, size: int, output: int, rows: int) -> Function:
    """Return the function that also computes a Jacobian by forward mode.

    It takes one more argument, the array (rows, size), row by row, of the derivatives of the first `rows` elements
    written into parameter number `output` by the first `size` elements of parameter number `parameter`, both arrays.

    Raises:
        TraceError: it raises a number to a power that depends on these elements, or as `evaluate`.
    """
    kinds = (*function.parameter_kinds, Kind.ARRAY)

    def compute(*arguments: Any) -> tuple[Any, ...]:
        *given, jacobian = arguments
        memories = {i: _Memory(x, size, i == parameter) for i, x in enumerate(given) if isinstance(x, Array)}
        operands = [Location(memories[i]) if i in memories else _constant(x, size) for i, x in enumerate(given)]
        results = evaluate(function, tuple(operands), _rules(size))
        for i in range(rows):
            for j, tangent in enumerate(memories[output][i].tangents):
                jacobian[i * size + j] = tangent
        return tuple(result.value if isinstance(result, Dual) else result for result in results)

    return trace(compute, kinds, f"{function.name}_jacobian")


def _constant(number: Any, size: int) -> Any:
    return Dual(number, (0.0,) * size) if kind_of(number) is Kind.REAL else number


class _Memory:
    """Elements of an array, with the derivatives of those that have been written."""

    def __init__(self, array: Array, size: int, seeded: bool) -> None:
        self._array, self._size, self._seeded = array, size, seeded
        self._written: dict[int, Dual] = {}

    def __getitem__(self, index: int) -> Dual:
        if index in self._written:
            return self._written[index]
        seeds = tuple(1.0 if self._seeded and j == index else 0.0 for j in range(self._size))
        return Dual(self._array[index], seeds)

    def __setitem__(self, index: int, dual: Dual) -> None:
        self._array[index] = dual.value
        self._written[index] = dual


def _linear(slopes: Callable[..., tuple[Any, ...]], value: Callable[..., Any]) -> Callable[..., Any]:
    """Return the rule of an operation: its value, and its partial derivatives by each operand."""

    def rule(*operands: Any) -> Any:
        if not isinstance(operands[0], Dual):
            return value(*operands)
        result = value(*(x.value for x in operands))
        partials = slopes(result, *(x.value for x in operands))
        columns = zip(*(x.tangents for x in operands), strict=True)
        return Dual(result, tuple(_weighted_sum(partials, column) for column in columns))

    return rule


def _weighted_sum(weights: tuple[Any, ...], numbers: tuple[Any, ...]) -> Any:
    total = weights[0] * numbers[0]
    for weight, number in zip(weights[1:], numbers[1:], strict=True):
        total = total + weight * number
    return total


def _on_values(operation: Callable[..., Any]) -> Callable[..., Any]:
    return lambda *operands: operation(*(x.value if isinstance(x, Dual) else x for x in operands))


def _select(condition: Any, a: Any, b: Any) -> Any:
    if not isinstance(a, Dual):
        return operations.select(condition, a, b)
    value = operations.select(condition, a.value, b.value)
    return Dual(value, operations.select(condition, a.tangents, b.tangents))


def _power(x: Dual, exponent: Dual) -> Dual:
    if any((t.literal if isinstance(t, Value) else t) != 0.0 for t in exponent.tangents):
        raise TraceError("the derivative of a power by its exponent: no operation has it")
    slope = exponent.value * operations.power(x.value, exponent.value - 1.0)
    return Dual(operations.power(x.value, exponent.value), tuple(slope * t for t in x.tangents))


def _differentiate_sincos(angle: Dual) -> tuple[Dual, Dual]:
    s, c = sincos(angle.value)
    return Dual(s, tuple(c * x for x in angle.tangents)), Dual(c, tuple(-s * x for x in angle.tangents))


_OPERATIONS: dict[str, Callable[..., Any]] = {
    "add": _linear(lambda r, a, b: (1.0, 1.0), operator.add),
    "subtract": _linear(lambda r, a, b: (1.0, -1.0), operator.sub),
    "multiply": _linear(lambda r, a, b: (b, a), operator.mul),
    "divide": _linear(lambda r, a, b: (1.0 / b, -r / b), operator.truediv),
    "negate": _linear(lambda r, a: (-1.0,), operator.neg),
    "absolute": _linear(lambda r, a: (operations.select(a < 0.0, -1.0, 1.0),), abs),
    "sqrt": _linear(lambda r, a: (0.5 / r,), operations.sqrt),
    "exp": _linear(lambda r, a: (r,), operations.exp),
    "power": _power,
    "fma": _linear(lambda r, a, b, c: (b, a, 1.0), operations.fma),
    "select": _select,
    "less": _on_values(operator.lt),
    "less_equal": _on_values(operator.le),
    "equal": _on_values(operator.eq),
    "unequal": _on_values(operator.ne),
    "both": _on_values(operator.and_),
    "to_integer": _on_values(operations.to_integer),
}


def _rules(size: int) -> Rules:
    def lift(number: Any) -> Any:
        return _constant(number, size)

    rules = _OPERATIONS | {"to_real": lambda i: lift(operations.to_real(i))}
    return Rules(lift, rules, {SINCOS.name: _differentiate_sincos}, lambda x: x.value if isinstance(x, Dual) else x)
