"""Random small programs return and write, compiled, the bits that they do in Python."""

import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from random_programs import arguments, compiled, run, write_programs

from crane_sim.tracing import entry_point, machine_code
from crane_sim.tracing.llvm import module_text
from crane_sim.tracing.machine_code import LIGHT, NONE

CASES = 30  # arguments of each program


def check(function: Any) -> int:
    """Assert that a program, compiled, has the bits of Python; return for how many arguments.

    Python raises errors where it divides by zero, takes the root of a negative number or makes a
    NaN an integer; compiled code raises none, and there is nothing to compare.
    """
    code, compared = compiled(function), 0
    for case in range(CASES):
        given = arguments(case)
        with np.errstate(all="ignore"), warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of NumPy's numbers
            try:
                expected = run(function, given)
            except (ArithmeticError, ValueError):
                continue
        assert run(code, given) == expected, (function.__name__, case)
        compared += 1
    return compared


def check_all(seeds: range, folder: Path) -> None:
    """Assert that programs of some seeds have the bits of Python, for most arguments."""
    compared = sum(check(function) for function in write_programs(seeds, folder))
    assert compared > 0.5 * CASES * len(seeds)


@pytest.mark.parametrize(("optimisation", "seeds"), [(NONE, range(40)), (LIGHT, range(40, 60))])
def test_programs_have_the_bits_of_python(
    optimisation: Any, seeds: range, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Branches, loops, returns and arithmetic in any combination have the bits of Python.

    Optimising fully takes most of the time.
    """
    monkeypatch.setattr(entry_point, "module_texts", lambda entry: (module_text(entry), ""))
    monkeypatch.setattr(
        entry_point, "compile_text", lambda text, *_: machine_code.compile_text(text, optimisation)
    )
    check_all(seeds, tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("first", range(1000, 3000, 100))
def test_optimised_programs_have_the_bits_of_python(first: int, tmp_path: Path) -> None:
    """So do programs with all optimisations of the product."""
    check_all(range(first, first + 100), tmp_path)
