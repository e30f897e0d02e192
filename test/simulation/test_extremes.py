"""Extremes of joints in summaries: margins to travel limits; tilt, skew, trim and list of a load."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import crane_sim
from crane_sim.simulation.extremes import Extremes, tilt_of

RANDOM = Rotation.random(200, rng=np.random.default_rng(1))


def test_angles_are_those_of_rotations() -> None:
    """Skew, trim and list are SciPy's intrinsic z, y, x angles, the tilt is that of the third axis. 1e-9: at 90 deg."""
    angles = tilt_of(RANDOM.as_quat(scalar_first=True))
    expected = RANDOM.as_euler("ZYX")
    np.testing.assert_allclose(np.column_stack([angles.skew, angles.trim, angles.list]), expected, atol=1e-9)
    np.testing.assert_allclose(angles.tilt, np.arccos(RANDOM.as_matrix()[:, 2, 2]), atol=1e-9)


def test_small_tilts_are_exact() -> None:
    """A tilt of 1e-9 rad, which an arc cosine would lose, keeps 12 digits."""
    quaternion = Rotation.from_rotvec([6e-10, 8e-10, 0.0]).as_quat(scalar_first=True)
    assert tilt_of(quaternion[None, :]).tilt[0] == pytest.approx(1e-9, rel=1e-12)


def test_margins_are_of_the_whole_run() -> None:
    """The least distance to either limit counts, over blocks and the end alike, and is negative beyond a limit."""
    scene = crane_sim.load_scene("port_sts_container")  # trolley -20 .. 110, hoist 3 .. 55
    extremes, q = Extremes(scene), np.tile(scene.initial_q, (4, 1))
    q[:, 0], q[:, 2] = (0.0, 50.0, 100.0, 5.0), (20.0, 2.0, 20.0, 20.0)
    extremes.extend(q[:2])
    extremes.extend(q[2:3])
    metrics = extremes.summary(q[3])
    assert metrics["limit_margin"] == {"trolley": 10.0, "hoist": -1.0}
    assert set(metrics) == {"limit_margin", "peak_tilt_deg", "peak_skew_deg", "peak_trim_deg", "peak_list_deg"}


def test_loads_below_a_slewing_support_have_a_tilt_only() -> None:
    """A load that slews with its crane has a tilt, and neither skew, trim nor list; a point has no angle."""
    tower, overhead = crane_sim.load_scene("tower_gust"), crane_sim.load_scene("overhead_energy")
    assert set(Extremes(tower).summary(np.array(tower.initial_q))) == {"limit_margin", "peak_tilt_deg"}
    assert Extremes(overhead).summary(np.array(overhead.initial_q)) == {}
