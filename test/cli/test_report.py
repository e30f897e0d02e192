"""Terminal output after a run."""

import json
import random
import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from crane_sim import load_scene
from crane_sim.cli.report import _say_compiling, compiling, json_value, print_summary
from crane_sim.cli.sweep import show_progress
from crane_sim.numerics.jit import entry_point

SUMMARY = {
    "scene": "knuckle_setpoint",
    "law": "energy",
    "mode": "lockstep",
    "steps": 10,
    "deadline_misses": 3,
    "min_rope_tension": -0.0,
    "max_rope_tension": np.float32(9.8125),
    "peak_effort": {"slew": 2.4e-45, "boom": 5.0, "jib": 1.0, "rope": 9.0},
    "final_error": {"slew": -1e-22, "boom": 0.1, "jib": 0.1, "rope": 0.25},
    "recording": "runs/my run[new].rrd",
    "recorded_steps": 10,
    "lost_steps": 0,
    "before_reset": ["runs/my run[new].before_reset_1.rrd"],
    "left_out": "kp of law 'energy'",
}


@pytest.fixture
def lines(capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return the lines of a summary."""
    print_summary(SUMMARY, load_scene("knuckle_setpoint"))
    return capsys.readouterr().out.splitlines()


def test_metrics_have_their_units(lines: list[str]) -> None:
    """Final errors are in units of joints, peak efforts in those of efforts, and zero is zero."""
    rows = {line.split()[0]: re.split(r" {2,}", line.strip()) for line in lines if line.strip()}
    assert rows["rope"][1:] == ["0.25 m", "-", "9 N"] and rows["boom"][1:] == [
        "0.1 rad",
        "-",
        "5 N m",
    ]
    assert rows["slew"][1:] == ["0 rad", "-", "0 N m"]
    assert rows["min"][1] == "0 N" and rows["max"][1] == "9.812 N"


def test_files_are_named_with_what_opens_them(lines: list[str]) -> None:
    """A shell command that opens the recording is printed, and files from before a reset.

    No name is markup.
    """
    assert [line for line in lines if line.startswith("before reset ")][0].endswith(
        "my run[new].before_reset_1.rrd"
    )
    command = next(line for line in lines if line.startswith("open it with "))
    assert command.endswith("crane view 'runs/my run[new].rrd'")


def test_ignored_settings_are_listed(lines: list[str]) -> None:
    """Settings that a switch of the law ignores are in the table."""
    assert any("left out" in line and "kp of law 'energy'" in line for line in lines)


@pytest.mark.parametrize(
    ("changes", "title", "shown"),
    [
        ({}, "deadline misses", False),
        ({"mode": "realtime"}, "deadline misses", True),
        ({"compile_time": 0.0}, "compile time", False),
        ({"compile_time": 41.5}, "compile time", True),
    ],
)
def test_metrics_that_say_nothing_are_hidden(
    changes: dict[str, object], title: str, shown: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    """Deadlines are shown in real time, and the time of compilation if anything was compiled."""
    print_summary(SUMMARY | changes, load_scene("knuckle_setpoint"))
    assert (title in capsys.readouterr().out) == shown


def call_new_function() -> None:
    """Call a compiled function with a new constant, so that no code on the disk is the same."""
    factor = random.random()

    @entry_point
    def scaled(x):
        return factor * x

    assert scaled(1.0) == factor


@pytest.mark.parametrize(
    "wait", [lambda: compiling(quiet=False), lambda: show_progress("runs", quiet=True)]
)
def test_compilation_is_said_once(
    wait: Callable[[], Any], capsys: pytest.CaptureFixture[str]
) -> None:
    """If stderr is no terminal one line says that a kind of scene is compiled, and none if not."""
    _say_compiling.cache_clear()
    with wait():
        pass
    assert not capsys.readouterr().err
    with wait():
        for _ in range(2):
            call_new_function()
    assert re.fullmatch(
        r"crane: compiling this kind of scene \([^\n]*\)\n", capsys.readouterr().err
    )


def test_a_run_that_was_not_in_real_time_is_marked(capsys: pytest.CaptureFixture[str]) -> None:
    """The summary of a run in real time that the machine was too slow for says so in one line."""
    violation = "610 of 2500 steps were late, and 581 had no new command"
    print_summary(
        SUMMARY | {"mode": "realtime", "real_time_violation": violation},
        load_scene("knuckle_setpoint"),
    )
    lines = capsys.readouterr().out.splitlines()
    assert [line for line in lines if line.startswith(f"warning: not in real time: {violation}; ")]


def test_json_has_plain_numbers() -> None:
    """Numbers of numpy become Python's, tuples lists, negative zero 0, and non-finite ones null."""
    value = {
        "a": np.float64(0.1),
        "b": (np.int64(2), -0.0),
        "c": [float("nan"), np.float32(0.5)],
        "d": np.bool_(True),
    }
    assert json.dumps(json_value(value)) == '{"a": 0.1, "b": [2, 0.0], "c": [null, 0.5], "d": true}'
    assert type(json_value(value)["a"]) is float
