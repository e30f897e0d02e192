"""Regulators of plants whose efforts differ by many orders of magnitude."""

import numpy as np
import pytest

from crane_control.regulator import solve_regulator


@pytest.mark.parametrize("inertia", [1.0, 1e9])
def test_efforts_of_any_size_have_a_regulator(inertia: float) -> None:
    """Two double integrators, one heavy: the poles are those of each alone, s² + √3 s + 1 = 0.

    Of x'' = u / m with weights 1 of position and rate, and 1 / m² of the effort, the gain is
    m (1, √3): the algebraic Riccati equation by hand.
    """
    a = np.kron(np.eye(2), [[0.0, 1.0], [0.0, 0.0]])
    b = np.array([[0.0, 0.0], [1.0 / inertia, 0.0], [0.0, 0.0], [0.0, 1.0]])
    weights = np.array([inertia**-2.0, 1.0])
    gain, poles = solve_regulator(a, b, np.eye(4), weights, None)
    own = [1.0, np.sqrt(3.0)]
    expected = np.array([[*(inertia * np.array(own)), 0.0, 0.0], [0.0, 0.0, *own]])
    # rounding of a Riccati equation of four states
    np.testing.assert_allclose(gain / [[inertia], [1.0]], expected / [[inertia], [1.0]], atol=1e-12)
    np.testing.assert_allclose(np.sort(poles.real), -np.sqrt(3.0) / 2.0, rtol=1e-7)  # double poles
