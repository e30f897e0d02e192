"""Extremes of joints in summaries: margins to travel limits; a load's tilt, skew, trim, list."""

import numpy as np
import pytest
from metric_rows import metrics_of
from scipy.spatial.transform import Rotation

import crane_sim
from crane_sim.simulation.totals import Tilt, tilt_of

ANGLES = ("peak_tilt_deg", "peak_skew_deg", "peak_trim_deg", "peak_list_deg")
RANDOM = Rotation.random(200, rng=np.random.default_rng(1))


def test_angles_are_those_of_rotations() -> None:
    """Skew, trim and list are SciPy's intrinsic z, y, x angles, the tilt that of the third axis.

    The tolerance is 1e-9 because of angles at 90 deg.
    """
    angles = Tilt(
        *np.transpose([tilt_of(quaternion) for quaternion in RANDOM.as_quat(scalar_first=True)])
    )
    expected = RANDOM.as_euler("ZYX")
    np.testing.assert_allclose(
        np.column_stack([angles.skew, angles.trim, angles.list]), expected, atol=1e-9
    )
    np.testing.assert_allclose(angles.tilt, np.arccos(RANDOM.as_matrix()[:, 2, 2]), atol=1e-9)


def test_small_tilts_are_exact() -> None:
    """A tilt of 1e-9 rad, which an arc cosine would lose, keeps 12 digits."""
    quaternion = Rotation.from_rotvec([6e-10, 8e-10, 0.0]).as_quat(scalar_first=True)
    assert tilt_of(quaternion).tilt == pytest.approx(1e-9, rel=1e-12)


def test_margins_are_of_the_whole_run() -> None:
    """The least distance to either limit counts, over blocks and the end, negative beyond it."""
    scene = crane_sim.load_scene("port_sts_container")  # trolley -20 .. 110, hoist 3 .. 55
    q = np.tile(scene.initial_q, (4, 1))
    q[:, 0], q[:, 2] = (0.0, 50.0, 100.0, 5.0), (20.0, 2.0, 20.0, 20.0)
    metrics = metrics_of(scene, q, (2,))
    assert metrics["limit_margin"] == {"trolley": 10.0, "hoist": -1.0}
    assert metrics.keys() >= set(ANGLES)


def test_loads_below_a_slewing_support_have_a_tilt_only() -> None:
    """A load that slews with its crane has only a tilt; a point has no angle."""
    tower, overhead = crane_sim.load_scene("tower_gust"), crane_sim.load_scene("overhead_energy")
    for scene, expected in ((tower, {"peak_tilt_deg"}), (overhead, set[str]())):
        metrics = metrics_of(scene, np.array([scene.initial_q]))
        assert metrics.keys() & set(ANGLES) == expected
