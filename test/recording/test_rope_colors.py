"""Ropes have the colour of their tension."""

import numpy as np

from crane_sim.recording.rope_colors import DOUBLE, SLACK, UNLOADED, USUAL, rope_colors, usual_tensions


def test_colors_follow_the_tension() -> None:
    """Slack, usual, double and more are told apart, and what is between two of them lies between their colours."""
    tensions = np.array([[5.0, 100.0], [10.0, 0.0], [0.0, 50.0], [40.0, 1e-3]])
    usual = usual_tensions(tensions)
    assert usual.tolist() == [5.0, 100.0]
    colors = rope_colors(tensions, usual)
    assert [tuple(color) for color in colors[:, 0].tolist()] == [USUAL, DOUBLE, SLACK, DOUBLE]
    assert tuple(colors[1, 1].tolist()) == SLACK and tuple(colors[3, 1].tolist()) == UNLOADED
    assert np.array_equal(colors[2, 1], np.round(np.mean([UNLOADED, USUAL], axis=0)))


def test_a_rope_that_begins_slack_is_compared_to_its_largest_tension() -> None:
    """The reference is the first tension, of a rope without one the largest, and it is never zero."""
    assert usual_tensions(np.array([[0.0, 0.0], [7.0, 0.0]])).tolist() == [7.0, 7.0]
    assert usual_tensions(np.zeros((3, 1))).tolist() == [1.0]
