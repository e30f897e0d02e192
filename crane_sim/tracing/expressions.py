"""Expressions and targets of assignments while tracing: known ones are computed, others noted."""

import ast
from collections.abc import Callable
from typing import Any

import numpy as np

from crane_sim.tracing import arithmetic, array_symbols
from crane_sim.tracing.array_symbols import ArraySymbol, RecordSymbol
from crane_sim.tracing.frame import Frame
from crane_sim.tracing.graph import Value
from crane_sim.tracing.merging import UNDEFINED
from crane_sim.tracing.operators import (
    attribute_of_array,
    compare,
    evaluate_operation,
    items_of,
    select_item,
)
from crane_sim.tracing.ranges import Range
from crane_sim.tracing.trace_error import TraceError


def evaluate(frame: Frame, node: ast.expr) -> Any:
    """Return the value of an expression.

    Raises:
        TraceError: it is not traced.
    """
    evaluator = _EVALUATORS.get(type(node))
    if evaluator is None:
        raise TraceError(f"`{ast.unparse(node)[:60]}` is not traced")
    return evaluator(frame, node)


def _constant(frame: Frame, node: ast.Constant) -> Any:
    return node.value


def _name(frame: Frame, node: ast.Name) -> Any:
    name = node.id
    value = frame.variables.get(name, UNDEFINED)
    if value is not UNDEFINED:
        return _without_list(value)
    if name in frame.variables or name in frame.source.local_names:
        raise TraceError(f"{name} may have no value here, or values of two types")
    return _without_list(frame.source.look_up(name))


def _without_list(x: Any) -> Any:
    """Return a list as a tuple, as those of a function: lists do not change while tracing."""
    return tuple(x) if type(x) is list else x


# operators


def _operate(frame: Frame, node: ast.BinOp) -> Any:
    return evaluate_operation(node.op, evaluate(frame, node.left), evaluate(frame, node.right))


def _operate_on_one(frame: Frame, node: ast.UnaryOp) -> Any:
    if isinstance(node.op, ast.Not):
        return arithmetic.invert(condition_of(frame, node.operand))
    x = evaluate(frame, node.operand)
    if isinstance(node.op, ast.UAdd):
        return arithmetic.combine("add", x, 0) if arithmetic.is_flag(x) else x
    if isinstance(node.op, ast.Invert):
        return arithmetic.combine("differ", x, -1)
    return (
        array_symbols.elementwise(arithmetic.negate, x)
        if isinstance(x, ArraySymbol)
        else arithmetic.negate(x)
    )


# conditions


def condition_of(frame: Frame, node: ast.expr) -> Any:
    """Return whether an expression holds; of `and` and `or` only deciding parts are evaluated."""
    if isinstance(node, ast.BoolOp):
        return _decide(frame, node.values, isinstance(node.op, ast.And), condition_of)
    return arithmetic.holds(evaluate(frame, node))


def _connect(frame: Frame, node: ast.BoolOp) -> Any:
    return _decide(frame, node.values, isinstance(node.op, ast.And), evaluate)


def _decide(
    frame: Frame, parts: list[ast.expr], conjunction: bool, value_of: Callable[[Frame, Any], Any]
) -> Any:
    value = value_of(frame, parts[0])
    if len(parts) == 1:
        return value
    condition = arithmetic.holds(value)

    def following() -> Any:
        return _decide(frame, parts[1:], conjunction, value_of)

    if not isinstance(condition, Value):
        return following() if condition == conjunction else value
    sides = (following, lambda: value) if conjunction else (lambda: value, following)
    return frame.branch(condition, *sides)


def _compare(frame: Frame, node: ast.Compare) -> Any:
    return _compare_chain(frame, evaluate(frame, node.left), node.ops, node.comparators)


def _compare_chain(
    frame: Frame, left: Any, operators: list[ast.cmpop], nodes: list[ast.expr]
) -> Any:
    right = evaluate(frame, nodes[0])
    holds = compare(operators[0], left, right)
    if len(nodes) == 1:
        return holds

    def following() -> Any:
        return _compare_chain(frame, right, operators[1:], nodes[1:])

    if not isinstance(holds, Value):
        return following() if holds else holds
    if all(isinstance(node, ast.Name | ast.Constant) for node in nodes[1:]):
        return arithmetic.combine("both", holds, following())
    return frame.branch(holds, following, lambda: False)


def _choose(frame: Frame, node: ast.IfExp) -> Any:
    condition = condition_of(frame, node.test)
    if not isinstance(condition, Value):
        return evaluate(frame, node.body if condition else node.orelse)
    return frame.branch(
        condition, lambda: evaluate(frame, node.body), lambda: evaluate(frame, node.orelse)
    )


# tuples, elements and attributes


def _tuple(frame: Frame, node: ast.Tuple | ast.List) -> Any:
    return tuple(_evaluate_all(frame, node.elts))


def _evaluate_all(frame: Frame, nodes: list[ast.expr]) -> list[Any]:
    values: list[Any] = []
    for node in nodes:
        if isinstance(node, ast.Starred):
            values += items_of(evaluate(frame, node.value))
        else:
            values.append(evaluate(frame, node))
    return values


def _subscript(frame: Frame, node: ast.Subscript) -> Any:
    owner, index = evaluate(frame, node.value), _index(frame, node.slice)
    if isinstance(owner, ArraySymbol):
        return array_symbols.get_item(owner, index)
    if isinstance(owner, RecordSymbol):
        return array_symbols.get_field(owner, index)
    if isinstance(owner, np.ndarray):
        return frame.calls.constant_array(frame.graph, owner, index)
    if isinstance(owner, tuple) and isinstance(index, Value):
        return select_item(owner, index)
    if isinstance(owner, Value):
        raise TraceError("a number has no elements")
    return _without_list(owner[index])


def _index(frame: Frame, node: ast.expr) -> Any:
    if isinstance(node, ast.Slice):
        parts = (node.lower, node.upper, node.step)
        return slice(*(evaluate(frame, part) if part else None for part in parts))
    if isinstance(node, ast.Tuple):
        return tuple(_index(frame, part) for part in node.elts)
    return evaluate(frame, node)


_OF_LISTS = frozenset(dir(list)) - frozenset(dir(tuple))


def _attribute(frame: Frame, node: ast.Attribute) -> Any:
    owner = evaluate(frame, node.value)
    if isinstance(owner, ArraySymbol):
        return attribute_of_array(owner, node.attr)
    if isinstance(owner, RecordSymbol):
        return array_symbols.get_field(owner, node.attr)
    if isinstance(owner, Value):
        raise TraceError(f"{node.attr} of a number is not traced")
    if type(owner) is tuple and node.attr in _OF_LISTS:
        raise TraceError(f"list.{node.attr} is not traced")
    return _without_list(getattr(owner, node.attr))


# calls and comprehensions


def evaluate_iterable(frame: Frame, node: ast.expr) -> Any:
    """Return what a loop goes over; a range with a symbol is a `Range`."""
    if (
        isinstance(node, ast.Call)
        and isinstance(node.func, ast.Name)
        and evaluate(frame, node.func) is range
    ):
        bounds = _evaluate_all(frame, node.args)
        return Range(*bounds) if any(isinstance(x, Value) for x in bounds) else range(*bounds)
    return evaluate(frame, node)


def _call(frame: Frame, node: ast.Call) -> Any:
    function = evaluate(frame, node.func)
    arguments = _evaluate_all(frame, node.args)
    keywords: dict[str, Any] = {}
    for keyword in node.keywords:
        value = evaluate(frame, keyword.value)
        keywords |= {keyword.arg: value} if keyword.arg else value
    return frame.calls.call(frame.graph, function, arguments, keywords)


def _comprehension(frame: Frame, node: ast.ListComp | ast.GeneratorExp) -> Any:
    results: list[Any] = []
    before = frame.variables
    frame.variables = dict(before)
    try:
        _generate(frame, node.generators, lambda: results.append(evaluate(frame, node.elt)))
    finally:
        frame.variables = before
    return tuple(results)


def _generate(frame: Frame, generators: list[ast.comprehension], take: Callable[[], None]) -> None:
    if not generators:
        take()
        return
    for value in items_of(evaluate_iterable(frame, generators[0].iter)):
        assign(frame, generators[0].target, value)
        conditions = [condition_of(frame, test) for test in generators[0].ifs]
        if any(isinstance(condition, Value) for condition in conditions):
            raise TraceError("how many elements a comprehension has is not known")
        if all(conditions):
            _generate(frame, generators[1:], take)


def _dictionary(frame: Frame, node: ast.Dict) -> dict[Any, Any]:
    result: dict[Any, Any] = {}
    for key, value in zip(node.keys, node.values, strict=True):
        part = evaluate(frame, value)
        result |= {evaluate(frame, key): part} if key else part
    return result


def _format(frame: Frame, node: ast.JoinedStr) -> Any:
    return "".join(str(evaluate(frame, part)) for part in node.values)


def _format_part(frame: Frame, node: ast.FormattedValue) -> Any:
    return format(evaluate(frame, node.value), "")


# targets


def assign(frame: Frame, target: ast.expr, value: Any) -> None:
    """Assign a value to a variable, an element, a field, or several of them.

    Raises:
        TraceError: the target is nothing of this, or no number that it may have.
    """
    if isinstance(target, ast.Name):
        frame.variables[target.id] = value
    elif isinstance(target, ast.Tuple | ast.List):
        _unpack(frame, target.elts, value)
    elif isinstance(target, ast.Subscript):
        _assign_element(frame, target, value)
    elif isinstance(target, ast.Attribute):
        owner = evaluate(frame, target.value)
        if not isinstance(owner, ArraySymbol | RecordSymbol):
            raise TraceError(
                f"`{ast.unparse(target)} = …` is not traced: only fields of records are assigned"
            )
        array_symbols.set_field(owner, target.attr, value)
    else:
        raise TraceError(f"`{ast.unparse(target)} = …` is not traced")


def _assign_element(frame: Frame, target: ast.Subscript, value: Any) -> None:
    owner, index = evaluate(frame, target.value), _index(frame, target.slice)
    if isinstance(owner, RecordSymbol):
        array_symbols.set_field(owner, index, value)
    elif isinstance(owner, ArraySymbol):
        array_symbols.set_item(owner, index, value)
    else:
        raise TraceError(
            f"`{ast.unparse(target)} = …` is not traced: only elements of arrays are assigned"
        )


def _unpack(frame: Frame, targets: list[ast.expr], value: Any) -> None:
    star = next((i for i, target in enumerate(targets) if isinstance(target, ast.Starred)), None)
    if isinstance(value, ArraySymbol) and star is None:
        value = tuple(array_symbols.get_item(value, i) for i in range(len(targets)))
    values = items_of(value)
    if star is not None and len(values) >= len(targets) - 1:
        end = len(values) - (len(targets) - star - 1)
        values = [*values[:star], tuple(values[star:end]), *values[end:]]
    if len(values) != len(targets):
        raise TraceError(f"{len(values)} values for {len(targets)} variables")
    for target, x in zip(targets, values, strict=True):
        assign(frame, target.value if isinstance(target, ast.Starred) else target, x)


_EVALUATORS: dict[type, Callable[[Frame, Any], Any]] = {
    ast.Constant: _constant,
    ast.Name: _name,
    ast.BinOp: _operate,
    ast.UnaryOp: _operate_on_one,
    ast.Compare: _compare,
    ast.BoolOp: _connect,
    ast.IfExp: _choose,
    ast.Tuple: _tuple,
    ast.List: _tuple,
    ast.Subscript: _subscript,
    ast.Attribute: _attribute,
    ast.Call: _call,
    ast.ListComp: _comprehension,
    ast.GeneratorExp: _comprehension,
    ast.Dict: _dictionary,
    ast.JoinedStr: _format,
    ast.FormattedValue: _format_part,
}
