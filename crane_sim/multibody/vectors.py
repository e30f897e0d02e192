"""Vectors (3,) and symmetric matrices (3, 3) as tuples of numbers, all in one system of axes."""

from typing import Any

Vector = tuple[Any, Any, Any]
"""Components along x, y, z."""
Matrix = tuple[Vector, Vector, Vector]
"""Rows."""

ZERO: Vector = (0, 0, 0)
IDENTITY: Matrix = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


def add(a: Vector, b: Vector) -> Vector:
    """Return a + b."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtract(a: Vector, b: Vector) -> Vector:
    """Return a - b."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scale(factor: Any, a: Vector) -> Vector:
    """Return a multiple of a."""
    return factor * a[0], factor * a[1], factor * a[2]


def dot(a: Vector, b: Vector) -> Any:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return the vector product a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def multiply(m: Matrix, a: Vector) -> Vector:
    """Return the product M a."""
    return dot(m[0], a), dot(m[1], a), dot(m[2], a)


def add_matrices(m: Matrix, n: Matrix) -> Matrix:
    """Return M + N."""
    return add(m[0], n[0]), add(m[1], n[1]), add(m[2], n[2])


def combine(axes: Matrix, components: Vector) -> Vector:
    """Return the vector with these components along axes: the sum of components[i] axes[i]."""
    return add(
        add(scale(components[0], axes[0]), scale(components[1], axes[1])),
        scale(components[2], axes[2]),
    )


def to_turned_axes(a: Vector, s: Any, c: Any) -> Vector:
    """Return the vector a in axes turned about z by an angle whose sine and cosine are s and c."""
    return c * a[0] + s * a[1], c * a[1] - s * a[0], a[2]


def acceleration_gradient(w: Vector, alpha: Vector) -> Matrix:
    """Return the matrix of r in α × r + ω × (ω × r), the acceleration in a rotating body."""
    xx, yy, zz = w[0] * w[0], w[1] * w[1], w[2] * w[2]
    xy, xz, yz = w[0] * w[1], w[0] * w[2], w[1] * w[2]
    return (
        (-(yy + zz), xy - alpha[2], xz + alpha[1]),
        (xy + alpha[2], -(xx + zz), yz - alpha[0]),
        (xz - alpha[1], yz + alpha[0], -(xx + yy)),
    )


def diagonal(x: Any, y: Any, z: Any) -> Matrix:
    """Return the matrix with these entries on its diagonal."""
    return (x, 0, 0), (0, y, 0), (0, 0, z)


def point_inertia(mass: Any, r: Vector) -> Matrix:
    """Return the inertia m (r² 1 - r rᵀ) [kg m²] of a mass at r about the origin."""
    x, y, z = scale(mass, r)
    xx, yy, zz = x * r[0], y * r[1], z * r[2]
    xy, xz, yz = -x * r[1], -x * r[2], -y * r[2]
    return (yy + zz, xy, xz), (xy, xx + zz, yz), (xz, yz, xx + yy)


def turned_inertia(axes: Matrix, inertia: Matrix) -> Matrix:
    """Return a body's inertia in the axes in which its own, `axes`, are given.

    It is the sum of I_ij e_i e_jᵀ.
    """
    columns = tuple(combine(axes, row) for row in inertia)  # Σ_j I_ij e_j
    rows = tuple(
        tuple(sum(axes[k][i] * columns[k][j] for k in range(3)) for j in range(3)) for i in range(3)
    )
    return rows  # type: ignore[return-value]
