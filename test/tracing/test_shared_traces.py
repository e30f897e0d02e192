"""What is traced or parsed once serves all entry points, and nothing of it is stale."""

import ast
import importlib
import inspect
import os
from typing import Any

import numpy as np
import pytest

from crane_sim.numerics import linear_systems
from crane_sim.numerics.jit import generic
from crane_sim.tracing import scopes
from crane_sim.tracing.arguments import describe
from crane_sim.tracing.calls import Calls
from crane_sim.tracing.entry_point import compile_entry


def solve(a, b):
    """Return the solution of a system."""
    return linear_systems.solve_dense(a, linear_systems.factor_dense(a), b)


def solve_twice(a, b):
    """Return a solution with another right-hand side."""
    return linear_systems.solve_dense(a, linear_systems.factor_dense(a), 2.0 * b)


def traced_by(function: Any, monkeypatch: pytest.MonkeyPatch, *arguments: Any) -> list[str]:
    """Return the names of the functions that are traced when an entry point is compiled."""
    names: list[str] = []
    trace = Calls._trace

    def noted(self: Any, source: Any, *rest: Any) -> Any:
        names.append(source.name)
        return trace(self, source, *rest)

    with monkeypatch.context() as patch:
        patch.setattr(Calls, "_trace", noted)
        compile_entry(function, describe(arguments, [], {}))
    return names


def test_functions_are_traced_once_for_all_entry_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """A second entry point traces no functions that the first called with the same structure."""
    a, b = np.eye(3), np.ones(3)
    traced_by(solve, monkeypatch, a, b)
    # a short function runs in place of its call
    assert traced_by(solve_twice, monkeypatch, a, b) == []
    _, functions = compile_entry(solve_twice, describe((a, b), [], {}))
    # which code depends on
    assert {"factor_dense", "solve_dense"} <= {function.__name__ for function in functions}


def test_what_has_been_traced_is_forgotten_when_an_implementation_is_added(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A call may mean another function from then on."""
    a, b = np.eye(3), np.ones(3)
    traced_by(solve, monkeypatch, a, b)

    @generic
    def answer(x):
        return x

    answer.register(complex)(lambda x: x)
    assert "factor_dense" in traced_by(solve_twice, monkeypatch, a, b)


MODULES = (
    "numerics.arrays",
    "integrators.events",
    "models.suspended.crane",
    "hardware.drives",
    "numerics.rows",
)


@pytest.mark.parametrize("name", MODULES)
def test_a_function_alone_has_the_tree_that_it_has_in_its_file(name: str) -> None:
    """Functions parsed alone have their file's statements and places: decorated, nested, empty."""
    module: Any = importlib.import_module(f"crane_sim.{name}")
    file = inspect.getsourcefile(module)
    assert file
    version, compared = (file, os.stat(file).st_mtime_ns), 0
    for code in scopes._codes_of(*version):
        in_file = scopes._functions_of(*version).get((code.co_name, code.co_firstlineno), [])
        alone = scopes._parse_alone(code, scopes._lines_of(*version)) if in_file else None
        if alone:
            assert [ast.dump(alone, include_attributes=True)] == [
                ast.dump(x, include_attributes=True) for x in in_file
            ]
            compared += 1
    assert compared > 0
