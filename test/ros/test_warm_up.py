"""Warm-up of the plant: nothing is left to be compiled in a run, where the wall clock goes on."""

import sys
from pathlib import Path

import pytest
from process_helpers import run_to_completion

PROGRAM = Path(__file__).parents[1] / "programs" / "warm_up_coverage.py"


@pytest.mark.parametrize(
    "scene",
    [
        "knuckle_setpoint",
        # follows a path in the frame of a base that moves
        pytest.param("offshore_two_rate", marks=pytest.mark.long),
        pytest.param("tower_gust", marks=pytest.mark.long),
        pytest.param("overhead_sway", marks=pytest.mark.long),
        pytest.param("bridge_hook_and_sling", marks=pytest.mark.long),
    ],
)
def test_a_run_requires_no_function_that_the_warm_up_has_not_called(scene: str) -> None:
    """After a full block of rows and the summary, functions have the warm-up's signatures only.

    This holds for every compiled function.
    """
    command = [sys.executable, str(PROGRAM), scene]
    found = run_to_completion(command)
    assert not found.returncode, found.stderr
    assert found.stdout == ""
