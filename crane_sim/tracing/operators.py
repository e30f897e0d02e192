"""What operators, elements and attributes are on numbers, tuples and arrays, known or not."""

import ast
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol
from crane_sim.tracing.graph import Value
from crane_sim.tracing.ranges import Range
from crane_sim.tracing.trace_error import TraceError
from crane_sim.tracing.trees import rebuilt

_BINARY = {
    ast.Add: "add",
    ast.Sub: "subtract",
    ast.Mult: "multiply",
    ast.Div: "divide",
    ast.FloorDiv: "floor_divide",
    ast.Mod: "modulo",
    ast.Pow: "power",
    ast.BitAnd: "both",
    ast.BitOr: "either",
    ast.BitXor: "differ",
    ast.RShift: "shift_right",
    ast.LShift: "shift_left",
}
_COMPARE = {
    ast.Lt: "less",
    ast.LtE: "less_equal",
    ast.Gt: "greater",
    ast.GtE: "greater_equal",
    ast.Eq: "equal",
    ast.NotEq: "unequal",
}


def evaluate_operation(operator: ast.operator, a: Any, b: Any) -> Any:
    """Return the result of a binary operation on numbers, arrays or other Python objects."""
    operation = _BINARY.get(type(operator))
    if operation is None:
        raise TraceError("a product of matrices is not traced")
    if isinstance(a, ArraySymbol) or isinstance(b, ArraySymbol):
        return array_symbols.elementwise(lambda x, y: arithmetic.combine(operation, x, y), a, b)
    return arithmetic.combine(operation, a, b)


def compare(operator: ast.cmpop, left: Any, right: Any) -> Any:
    """Return whether two values compare so."""
    if isinstance(operator, ast.Is | ast.IsNot):
        return (left is right) is isinstance(operator, ast.Is)
    if isinstance(operator, ast.In | ast.NotIn):
        holds = _contains(right, left)
        return holds if isinstance(operator, ast.In) else arithmetic.invert(holds)
    return arithmetic.combine(_COMPARE[type(operator)], left, right)


def _contains(items: Any, x: Any) -> Any:
    if not isinstance(items, tuple):
        return x in items
    result: Any = False
    for item in items:
        equal = item is x or (arithmetic.is_number(item) == arithmetic.is_number(x)
                              and arithmetic.combine("equal", item, x))  # fmt: skip
        result = arithmetic.combine("either", result, equal)
    return result


def items_of(tree: Any) -> list[Any]:
    """Return the elements of what is iterated while tracing.

    Raises:
        TraceError: it is an array whose length is not known.
    """
    if isinstance(tree, ArraySymbol):
        if isinstance(tree.shape[0], Value):
            raise TraceError("the length of an array is not known")
        return [array_symbols.get_item(tree, i) for i in range(tree.shape[0])]
    if isinstance(tree, Value | Range):
        raise TraceError(
            "the length of a range is not known"
            if isinstance(tree, Range)
            else "a number has no elements"
        )
    return list(tree)


def select_item(items: tuple[Any, ...], index: Value) -> Any:
    """Return an element of a tuple at a place that is known only when the code runs."""
    index, result = array_symbols.from_start(index, len(items)), items[-1]
    for i in range(len(items) - 2, -1, -1):
        result = _choose_tree(arithmetic.combine("equal", index, i), items[i], result)
    return result


def _choose_tree(condition: Value, a: Any, b: Any) -> Any:
    if a is b:
        return a
    if isinstance(a, tuple) and isinstance(b, tuple):
        return rebuilt(a, [_choose_tree(condition, x, y) for x, y in zip(a, b, strict=True)])
    if not (arithmetic.is_number(a) and arithmetic.is_number(b)):
        raise TraceError(
            "an element of a tuple that holds more than numbers, at a place that is not known"
        )
    return arithmetic.choose(condition, a, b)


def attribute_of_array(array: ArraySymbol, name: str) -> Any:
    """Return a field, a property or a method of an array.

    Raises:
        TraceError: it is not traced.
    """
    if array.dtype.names and name in array.dtype.names:
        return array_symbols.get_field(array, name)
    attribute = _ARRAY_ATTRIBUTES.get(name)
    if attribute is None:
        raise TraceError(f"{name} of an array is not traced")
    return attribute(array)


def _transposed(array: ArraySymbol) -> ArraySymbol:
    return replace(array, shape=array.shape[::-1], strides=array.strides[::-1])


_ARRAY_ATTRIBUTES: dict[str, Callable[[ArraySymbol], Any]] = {
    "shape": lambda array: array.shape,
    "dtype": lambda array: array.dtype,
    "strides": lambda array: array.strides,
    "size": lambda array: array_symbols.size_of(array),
    "ndim": lambda array: len(array.shape),
    "T": _transposed,
    "copy": lambda array: lambda: array_symbols.copy_of(array),
    "min": lambda array: lambda: array_symbols.extreme(array, "min"),
    "max": lambda array: lambda: array_symbols.extreme(array, "max"),
    "sum": lambda array: lambda: array_symbols.total(array),
}
