"""Attitude of a rigid body: a unit quaternion (w, x, y, z) and its rates, so that no direction is singular.

The quaternion q takes vectors of the body to the base: r = q ⊗ r_b ⊗ q*. With the body's angular velocity ω in its own
axes q' = ½ q ⊗ ω and q'' = ½ q ⊗ α - ¼ |ω|² q, α = ω'.
"""

from math import sqrt


def align_quaternion(x, q, rate):
    """Return (unit quaternion, rate across it) nearest to those that begin at x[q] and x[rate]."""
    w, a, b, c = x[q], x[q + 1], x[q + 2], x[q + 3]
    scale = 1.0 / sqrt(w * w + a * a + b * b + c * c)
    w, a, b, c = w * scale, a * scale, b * scale, c * scale
    along = w * x[rate] + a * x[rate + 1] + b * x[rate + 2] + c * x[rate + 3]
    rates = (x[rate] - along * w, x[rate + 1] - along * a, x[rate + 2] - along * b, x[rate + 3] - along * c)
    return (w, a, b, c), rates


def rotation_of(q):
    """Return the rows of the rotation matrix R of a unit quaternion: r = R r_b."""
    w, a, b, c = q
    return (
        (1.0 - 2.0 * (b * b + c * c), 2.0 * (a * b - w * c), 2.0 * (a * c + w * b)),
        (2.0 * (a * b + w * c), 1.0 - 2.0 * (a * a + c * c), 2.0 * (b * c - w * a)),
        (2.0 * (a * c - w * b), 2.0 * (b * c + w * a), 1.0 - 2.0 * (a * a + b * b)),
    )


def angular_velocity_of(q, rate):
    """Return the angular velocity ω = 2 q* ⊗ q' (3,) [rad/s] in the body's axes."""
    (w, a, b, c), (dw, da, db, dc) = q, rate
    return (
        2.0 * (w * da - a * dw - b * dc + c * db),
        2.0 * (w * db - b * dw - c * da + a * dc),
        2.0 * (w * dc - c * dw - a * db + b * da),
    )


def quaternion_rate(q, omega):
    """Return q' = ½ q ⊗ ω (4,)."""
    (w, a, b, c), (x, y, z) = q, omega
    return (
        -0.5 * (a * x + b * y + c * z),
        0.5 * (w * x + b * z - c * y),
        0.5 * (w * y + c * x - a * z),
        0.5 * (w * z + a * y - b * x),
    )


def quaternion_acceleration(q, omega, alpha):
    """Return q'' (4,) of angular velocity ω [rad/s] and angular acceleration α [rad/s²], both in the body's axes."""
    w, a, b, c = quaternion_rate(q, alpha)
    quarter = 0.25 * (omega[0] * omega[0] + omega[1] * omega[1] + omega[2] * omega[2])
    return w - quarter * q[0], a - quarter * q[1], b - quarter * q[2], c - quarter * q[3]
