"""Ropes have the colour of their tension."""

from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import crane_sim
from crane_sim.recording.rope_colors import (
    DOUBLE_COLOR,
    SLACK_COLOR,
    UNLOADED_COLOR,
    USUAL_COLOR,
    rope_colors,
    usual_tensions,
)


def test_colors_follow_the_tension() -> None:
    """Slack, usual, double and greater tensions differ in colour; others are in between."""
    tensions = np.array([[5.0, 100.0], [10.0, 0.0], [0.0, 50.0], [40.0, 1e-3]])
    usual = usual_tensions(tensions)
    assert usual.tolist() == [5.0, 100.0]
    colors = rope_colors(tensions, usual)
    assert [tuple(color) for color in colors[:, 0].tolist()] == [
        USUAL_COLOR,
        DOUBLE_COLOR,
        SLACK_COLOR,
        DOUBLE_COLOR,
    ]
    assert (
        tuple(colors[1, 1].tolist()) == SLACK_COLOR
        and tuple(colors[3, 1].tolist()) == UNLOADED_COLOR
    )
    assert np.array_equal(colors[2, 1], np.round(np.mean([UNLOADED_COLOR, USUAL_COLOR], axis=0)))


def test_a_rope_that_begins_slack_is_compared_to_its_largest_tension() -> None:
    """The reference is the first tension, of a rope without one the largest, never zero."""
    assert usual_tensions(np.array([[0.0, 0.0], [7.0, 0.0]])).tolist() == [7.0, 7.0]
    assert usual_tensions(np.zeros((3, 1))).tolist() == [1.0]


@pytest.mark.parametrize(
    ("scene", "colors"),
    [("knuckle_setpoint", "Cylinders3D:colors"), ("overhead_lqr", "LineStrips3D:colors")],
)
def test_the_viewer_gets_these_colors(scene: str, colors: str, tmp_path: Path) -> None:
    """A recording's rope begins in the usual colour, and changes it with its tension."""
    run = crane_sim.simulate(scene, duration=1.0)
    path = run.record(tmp_path / "run.rrd")
    batches = [
        chunk.to_record_batch()
        for chunk in RrdReader(path).stream()
        if chunk.entity_path == "/rope"
    ]
    rows = [
        row
        for batch in batches
        if colors in batch.schema.names
        for row in batch[colors].to_pylist()
    ]
    shown = np.array(
        [[color >> 24 & 255, color >> 16 & 255, color >> 8 & 255] for row in rows for color in row]
    )
    frames = run.tensions[:-1:3]  # a frame each 33 ms, of a run of 100 Hz
    expected = rope_colors(frames, usual_tensions(run.tensions))
    assert np.array_equal(shown, expected[:, 0]) and tuple(shown[0]) == USUAL_COLOR
    assert len(np.unique(shown, axis=0)) > 1, "the tension of this run does not change"
