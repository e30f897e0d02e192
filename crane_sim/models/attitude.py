"""Attitude of a rigid body: a unit quaternion (w, x, y, z) and its rates, so that no direction is singular.

The quaternion q takes vectors of the body to the base: r = q ⊗ r_b ⊗ q*. With the body's angular velocity ω in its own
axes q' = ½ q ⊗ ω and q'' = ½ q ⊗ α - ¼ |ω|² q, α = ω'.
"""

from math import sqrt

from crane_sim.multibody.attitude import angular_velocity as angular_velocity_of
from crane_sim.multibody.attitude import quaternion_acceleration, quaternion_rate
from crane_sim.multibody.attitude import rotation as rotation_of

__all__ = ["align_quaternion", "angular_velocity_of", "quaternion_acceleration", "quaternion_rate", "rotation_of"]


def align_quaternion(x, q, rate):
    """Return (unit quaternion, rate across it) nearest to those that begin at x[q] and x[rate]."""
    w, a, b, c = x[q], x[q + 1], x[q + 2], x[q + 3]
    scale = 1.0 / sqrt(w * w + a * a + b * b + c * c)
    w, a, b, c = w * scale, a * scale, b * scale, c * scale
    along = w * x[rate] + a * x[rate + 1] + b * x[rate + 2] + c * x[rate + 3]
    rates = (x[rate] - along * w, x[rate + 1] - along * a, x[rate + 2] - along * b, x[rate + 3] - along * c)
    return (w, a, b, c), rates
