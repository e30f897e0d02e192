"""Interpreter of Python functions on symbols: what depends on no number happens while tracing.

A function of plain Python runs statement by statement. Types, optional parts and loops of known
length are resolved; arithmetic on symbols notes instructions; a condition that is a symbol becomes
a branch or a loop, whose variables are those that it assigns. So one source is the code that is
compiled and, called with floats, its own interpreter.

What follows a branch or a loop is traced once, whatever returns inside it, so code grows as its
source does.
"""

import ast
from typing import Any

from crane_sim.tracing import arithmetic
from crane_sim.tracing.array_symbols import ArraySymbol
from crane_sim.tracing.array_symbols import assign as assign_elements
from crane_sim.tracing.expressions import assign, condition_of, evaluate, evaluate_operation
from crane_sim.tracing.frame import BREAKS, CONTINUES, RETURNS, RUNS, Frame, Returned
from crane_sim.tracing.graph import Value
from crane_sim.tracing.loops import known_turns, trace_loop, turns_of
from crane_sim.tracing.scopes import always_leaves, has_exit, has_jump, has_return
from crane_sim.tracing.trace_error import TraceError


class _Bind(ast.stmt):
    """A statement that assigns a value that is known while tracing."""

    def __init__(self, target: ast.expr, value: Any) -> None:
        super().__init__()
        self.target, self.value = target, value


def run(frame: Frame, statements: list[ast.stmt]) -> Any:
    """Run statements.

    Returns:
        None, a `Returned`, or, where the frame is nested, how they end: a number or a symbol.

    Raises:
        TraceError: they do what is not traced; names the place.
    """
    for at, statement in enumerate(statements):
        try:
            done, outcome = _run_statement(frame, statement, statements[at + 1 :])
        except TraceError as error:
            error.add_place(frame.source.place(statement), frame)
            raise
        except (ArithmeticError, AttributeError, LookupError, TypeError, ValueError) as error:
            mended = TraceError(f"{type(error).__name__}: {error}")
            mended.add_place(frame.source.place(statement), frame)
            raise mended from error
        if done:
            return outcome
    return None


def _run_statement(frame: Frame, statement: ast.stmt, rest: list[ast.stmt]) -> tuple[bool, Any]:
    """Return (whether `rest` has run or does not run, the outcome)."""
    if isinstance(statement, ast.If):
        return _run_if(frame, statement, rest)
    if isinstance(statement, ast.For | ast.While):
        return _run_loop(frame, statement, rest)
    run_simple = _SIMPLE.get(type(statement))
    if run_simple is None:
        raise TraceError(f"{_construct(statement)} is not traced")
    outcome = run_simple(frame, statement)
    return outcome is not None, outcome


def _construct(statement: ast.stmt) -> str:
    """Return what a statement is called: by its first words."""
    return f"`{ast.unparse(statement).splitlines()[0][:60]}`"


def _return(frame: Frame, statement: ast.Return) -> Any:
    return frame.leave(evaluate(frame, statement.value) if statement.value else None)


def _assign(frame: Frame, statement: ast.Assign) -> None:
    result = evaluate(frame, statement.value)
    for target in statement.targets:
        assign(frame, target, result)


def _assign_augmented(frame: Frame, statement: ast.AugAssign) -> None:
    before = evaluate(frame, statement.target)  # evaluation does not look at contexts
    result = evaluate_operation(statement.op, before, evaluate(frame, statement.value))
    if isinstance(before, ArraySymbol):
        assign_elements(before, result)
    else:
        assign(frame, statement.target, result)


def _assign_annotated(frame: Frame, statement: ast.AnnAssign) -> None:
    if statement.value is not None:
        assign(frame, statement.target, evaluate(frame, statement.value))


def _evaluate_only(frame: Frame, statement: ast.Expr) -> None:
    if not isinstance(statement.value, ast.Constant):
        evaluate(frame, statement.value)


def _raise(frame: Frame, statement: ast.Raise) -> None:
    raise TraceError(f"{_construct(statement)} would run: compiled code raises no errors")


_SIMPLE: dict[type, Any] = {
    ast.Return: _return,
    ast.Assign: _assign,
    ast.AugAssign: _assign_augmented,
    ast.AnnAssign: _assign_annotated,
    ast.Expr: _evaluate_only,
    ast.Raise: _raise,
    ast.Break: lambda frame, statement: BREAKS,
    ast.Continue: lambda frame, statement: CONTINUES,
    ast.Pass: lambda frame, statement: None,
    _Bind: lambda frame, statement: assign(frame, statement.target, statement.value),
}


# branches


def _run_if(frame: Frame, statement: ast.If, rest: list[ast.stmt]) -> tuple[bool, Any]:
    condition = condition_of(frame, statement.test)
    sides = statement.body, statement.orelse
    if not isinstance(condition, Value):
        return True, run(frame, [*sides[not condition], *rest])
    if not has_exit(statement):
        frame.branch_variables(condition, *[lambda side=side: run(frame, side) for side in sides])
        return False, None
    if not frame.depth and any(map(always_leaves, sides)):
        following = [[*side] if always_leaves(side) else [*side, *rest] for side in sides]
        return True, Returned(
            frame.branch(condition, *[lambda s=s: _value_of(frame, s) for s in following])
        )
    frame.depth += 1
    try:
        code = frame.branch(condition, *[lambda side=side: _code_of(frame, side) for side in sides])
    finally:
        frame.depth -= 1
    return True, _go_on(frame, code, rest)


def _value_of(frame: Frame, statements: list[ast.stmt]) -> Any:
    outcome = run(frame, statements)
    return outcome.value if isinstance(outcome, Returned) else None


def _code_of(frame: Frame, statements: list[ast.stmt]) -> Any:
    outcome = run(frame, statements)
    return RUNS if outcome is None else outcome


def _go_on(frame: Frame, code: Any, rest: list[ast.stmt]) -> Any:
    """Run what follows statements unless they end a turn or the function; return the outcome."""
    if not frame.depth:
        return frame.finish(code, lambda: run(frame, rest))
    if not isinstance(code, Value):
        return _code_of(frame, rest) if code == RUNS else code
    if not rest:
        return code
    return frame.branch(
        arithmetic.combine("equal", code, RUNS), lambda: _code_of(frame, rest), lambda: code
    )


# loops


def _run_loop(frame: Frame, loop: ast.For | ast.While, rest: list[ast.stmt]) -> tuple[bool, Any]:
    if loop.orelse:
        raise TraceError("`else` of a loop is not traced")
    turns = turns_of(frame, loop)
    known = known_turns(loop, turns)
    if known is not None and not has_jump(loop):
        assert isinstance(loop, ast.For)
        statements = [part for value in known for part in (_Bind(loop.target, value), *loop.body)]
        return True, run(frame, [*statements, *rest])
    if known is not None:
        assert isinstance(loop, ast.For)
        frame.depth += 1
        try:
            code = _unroll(frame, loop, known)
        finally:
            frame.depth -= 1
    else:
        code = trace_loop(frame, loop, turns, lambda: _code_of(frame, loop.body))
    if code is None or not has_return(loop):
        return False, None
    if not frame.depth and frame.has_stored and _is_endless(loop):
        return True, frame.stored()
    return True, _go_on(frame, _after_loop(code), rest)


def _unroll(frame: Frame, loop: ast.For, values: list[Any]) -> Any:
    """Run the turns of a loop that its body may leave; return how the last one of them ends."""
    if not values:
        return RUNS
    code = _code_of(frame, [_Bind(loop.target, values[0]), *loop.body])
    if not isinstance(code, Value):
        return _unroll(frame, loop, values[1:]) if code in (RUNS, CONTINUES) else code
    ends = arithmetic.combine(
        "either", *[arithmetic.combine("equal", code, x) for x in (BREAKS, RETURNS)]
    )
    return frame.branch(ends, lambda: code, lambda: _unroll(frame, loop, values[1:]))


def _after_loop(code: Any) -> Any:
    """Return how a loop ends for what is around it: only returns go further."""
    return arithmetic.choose(arithmetic.combine("equal", code, RETURNS), RETURNS, RUNS)


def _is_endless(loop: ast.For | ast.While) -> bool:
    """Return whether only a return ends a loop."""
    return (
        isinstance(loop, ast.While)
        and isinstance(loop.test, ast.Constant)
        and not has_jump(loop, ast.Break)
    )
