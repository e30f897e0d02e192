"""Attitude of a rigid body: a unit quaternion q = (w, x, y, z) and its rate.

No direction is singular.

It takes vectors of the body to the axes that the attitude is given in: r = q ⊗ r_b ⊗ q*. With the
angular velocity ω in the body's axes q' = ½ q ⊗ ω and q'' = ½ q ⊗ ω' - ¼ |ω|² q.
"""

from typing import Any

from crane_sim.multibody.linear import inner
from crane_sim.multibody.vectors import Matrix, Vector, dot
from crane_sim.tracing.operations import sqrt

Quaternion = tuple[Any, Any, Any, Any]


def align(
    vector: tuple[Any, ...], rate: tuple[Any, ...]
) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """Return (unit vector, rate across it) nearest to a vector of any size and its rate.

    Size is its number of components.
    """
    inverse = 1.0 / sqrt(inner(vector, vector))
    unit = tuple(x * inverse for x in vector)
    along = inner(unit, rate)
    return unit, tuple(y - along * x for x, y in zip(unit, rate, strict=True))


def rotation(q: Quaternion) -> Matrix:
    """Return the rows of R: r = R r_b."""
    w, a, b, c = q
    return (
        (1.0 - 2.0 * (b * b + c * c), 2.0 * (a * b - w * c), 2.0 * (a * c + w * b)),
        (2.0 * (a * b + w * c), 1.0 - 2.0 * (a * a + c * c), 2.0 * (b * c - w * a)),
        (2.0 * (a * c - w * b), 2.0 * (b * c + w * a), 1.0 - 2.0 * (a * a + b * b)),
    )


def angular_velocity(q: Quaternion, rate: Quaternion) -> Vector:
    """Return ω = 2 q* ⊗ q' [rad/s] in the body's axes."""
    (w, a, b, c), (dw, da, db, dc) = q, rate
    return (
        2.0 * (w * da - a * dw - b * dc + c * db),
        2.0 * (w * db - b * dw - c * da + a * dc),
        2.0 * (w * dc - c * dw - a * db + b * da),
    )


def quaternion_rate(q: Quaternion, omega: Vector) -> Quaternion:
    """Return q' [1/s] of an angular velocity [rad/s] in the body's axes."""
    (w, a, b, c), (x, y, z) = q, omega
    return (
        -0.5 * (a * x + b * y + c * z),
        0.5 * (w * x + b * z - c * y),
        0.5 * (w * y + c * x - a * z),
        0.5 * (w * z + a * y - b * x),
    )


def quaternion_acceleration(q: Quaternion, omega: Vector, omega_rate: Vector) -> Quaternion:
    """Return q'' [1/s²] of ω [rad/s] and ω' [rad/s²] in the body's axes."""
    quarter = 0.25 * dot(omega, omega)
    linear = quaternion_rate(q, omega_rate)
    return tuple(x - quarter * y for x, y in zip(linear, q, strict=True))  # type: ignore[return-value]
