"""A second derivation of cranes by point masses, places in the world from coordinates.

Every body consists of point masses.

Virtual work of points needs no rates, no inertia tensors, no tensions and no rotating frames: with
the Jacobian J of the places r(t, q), M = Σ m Jᵀ J and M q'' = Σ m Jᵀ (g - r''|_{q''=0}) + Q.
Derivatives are central differences in multiple precision, exact to more digits than a double has.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import mpmath
import numpy as np
from mpmath import mp, mpf

Point = tuple[Any, Any, Any]
Places = Callable[[Any, Sequence[Any]], list[tuple[Any, Point]]]
# the error of a central difference is that of the step's square: 36 digits
DIGITS, STEP = 60, mpf(10) ** -18
G = mpf("9.81")


class Extras(NamedTuple):
    """What acts besides gravity and efforts."""

    inertia: Any = None  # (n,) on the diagonal, of winches
    potential: Any = None  # further potential energy [J] at (t, q), of springs
    pushed: Any = None  # a point's place in the world [m] at (t, q), on which
    push: Any = None  # a force [N] acts in the world, as a function of its velocity [m/s]


NOTHING = Extras()


def accelerations(
    places: Places, t: float, q: Any, v: Any, efforts: Any, extras: Extras = NOTHING
) -> Any:
    """Return the second derivatives (n,) of the coordinates.

    Args:
        places: (mass [kg], place in the world [m]) of each point at (t, q).
        t, q, v: time [s], coordinates (n,) and their rates.
        efforts: generalised forces (n,).
        extras: what else acts.
    """
    with mp.workdps(DIGITS):
        t, q, v = mpf(float(t)), [mpf(float(a)) for a in q], [mpf(float(a)) for a in v]
        n, h = len(q), STEP
        now = _places(places, t, q)
        ahead = _places(places, t + h, [a + h * b for a, b in zip(q, v, strict=True)])
        behind = _places(places, t - h, [a - h * b for a, b in zip(q, v, strict=True)])
        bias = [(a - 2 * b + c) / h**2 for a, b, c in zip(ahead[1], now[1], behind[1], strict=True)]
        columns = []
        for i in range(n):
            up, down = (
                _places(places, t, _moved(q, i, h))[1],
                _places(places, t, _moved(q, i, -h))[1],
            )
            columns.append([(a - b) / (2 * h) for a, b in zip(up, down, strict=True)])
        masses = [m for m in now[0] for _ in range(3)]
        gravity = [g for _ in now[0] for g in (mpf(0), mpf(0), -G)]
        matrix, right = mpmath.matrix(n, n), mpmath.matrix(n, 1)
        for i in range(n):
            weighted = [m * a for m, a in zip(masses, columns[i], strict=True)]
            missing = [g - b for g, b in zip(gravity, bias, strict=True)]
            right[i] = mpf(float(efforts[i])) + mpmath.fdot(weighted, missing)
            for k in range(n):
                matrix[i, k] = mpmath.fdot(weighted, columns[k])
            right[i] += _other_forces(extras, t, q, v, i)
            matrix[i, i] += mpf(float(extras.inertia[i])) if extras.inertia is not None else 0
        return np.array([float(a) for a in mpmath.lu_solve(matrix, right)])


def _other_forces(extras: Extras, t: Any, q: Any, v: Any, i: int) -> Any:
    """Return the generalised force along coordinate i of springs and of the push."""
    h, force = STEP, mpf(0)
    up, down = _moved(q, i, h), _moved(q, i, -h)
    if extras.potential is not None:
        force -= (extras.potential(t, up) - extras.potential(t, down)) / (2 * h)
    if extras.pushed is not None:
        ahead, behind = ([a + s * b for a, b in zip(q, v, strict=True)] for s in (h, -h))
        pairs = zip(extras.pushed(t + h, ahead), extras.pushed(t - h, behind), strict=True)
        push = extras.push([(a - b) / (2 * h) for a, b in pairs])
        moves = zip(extras.pushed(t, up), extras.pushed(t, down), strict=True)
        force += mpmath.fdot(push, [(a - b) / (2 * h) for a, b in moves])
    return force


def _moved(q: Sequence[Any], i: int, step: Any) -> list[Any]:
    """Return the coordinates with one of them moved."""
    return [a + (step if k == i else 0) for k, a in enumerate(q)]


def _places(places: Places, t: Any, q: Sequence[Any]) -> tuple[list[Any], list[Any]]:
    """Return (masses, places one after the other)."""
    points = places(t, q)
    return [m for m, _ in points], [a for _, place in points for a in place]


def rotate(axis: int, angle: Any, a: Point) -> Point:
    """Return a vector turned about an axis (0, 1, 2) by an angle, right-handed."""
    i, j = (axis + 1) % 3, (axis + 2) % 3
    s, c, out = mpmath.sin(angle), mpmath.cos(angle), list(a)
    out[i], out[j] = c * a[i] - s * a[j], s * a[i] + c * a[j]
    return out[0], out[1], out[2]


def plus(a: Sequence[Any], b: Sequence[Any]) -> Point:
    """Return the sum of two vectors."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def body_points(mass: float, inertia: Any) -> list[tuple[Any, Point]]:
    """Return six points about a rigid body's centre of mass with its mass and inertia (3, 3)."""
    second = 0.5 * np.trace(inertia) * np.eye(3) - inertia  # Σ m r rᵀ
    values, axes = np.linalg.eigh(second)
    assert values.min() >= 0.0, "no body has such an inertia"
    share = mpf(mass) / 6
    radii = [mpmath.sqrt(3 * mpf(float(value)) / mass) for value in values]
    return [
        (share, tuple(sign * radius * mpf(float(a)) for a in axis))
        for radius, axis in zip(radii, axes.T, strict=True)
        for sign in (1, -1)
    ]


def rod_points(mass: float, inertia: float, centre: Any) -> list[tuple[Any, Any]]:
    """Return (mass, distance along the rod) of a thin rod's two points, by its centre of mass."""
    half = mpmath.sqrt(mpf(inertia) / mpf(mass))
    return [(mpf(mass) / 2, centre + half), (mpf(mass) / 2, centre - half)]


def ring_points(inertia: float, angle: Any) -> list[tuple[Any, Point]]:
    """Return four points of a ring about z with this inertia, turned by an angle."""
    return [
        (mpf(inertia) / 4, rotate(2, angle + k * mp.pi / 2, (mpf(1), mpf(0), mpf(0))))
        for k in range(4)
    ]


def on_base(group: dict[str, Any], t: Any, place: Point) -> Point:
    """Return a place of the base in the world: a sinusoid for each axis of `base_motion`."""
    x = dict.fromkeys(("surge", "sway", "heave", "roll", "pitch", "yaw"), mpf(0))
    for name, term in group.items():
        x[name] = mpf(term["amplitude"]) * mpmath.sin(
            mpf(term["frequency"]) * t + mpf(term.get("phase", 0.0))
        )
    turned = rotate(2, x["yaw"], rotate(1, x["pitch"], rotate(0, x["roll"], place)))
    return plus((x["surge"], x["sway"], x["heave"]), turned)
