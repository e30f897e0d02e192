"""Untraced constructs are one-line errors naming construct, function, file and line."""

import random
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from random_programs import compiled

from crane_sim.files.errors import SceneError
from crane_sim.tracing.entry_point import EntryPoint
from crane_sim.tracing.trace_error import TraceError

_TABLE = {"a": 1.0}
_LIST = [1.0]


def _tries(x: float) -> float:
    try:
        return x
    except ValueError:
        return 0.0


def _uses_with(x: float) -> float:
    with open("/dev/null"):
        return x


def _assigns_to_a_dictionary(x: float) -> float:
    _TABLE["a"] = x
    return x


def _grows_a_list(x: float) -> float:
    if x > 0.0:
        _LIST.append(2.0)
    return x


def _has_a_function(x: float) -> float:
    def inner(y: float) -> float:
        return y

    return inner(x)


def _calls_itself(n: int) -> int:
    return n if n < 2 else n * _calls_itself(n - 1)


def _reads_nothing(x: float) -> float:
    if x > 0.0:
        y = x
    return y


def _raises(x: float) -> float:
    if x > 0.0:
        raise ValueError("above")
    return x


def _loops_over_a_number(x: float) -> float:
    for y in x:  # type: ignore[attr-defined]
        return y
    return x


def _has_an_else(n: int) -> int:
    for i in range(n):
        if i == 3:
            break
    else:
        return 7
    return n


CASES: list[tuple[Callable[..., Any], str]] = [
    (_tries, "`try:` is not traced"),
    (_uses_with, "`with open('/dev/null'):` is not traced"),
    (_assigns_to_a_dictionary, "`_TABLE['a'] = …` is not traced"),
    (_grows_a_list, "list.append is not traced"),
    (_has_a_function, "`def inner(y: float) -> float:` is not traced"),
    (_calls_itself, "_calls_itself calls itself: recursion is not traced"),
    (_reads_nothing, "y may have no value here, or values of two types"),
    (_raises, "`raise ValueError('above')` would run"),
    (_loops_over_a_number, "a loop over a number is not traced"),
    (_has_an_else, "`else` of a loop is not traced"),
    (lambda x: {x, 1.0}, "`{x, 1.0}` is not traced"),
    (lambda x: np.linalg.norm((x, x)), "norm is not traced"),
    (lambda x: np.array([x, 2.0]), "array is not traced"),
    (lambda x: random.gauss(x, 1.0), "is not traced"),
    (lambda x: random.random() * x, "is not traced"),
    (lambda x: f"{x}".upper() + x, "of a number and str is not traced"),
    (lambda x: x[0], "a number has no elements"),
    (lambda x: x.real, "real of a number is not traced"),
    (lambda x: unknown_name * x, "unknown_name is not defined"),  # type: ignore[name-defined]  # noqa: F821
    (lambda x: (1.0, 2.0)[5] * x, "IndexError: tuple index out of range"),
    (lambda x: x @ x, "a product of matrices is not traced"),
]


@pytest.mark.parametrize(("function", "message"), CASES)
def test_what_is_not_traced_is_named(function: Any, message: str) -> None:
    """The line begins with what is not traced, and says where."""
    with pytest.raises(TraceError) as raised:
        compiled(function)(3 if "n" in function.__code__.co_varnames[:1] else 1.5)
    text = str(raised.value)
    assert message in text and "\n" not in text
    assert f"{function.__name__} ({Path(__file__).name}:" in text


def _outermost(x: float) -> float:
    return _outer(x)


def _outer(x: float) -> float:
    return _middle(x)


def _middle(x: float) -> float:
    if x > 1.0:
        for _ in range(3):
            x = _tries(x)
    return x


def test_the_innermost_places_are_named() -> None:
    """Three functions are named once, from the inside out, in the error of a user's input."""
    entry = EntryPoint(_outermost)
    with pytest.raises(SceneError, match="cannot be compiled: `try:` is not traced") as raised:
        entry(1.0)
    places = str(raised.value).partition(", in ")[2].split(", called by ")
    assert [place.split()[0] for place in places] == ["_tries", "_middle", "_outer"]
