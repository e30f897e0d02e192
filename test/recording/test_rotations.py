"""Rotations of recordings against scipy's."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from crane_sim.description.rotations import quaternions_of, rotation_matrices, rotations_about_z

# rad; quaternions of whole turns have either sign
ANGLES = np.random.default_rng(1).uniform(-3.0, 3.0, (100, 3))


def test_rotations_are_those_of_scipy() -> None:
    """Roll, pitch, yaw give scipy's quaternion up to its sign, any quaternion scipy's matrix."""
    expected = Rotation.from_euler("ZYX", ANGLES[:, ::-1])
    ours = quaternions_of(*ANGLES.T)
    sign = np.sign(np.sum(ours * expected.as_quat(), axis=1))[:, None]
    # a few roundings of numbers up to 1
    assert sign * ours == pytest.approx(expected.as_quat(), abs=1e-15)
    assert rotation_matrices(-3.0 * ours) == pytest.approx(expected.as_matrix(), abs=2e-15)
    about_z = Rotation.from_euler("z", ANGLES[:, :1]).as_matrix()
    assert rotations_about_z(ANGLES[:, 0]) == pytest.approx(about_z, abs=1e-15)
