"""Sources of functions: their syntax trees, the variables that parts of them assign and read, and outer names."""

import ast
import builtins
import inspect
import types
from functools import cache
from pathlib import Path
from typing import Any


class Source:
    """A function's syntax tree and where its outer names are looked up.

    Attributes:
        name: of the function.
        body: its statements.
    """

    def __init__(self, function: types.FunctionType, tree: ast.FunctionDef | ast.Lambda) -> None:
        """Take a function and its tree."""
        self.function, self.name = function, function.__name__
        self.body: list[ast.stmt] = [ast.Return(tree.body)] if isinstance(tree, ast.Lambda) else tree.body
        self.signature = inspect.signature(function)
        names = function.__code__.co_freevars
        self._cells = dict(zip(names, function.__closure__ or (), strict=True))
        self._later: dict[int, frozenset[str]] = {}

    def look_up(self, name: str) -> Any:
        """Return what an outer name stands for."""
        if name in self._cells:
            return self._cells[name].cell_contents
        variables = self.function.__globals__
        return variables[name] if name in variables else getattr(builtins, name)

    def place(self, node: ast.AST) -> str:
        """Return where a part of the function is, for messages."""
        file = Path(self.function.__code__.co_filename).name
        return f"{self.name} ({file}:{getattr(node, 'lineno', '?')})"


@cache
def _functions_of(file: str) -> dict[int, ast.FunctionDef | ast.Lambda]:
    """Return the functions of a file by the line that their code begins in: that of the first decorator."""
    found: dict[int, ast.FunctionDef | ast.Lambda] = {}
    for node in ast.walk(ast.parse(Path(file).read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef):
            found[min([node.lineno, *(decorator.lineno for decorator in node.decorator_list)])] = node
        elif isinstance(node, ast.Lambda):
            found.setdefault(node.lineno, node)
    return found


@cache
def source_of(function: types.FunctionType) -> Source:
    """Return the source of a function.

    Raises:
        OSError: there is no file with it.
    """
    code = function.__code__
    return Source(function, _functions_of(code.co_filename)[code.co_firstlineno])


@cache
def assigned_names(node: ast.AST) -> tuple[str, ...]:
    """Return the variables that a statement assigns, in the order of their first assignment."""
    names = [part.id for part in ast.walk(node) if isinstance(part, ast.Name) and isinstance(part.ctx, ast.Store)]
    return tuple(dict.fromkeys(names))


@cache
def has_exit(node: ast.AST) -> bool:
    """Return whether a statement may leave the function or a loop that it is part of."""
    return any(isinstance(part, ast.Return | ast.Break | ast.Continue) for part in ast.walk(node))


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
    """Return the variables that a statement uses, and whether it assigns them, in the order of execution."""
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
