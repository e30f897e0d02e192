"""Where the payload should be at the target, against statics in closed form."""

from math import cos, sin
from typing import Any

import numpy as np
import pytest

from crane_sim import load_scene
from crane_sim.simulation.goals import target_position

G = 9.81
FRICTION = {
    "friction": {
        "slew": {"coulomb": 10e3, "static": 12e3},
        "trolley": {"coulomb": 600.0, "static": 900.0},
    }
}


@pytest.mark.parametrize("changes", [{}, FRICTION])
def test_the_target_is_below_a_jib_as_it_bends_there(changes: dict[str, Any]) -> None:
    """The target is below a jib that dips until its spring balances all weights.

    They are the weights of the jib, the trolley and the payload.
    """
    scene = load_scene("tower_flexible_jib", changes)
    slew, trolley, rope = 0.25 * np.pi, 40.0, 20.0
    stiffness, rest, moment = (
        3.3e8,
        0.0094,
        G * (10.5e3 * 30.0 + (550.0 + 450.0 + 4000.0) * trolley),
    )
    bend = 0.0
    for _ in range(20):  # a contraction by moment · bend / stiffness, 1e-4
        bend = rest - moment * cos(bend) / stiffness
    radius = trolley * cos(bend)
    expected = radius * cos(slew), radius * sin(slew), trolley * sin(bend) - rope - 3.0
    # 1e-8 m: the search for rest ends at 1e-9 rad/s², of a jib with 5 rad/s at 40 m 2e-9 m
    np.testing.assert_allclose(target_position(scene)[0], expected, rtol=0.0, atol=1e-8)
