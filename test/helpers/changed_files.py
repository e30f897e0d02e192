"""Chooses the test files of `--changed`: those of files changed since the last commit, or new.

These are the test files that changed, that import a changed module, themselves or by a helper of
the tests, and that have the name of another changed file in their text. It is what to run while
working, not the whole suite.
"""

import ast
import subprocess
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path

import pytest

_HELPERS = ("test/helpers", "test/programs")


class ChangedFiles:
    """The changed files of a work tree, and the plugin that ignores the tests of others.

    They differ from the last commit.
    """

    def __init__(self, tree: Path) -> None:
        self._tree = tree
        self._named: dict[Path, bool] = {}

    def pytest_ignore_collect(self, collection_path: Path) -> bool | None:
        """Ignore a test file that no changed file concerns; pytest's rules apply to others."""
        if collection_path.suffix != ".py" or not collection_path.name.startswith("test_"):
            return None
        return None if self.concern(collection_path) else True

    def concern(self, path: Path) -> bool:
        """Tell whether this Python file changed, imports what changed, or names it."""
        if path not in self._named:
            self._named[path] = False  # where helpers import each other
            self._named[path] = path in self._changed or self._uses_changed(path)
        return self._named[path]

    @cached_property
    def _changed(self) -> set[Path]:
        against_commit = ["git", "diff", "--name-only", "--relative", "HEAD"]
        new = ["git", "ls-files", "--others", "--exclude-standard"]
        outputs = [
            subprocess.run(
                command, cwd=self._tree, capture_output=True, text=True, check=True, timeout=60.0
            ).stdout
            for command in (against_commit, new)
        ]
        return {self._tree / line for output in outputs for line in output.splitlines()}

    @cached_property
    def _modules(self) -> set[str]:
        relative = (path.relative_to(self._tree) for path in self._changed if path.suffix == ".py")
        names = (".".join(path.with_suffix("").parts) for path in relative)
        return {name.removesuffix(".__init__") for name in names}

    @cached_property
    def _other_names(self) -> set[str]:
        return {path.stem for path in self._changed if path.suffix != ".py"}

    def _uses_changed(self, path: Path) -> bool:
        text = path.read_text()
        imports = {*imports_in(ast.parse(text))}
        if any(is_inside(name, module) for name in imports for module in self._modules):
            return True
        if any(name in text for name in self._other_names):
            return True
        roots = {name.partition(".")[0] for name in imports}
        helpers = (self._tree / folder / f"{root}.py" for folder in _HELPERS for root in roots)
        return any(helper.is_file() and self.concern(helper) for helper in helpers)


def imports_in(tree: ast.Module) -> Iterator[str]:
    """Yield the dotted names that statements import, those in functions too."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


def is_inside(name: str, module: str) -> bool:
    """Return whether a dotted name is that of a module, or of something in it."""
    return name == module or name.startswith(f"{module}.")


def add_option(parser: pytest.Parser) -> None:
    """Add the option."""
    parser.addoption(
        "--changed",
        action="store_true",
        help="only test files of what differs from the last commit",
    )


def choose_files(config: pytest.Config) -> None:
    """Register the plugin where the option is given."""
    if config.option.changed:
        config.pluginmanager.register(ChangedFiles(config.rootpath))
