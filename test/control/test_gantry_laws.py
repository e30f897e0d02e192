"""Laws on a load on falls: LQR linearises the load that hangs at the target."""

import numpy as np

from crane_sim import acceleration, load_scene
from crane_sim.simulation.linearisation import equilibrium


def test_lqr_linearises_an_untwisted_load() -> None:
    """From a start 40 m off, 20 m lower and skewed by a third of a turn, the load at the target rests and faces ahead.

    Falls that are fastened apart have a second equilibrium, twisted by half a turn.
    """
    start = {"initial": {"length": 34.0, "trolley": 40.0, "skew": "120 deg"}, "reference.q": [0.0, 2.0, 14.0]}
    scene = load_scene("spreader_skew", start)
    q, u = equilibrium(scene)
    assert np.abs(acceleration(scene, q, 0.0 * q, u)).max() < 1e-8  # m/s²: rounding of falls that carry 0.5 MN
    assert np.allclose(q[:3], scene.reference) and q[6] > np.cos(np.radians(1.0))
