"""Loops of independent turns, arrays on the stack, and turns' memory, against plain Python."""

import resource
from math import cos, sin
from typing import Any

import numpy as np
import pytest

from crane_sim.numerics.jit import (
    NONE,
    entry_point,
    local_array,
    optimisation,
    routine,
    simd_range,
    use_wide_vectors,
)
from crane_sim.tracing.arguments import describe
from crane_sim.tracing.entry_point import compile_entry
from crane_sim.tracing.machine_code import Optimisation


@entry_point
def fill_waves(n, x, out):
    """Fill rows of `out` with functions of rows of x, by a branch and by the C library."""
    use_wide_vectors()
    for k in simd_range(n):
        wave = sin(x[k]) + cos(x[k])
        out[0, k] = wave / (1.0 + x[k] * x[k])
        out[1, k] = x[k] - wave if wave > 0.5 else wave * 0.1


@pytest.mark.parametrize("n", [0, 1, 7, 8, 9, 37])
def test_independent_turns_have_the_bits_of_plain_python(n: int) -> None:
    """Any number of turns has the bits of Python in vectors; what is behind is untouched."""
    x, compiled, plain = np.linspace(-7.0, 9.0, 37), np.full((2, 37), 3.0), np.full((2, 37), 3.0)
    fill_waves(n, x, compiled)
    fill_waves.py_func(n, x, plain)
    assert compiled.tobytes() == plain.tobytes()


@entry_point
def sum_by_hand(x):
    """Return the sum of an array's entries times their numbers, by an array on the stack."""
    row, total = local_array((16,)), 0.0
    for k in simd_range(16):
        row[k] = x[k] * k
    for k in range(16):
        total += row[k]
    return total


def test_an_array_of_a_function_is_on_the_stack(monkeypatch: pytest.MonkeyPatch) -> None:
    """Its function allocates no memory, and reads what it has written."""
    x = np.linspace(-1.0, 2.0, 16)
    assert "call ptr @allocate" not in text_of(sum_by_hand, monkeypatch, x)
    monkeypatch.undo()
    assert sum_by_hand(x) == sum_by_hand.py_func(x)


@routine
def moved(x, by):
    """Return a new array."""
    return x + by


@entry_point
def go_on(x, steps):
    """Return the last two arrays of a sequence, and the end of the one before.

    Each turn makes several.
    """
    before, now, tail = x.copy(), moved(x, 1.0), x[1:]
    for k in range(steps):
        middle = moved(now, 0.25)
        for _ in range(k % 3):
            middle = moved(middle, 0.5)
        tail = moved(before, 2.0)[1:]
        before, now = now, moved(middle, -0.125) * 0.5
    return before.copy(), now.copy(), tail.copy()


def test_what_a_turn_leaves_behind_stays_as_it_is() -> None:
    """Arrays that the next turn reads, and parts of them, survive when older ones are freed."""
    x = np.linspace(0.0, 1.0, 9)
    for compiled, plain in zip(go_on(x, 50), go_on.py_func(x, 50), strict=True):
        assert compiled.tobytes() == plain.tobytes()


@entry_point
def find_first(x, limit):
    """Return the first of growing arrays whose first entry reaches a limit, from two loops."""
    for k in range(len(x), 1000):
        y = moved(x, 1.0 * k)
        for j in range(len(x), 1000):
            z = moved(y, 1.0 * j)
            if z[0] >= limit:
                return z
    return x


def test_an_array_that_is_returned_from_within_loops_survives() -> None:
    """What a loop returns is not freed as that of an earlier turn."""
    x = np.linspace(0.0, 1.0, 20)
    assert find_first(x, 1500.0).tobytes() == find_first.py_func(x, 1500.0).tobytes()


def test_memory_does_not_grow_with_the_turns_of_a_loop() -> None:
    """A thousand turns that allocate 100 kB several times need only a few of these at a time."""
    x = np.zeros(12_500)
    go_on(x, 10)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    go_on(x, 1_000)
    assert (
        resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000
    )  # kB, of half a million that they allocate


def text_of(function: Any, monkeypatch: pytest.MonkeyPatch, *arguments: Any) -> str:
    """Return the text that an entry point is compiled from."""
    texts: list[str] = []
    monkeypatch.setattr(
        "crane_sim.tracing.entry_point.compile_text",
        lambda text, _, loops: texts.append(text + loops) or b"",
    )
    compile_entry(function.py_func, describe(arguments, [], {}))
    return texts[0]


def test_what_is_said_of_a_loop_reaches_the_compiler(monkeypatch: pytest.MonkeyPatch) -> None:
    """A loop's turns are marked as independent, and its final function as of wide vectors."""
    text = text_of(fill_waves, monkeypatch, 8, np.ones(8), np.ones((2, 8)))
    assert "llvm.loop.parallel_accesses" in text
    assert any(
        "@entry" in line and '"prefer-vector-width"="512"' in line for line in text.splitlines()
    )


@routine
def element(x, i):
    """Return an element, from the end where i is negative."""
    return x[i]


@entry_point
def pick(x, i):
    """Return elements at an index of either sign, at it where positive, else first, and at 2."""
    return element(x, i), element(x, max(i, 0)), element(x, 2)


@pytest.mark.parametrize("i", [-3, -1, 0, 4])
def test_an_index_that_is_never_negative_is_told_from_one_that_may_be(i: int) -> None:
    """A function that is called with both kinds of index takes each as Python does."""
    x = np.linspace(1.0, 2.0, 5)
    assert pick(x, i) == pick.py_func(x, i)


@entry_point
def double_all(x):
    """Double all entries, one after the other."""
    for k in range(len(x)):
        x[k] = 2.0 * x[k]


def test_loops_that_ask_for_no_lanes_have_none(monkeypatch: pytest.MonkeyPatch) -> None:
    """An ordinary loop is one of scalars: lanes cost more to compile than most loops win."""
    text = text_of(double_all, monkeypatch, np.ones(8))
    assert '"llvm.loop.vectorize.enable", i1 false' in text and "parallel_accesses" not in text


@entry_point
@optimisation(NONE)
def look_once(x):
    """Return the first entry."""
    return x[0]


@pytest.mark.parametrize(
    ("function", "level"), [(look_once, NONE), (double_all, Optimisation.FULL)]
)
def test_code_is_optimised_as_its_function_says(
    function: Any, level: Optimisation, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What runs for a few instants is compiled quickly, what says nothing to fast code."""
    levels: list[Optimisation] = []
    monkeypatch.setattr(
        "crane_sim.tracing.entry_point.compile_text",
        lambda _, level, *__: levels.append(level) or b"",
    )
    compile_entry(function.py_func, describe((np.ones(2),), [], {}))
    assert levels == [level]
