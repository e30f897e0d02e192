"""Units of metrics that depend on the scene: errors of a path of the payload or of joints."""

from typing import Any

import pytest

import crane_sim
from crane_sim.cli.report import print_summary
from crane_sim.recording.metric_units import metric_row, summary_table
from crane_sim.recording.path_units import path_unit
from crane_sim.recording.read import as_recorded
from crane_sim.report.page_data import plain_metrics

PATH = {
    "kind": "point_to_point",
    "of": "joints",
    "from": [0.0, 0.5, -0.2],
    "to": [1.0, 0.9, -0.3],
    "velocity": 0.5,
    "acceleration": 0.5,
}
DRIVE = {"drive": "velocity", "servo": {"gain": 500.0, "integral_time": 1.0}}
CHANGES: dict[str, Any] = {
    "duration": 0.3,
    "control": {
        "law": "joint_trajectory",
        "period": 0.01,
        "drive": "velocity",
        "position_gain": 1.0,
    },
    "actuators": dict.fromkeys(("slew", "boom", "jib"), DRIVE),
    "rope": {"drive": "locked"},
    "reference": {"path": PATH},
    "limits": None,
}


def test_errors_of_a_path_of_joints_have_the_joints_unit(
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Terminal, page, comparison and summary show the errors of a path of angles as angles."""
    rollout = crane_sim.simulate("knuckle_setpoint", overrides=CHANGES)
    run = as_recorded(rollout)
    assert run.path_unit == "rad"
    print_summary(rollout.summary, rollout.scene)
    shown = [line.split() for line in capsys.readouterr().out.splitlines() if "tracking" in line]
    assert [line[-1] for line in shown] == ["rad²", "rad", "rad"]
    on_page = [
        value.split()[-1] for name, value in plain_metrics(run) if name.startswith("tracking")
    ]
    assert on_page == ["rad²", "rad", "rad"]
    assert metric_row("tracking_mse", [run, run], (1.0, 2.0))[1:] == (
        "deg²",
        ["3282.8", "6565.6", "3282.8"],
    )
    assert metric_row("tracking_peak", [run, run], (1.0, 2.0))[1:] == (
        "deg",
        ["57.296", "114.59", "57.296"],
    )


def test_the_unit_of_a_path_is_that_of_all_its_coordinates() -> None:
    """A payload's path is in m, one of joints in their unit, in none where theirs differ."""
    assert [path_unit(True, units) for units in (("m", "m"), ("rad",), ("rad", "m"))] == [
        "m",
        "rad",
        "",
    ]
    assert path_unit(False, ("rad", "m")) == "m"
    for unit, cell in (("rad", "| tracking mse | 2 rad² |"), ("", "| tracking mse | 2 |")):
        assert cell in summary_table("run", {"tracking_mse": 2.0}, unit)


def test_angles_have_their_unit() -> None:
    """Metrics in degrees say so under any name; others have their unit or none."""
    table = summary_table(
        "run",
        {"peak_tilt_deg": 12.0, "peak_swing_deg": 1.5, "steps": 3, "peak_effort": {"slew": 2.0}},
        "m",
    )
    for row in (
        "| peak tilt | 12 ° |",
        "| peak swing | 1.5 ° |",
        "| steps | 3 |",
        "peak effort [N m, N]",
    ):
        assert row in table
