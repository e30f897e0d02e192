"""What a person reads at the terminal after a run."""

import pytest

from crane_sim import load_scene
from crane_sim.cli.report import print_summary

SUMMARY = {
    "scene": "knuckle_setpoint",
    "law": "energy",
    "mode": "lockstep",
    "steps": 10,
    "min_rope_tension": -0.0,
    "peak_effort": {"slew": 2.4e-45, "boom": 5.0, "jib": 1.0, "rope": 9.0},
    "final_error": {"slew": -1e-22, "boom": 0.1, "jib": 0.1, "rope": 0.25},
    "recording": "runs/my run.rrd",
    "recorded_steps": 10,
    "lost_steps": 0,
    "before_reset": ["runs/my run.before_reset_1.rrd"],
    "left_out": "kp of law 'energy'",
}


@pytest.fixture
def told(capsys: pytest.CaptureFixture[str]) -> list[str]:
    """Return the lines of a summary."""
    print_summary(SUMMARY, load_scene("knuckle_setpoint"))
    return capsys.readouterr().out.splitlines()


def test_figures_have_their_units(told: list[str]) -> None:
    """Final errors are in the units of the joints, peak efforts in those of the efforts, and zero is zero."""
    rows = {line.split()[1]: line for line in told if line.startswith("│ ")}
    assert "0.25 m " in rows["rope"] and "9 N " in rows["rope"]
    assert "0.1 rad " in rows["boom"] and "5 N m " in rows["boom"]
    assert "│ 0 rad " in rows["slew"] and "│ 0 N m " in rows["slew"]
    assert rows["min"].split("│")[2].strip() == "0 N"


def test_files_are_named_with_what_opens_them(told: list[str]) -> None:
    """The recording stands there with the command that opens it as it can be pasted, and files from before a reset."""
    assert [line for line in told if line.startswith("before reset ")][0].endswith("my run.before_reset_1.rrd")
    command = next(line for line in told if line.startswith("open it with "))
    assert command.endswith("rerun 'runs/my run.rrd'")


def test_what_was_left_out_is_told(told: list[str]) -> None:
    """Settings that a switch of the law has left out stand in the table."""
    assert any("left out" in line and "kp of law 'energy'" in line for line in told)
