"""Sources of functions: syntax trees, variables that parts of them use, and outer names."""

import ast
import builtins
import inspect
import os
import types
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

from crane_sim.tracing.cache import SOURCES_AT_IMPORT
from crane_sim.tracing.trace_error import TraceError

STRAIGHT = 12
"""Statements that a function consists of at most that is run in place: no branch, no loop, one
return at its end."""
_VARIABLE = inspect.CO_VARARGS | inspect.CO_VARKEYWORDS


class Source:
    """A function's syntax tree and where its outer names are looked up.

    Attributes:
        name: of the function.
        body: its statements.
        time_stamp: of its file, when it was read.
    """

    def __init__(
        self, function: types.FunctionType, tree: ast.FunctionDef | ast.Lambda, time_stamp: int
    ) -> None:
        """Take a function and its tree."""
        code = function.__code__
        self.function, self.name, self.time_stamp = function, function.__name__, time_stamp
        self.body: list[ast.stmt] = _body_of(tree)
        self.local_names = frozenset((*code.co_varnames, *code.co_cellvars))
        self._signature: inspect.Signature | None = None
        self._cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
        self._later: dict[int, frozenset[str]] = {}
        self.is_straight = (
            len(self.body) <= STRAIGHT
            and all(map(_is_straight, self.body[:-1]))
            and isinstance(self.body[-1], ast.Return)
            and "local_array" not in code.co_names  # which is in the frame of a function of its own
            and not hasattr(function, "slopes")  # which are of a call's results
        )

    def bind(self, arguments: list[Any], keywords: dict[str, Any]) -> dict[str, Any]:
        """Return the arguments of a call by the names of the parameters, with defaults.

        Raises:
            TypeError: they do not fit.
        """
        code = self.function.__code__
        plain = not keywords and len(arguments) == code.co_argcount
        if plain and not code.co_kwonlyargcount and not code.co_flags & _VARIABLE:
            return dict(zip(code.co_varnames, arguments, strict=False))
        if self._signature is None:
            self._signature = inspect.signature(self.function)
        bound = self._signature.bind(*arguments, **keywords)
        bound.apply_defaults()
        return dict(bound.arguments)

    def look_up(self, name: str) -> Any:
        """Return what an outer name stands for.

        Raises:
            TraceError: for nothing.
        """
        if name in self._cells:
            return self._cells[name].cell_contents
        variables = self.function.__globals__
        if name not in variables and not hasattr(builtins, name):
            raise TraceError(f"{name} is not defined")
        return variables[name] if name in variables else getattr(builtins, name)

    def place(self, node: ast.AST) -> str:
        """Return where a part of the function is, for messages."""
        file = Path(self.function.__code__.co_filename).name
        return (
            f"{self.name} ({file}:{getattr(node, 'lineno', self.function.__code__.co_firstlineno)})"
        )


def _is_straight(statement: ast.stmt) -> bool:
    return isinstance(statement, ast.Assign | ast.AnnAssign | ast.AugAssign | ast.Expr)


@cache
def _tree_of(file: str, time_stamp: int) -> ast.Module:
    """Return the tree of a file with this time stamp: a module may be imported anew."""
    return ast.parse(Path(file).read_text(encoding="utf-8"))


@cache
def _lines_of(file: str, time_stamp: int) -> list[str]:
    return [line + "\n" for line in Path(file).read_text(encoding="utf-8").split("\n")]


def _candidates(code: types.CodeType, version: tuple[str, int]) -> list[Any]:
    """Return the trees of a file that may be a function's."""
    if code.co_name == "<lambda>":
        return _lambdas_of(*version).get((code.co_name, code.co_firstlineno), [])
    alone = _parse_alone(code, _lines_of(*version))
    return (
        [alone] if alone else _functions_of(*version).get((code.co_name, code.co_firstlineno), [])
    )


def _parse_alone(code: types.CodeType, lines: list[str]) -> ast.FunctionDef | None:
    """Return the tree of a function's lines alone, in a tenth of its file's time, or None."""
    first = code.co_firstlineno - 1
    last = max(end for inner in _codes_in(code) for _, end, _, _ in inner.co_positions() if end)
    indent = _indent(lines[first])
    while last < len(lines) and lines[last].startswith(
        "def", indent
    ):  # a docstring alone has no code
        last += 1
    while last < len(lines) and (
        _indent(lines[last]) > indent or lines[last].strip()[:1] in ("", *")]}")
    ):
        last += 1
    opening = "\n" * (first - 1) + "if True:\n" if indent else "\n" * first
    try:
        (tree,) = ast.parse(opening + "".join(lines[first:last])).body
    except (SyntaxError, ValueError):
        return None
    if isinstance(tree, ast.If):
        (tree,) = tree.body if len(tree.body) == 1 else (None,)
    return tree if isinstance(tree, ast.FunctionDef) and tree.name == code.co_name else None


def _indent(line: str) -> int:
    return len(line) - len(line.lstrip())


@cache
def _codes_of(file: str, time_stamp: int) -> frozenset[types.CodeType]:
    """Return the code of all functions of a file."""
    return frozenset(
        _codes_in(compile(_tree_of(file, time_stamp), file, "exec", dont_inherit=True))
    )


def _codes_in(code: types.CodeType) -> Iterator[types.CodeType]:
    yield code
    for inner in code.co_consts:
        if isinstance(inner, types.CodeType):
            yield from _codes_in(inner)


@cache
def _functions_of(file: str, time_stamp: int) -> dict[tuple[str, int], list[Any]]:
    """Return functions by name and by the line of their first decorator or definition."""
    found: dict[tuple[str, int], list[Any]] = {}
    for node in _statements(_tree_of(file, time_stamp)):
        if isinstance(node, ast.FunctionDef):
            line = min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])
            found.setdefault((node.name, line), []).append(node)
    return found


def _statements(node: ast.AST) -> Iterator[ast.AST]:
    """Yield the statements that a module or a statement consists of, but not their expressions."""
    for part in _inner_statements(node):
        yield part
        yield from _statements(part)


def _inner_statements(node: ast.AST) -> Iterator[ast.AST]:
    for name in ("body", "orelse", "finalbody", "handlers"):
        yield from getattr(node, name, ())


@cache
def _lambdas_of(file: str, time_stamp: int) -> dict[tuple[str, int], list[Any]]:
    """Return the lambdas of a file by their line."""
    found: dict[tuple[str, int], list[Any]] = {}
    for node in ast.walk(_tree_of(file, time_stamp)):
        if isinstance(node, ast.Lambda):
            found.setdefault(("<lambda>", node.lineno), []).append(node)
    return found


@cache
def source_of(function: types.FunctionType) -> Source:
    """Return the source of a function.

    Raises:
        TraceError: there is no file with it, or the file is no longer that which was imported.
    """
    code = function.__code__
    file = code.co_filename
    try:
        version = file, os.stat(file).st_mtime_ns
        is_imported = SOURCES_AT_IMPORT.is_unchanged(file) or code in _codes_of(*version)
        candidates = _candidates(code, version)
    except (OSError, SyntaxError, ValueError) as error:
        raise TraceError(
            f"the source of {function.__name__}, {file}, cannot be read: {error}"
        ) from error
    if not is_imported:
        raise TraceError(
            f"{file} has changed since {function.__name__} was imported from it: start anew"
        )
    fitting = [tree for tree in candidates if len(candidates) == 1 or _contains(tree, code)]
    return Source(function, min(fitting, key=lambda tree: len(list(ast.walk(tree)))), version[1])


def _contains(tree: Any, code: types.CodeType) -> bool:
    """Return whether a function's code is from a tree's body, as of several on one line."""
    first, last = (
        (tree.body, tree.body) if isinstance(tree, ast.Lambda) else (tree.body[0], tree.body[-1])
    )
    start, end = (first.lineno, first.col_offset), (last.end_lineno, last.end_col_offset)
    places = [
        (a, c, b, d)
        for a, b, c, d in code.co_positions()
        if None not in (a, b, c, d) and (a, c) != (b, d)
    ]
    return all(start <= (a, c) and (b, d) <= end for a, c, b, d in places)


def _body_of(tree: ast.FunctionDef | ast.Lambda) -> list[ast.stmt]:
    if isinstance(tree, ast.Lambda):
        return [ast.copy_location(ast.Return(tree.body), tree.body)]
    return tree.body


@cache
def assigned_names(node: ast.AST) -> tuple[str, ...]:
    """Return the variables that a statement assigns, in the order of their first assignment."""
    names = [
        part.id
        for part in ast.walk(node)
        if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store)
    ]
    return tuple(dict.fromkeys(names))


@cache
def has_return(node: ast.AST) -> bool:
    """Return whether a statement may leave the function."""
    return isinstance(node, ast.Return) or any(
        isinstance(part, ast.Return) for part in _statements(node)
    )


@cache
def has_jump(loop: ast.For | ast.While, kinds: Any = ast.Break | ast.Continue) -> bool:
    """Return whether a loop's body may leave a turn of this loop by such a statement."""
    return any(
        isinstance(part, kinds) for statement in loop.body for part in _parts_of_turn(statement)
    )


@cache
def has_exit(statement: ast.stmt) -> bool:
    """Return whether a statement may leave the function, or a turn of its own loop."""
    jumps = any(isinstance(part, ast.Break | ast.Continue) for part in _parts_of_turn(statement))
    return jumps or has_return(statement)


def _parts_of_turn(statement: ast.AST) -> Iterator[ast.AST]:
    """Yield a statement and those inside it, without loops."""
    if isinstance(statement, ast.For | ast.While):
        return
    yield statement
    for part in _inner_statements(statement):
        yield from _parts_of_turn(part)


def always_leaves(statements: list[ast.stmt]) -> bool:
    """Return whether the last of some statements is seen to return or to raise on each way."""
    last = statements[-1] if statements else None
    if isinstance(last, ast.If):
        return always_leaves(last.body) and always_leaves(last.orelse)
    return isinstance(last, ast.Return | ast.Raise)


def names_read_later(source: Source, loop: ast.AST) -> frozenset[str]:
    """Return the variables whose next use behind a loop, in the order of the text, reads them."""
    if id(loop) not in source._later:
        source._later[id(loop)] = _find_read_later(source, loop)
    return source._later[id(loop)]


def _find_read_later(source: Source, loop: ast.AST) -> frozenset[str]:
    end, read, written = loop.end_lineno, set[str](), set[str]()  # type: ignore[attr-defined]
    for statement in source.body:
        for name, stores in _uses(statement):
            if name.lineno > end and name.id not in written | read:
                (written if stores else read).add(name.id)
    return frozenset(read)


def _uses(node: ast.AST) -> list[tuple[ast.Name, bool]]:
    """Return a statement's variables, in order of execution, and whether it assigns them."""
    if isinstance(node, ast.Name):
        return [(node, isinstance(node.ctx, ast.Store))]
    parts = list(ast.iter_child_nodes(node))
    if isinstance(node, ast.Assign):
        parts = [node.value, *node.targets]
    elif isinstance(node, ast.AugAssign):
        return [*_uses(node.value), *[(name, False) for name, _ in _uses(node.target)]]
    elif isinstance(node, ast.For):
        parts = [node.iter, node.target, *node.body, *node.orelse]
    return [use for part in parts for use in _uses(part)]
