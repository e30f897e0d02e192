"""A second derivation of cranes on a moving base.

It has Newton's law in the world, and the base's pose by the product rule.
"""

from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

Array = np.ndarray[Any, Any]
G = 9.81
AXES = ("surge", "sway", "heave", "roll", "pitch", "yaw")
DOWN = np.array([0.0, 0.0, -G])
TIGHT: Any = {"rtol": 1e-12, "atol": 1e-13}


def motion(group: dict[str, Any], t: float) -> Array:
    """Return (position, velocity, acceleration) of six axes (3, 6), one sinusoid for each."""
    axes = np.zeros((3, 6))
    for i, name in enumerate(AXES):
        if name in group:
            a, w, phase = (group[name].get(key, 0.0) for key in ("amplitude", "frequency", "phase"))
            s, c = np.sin(w * t + phase), np.cos(w * t + phase)
            axes[:, i] = a * s, a * w * c, -a * w * w * s
    return axes


def about(axis: int, angle: Array) -> Array:
    """Return a rotation about an axis with its first two time derivatives (3, 3, 3).

    They are from those of the angle.
    """
    i, j = (axis + 1) % 3, (axis + 2) % 3
    s, c = np.sin(angle[0]), np.cos(angle[0])
    matrix, first, second = np.zeros((3, 3, 3))
    matrix[axis, axis] = 1.0
    matrix[[i, i, j, j], [i, j, i, j]] = c, -s, s, c
    first[[i, i, j, j], [i, j, i, j]] = -s, -c, c, -s
    second[[i, i, j, j], [i, j, i, j]] = -c, s, -s, -c
    return np.array([matrix, angle[1] * first, angle[2] * first + angle[1] ** 2 * second])


def product(a: Array, b: Array) -> Array:
    """Return a product and its derivatives from those of the factors.

    The factors are two matrices, or a matrix and a vector.
    """
    return np.array(
        [a[0] @ b[0], a[1] @ b[0] + a[0] @ b[1], a[2] @ b[0] + 2.0 * a[1] @ b[1] + a[0] @ b[2]]
    )


def pose(group: dict[str, Any], t: float) -> tuple[Array, Array]:
    """Return the base's (rotation, place) with two time derivatives, (3, 3, 3) and (3, 3)."""
    axes = motion(group, t)
    rotation = product(product(about(2, axes[:, 5]), about(1, axes[:, 4])), about(0, axes[:, 3]))
    return rotation, axes[:, :3]


class Crane(NamedTuple):
    """A trolley on a bridge with its mass in the middle, and a chain of links.

    These are rigid (stiffness 0) or elastic.
    """

    trolley: float
    bridge: float
    masses: tuple[float, ...]
    lengths: tuple[float, ...]
    stiffness: float = 0.0


def accelerations(crane: Crane, group: dict[str, Any], t: float, y: Array) -> Array:
    """Return the derivative of y: positions, then rates.

    Positions are trolley x, y on the base and the nodes in the world (3 N).
    """
    n, (rotation, place), half = len(crane.masses), pose(group, t), len(y) // 2
    rail, rail_rate = np.append(y[:2], 0.0), np.append(y[half : half + 2], 0.0)
    top = place + product(rotation, np.array([rail, rail_rate, np.zeros(3)]))
    beam = place + product(
        rotation, np.array([[0.0, rail[1], 0.0], [0.0, rail_rate[1], 0.0], np.zeros(3)])
    )
    apart = np.diff(np.vstack([top[0], y[2:half].reshape(n, 3)]), axis=0)
    rates = np.diff(np.vstack([top[1], y[half + 2 :].reshape(n, 3)]), axis=0)
    along = rotation[0][:, :2].T  # directions of the rails in the world
    size = 2 + 3 * n
    mass = np.diag([crane.trolley, crane.trolley + crane.bridge, *np.repeat(crane.masses, 3)])
    force = np.append(np.zeros(2), np.kron(crane.masses, DOWN))
    force[0] = crane.trolley * along[0] @ (DOWN - top[2])
    force[1] = along[1] @ (crane.trolley * (DOWN - top[2]) + crane.bridge * (DOWN - beam[2]))
    # by links: the direction in which a unit of tension pulls
    pulls, known = np.zeros((n, size)), np.zeros(n)
    for k in range(n):
        pulls[k, 2 + 3 * k : 5 + 3 * k] = -apart[k]
        if k > 0:
            pulls[k, 3 * k - 1 : 3 * k + 2] = apart[k]
        else:
            pulls[0, :2] = along @ apart[0]
        known[k] = rates[k] @ rates[k] - (apart[0] @ top[2] if k == 0 else 0.0)
    if crane.stiffness:
        length = np.linalg.norm(apart, axis=1)
        solution = np.linalg.solve(
            mass, force + pulls.T @ (crane.stiffness * (length - crane.lengths) / length)
        )
    else:
        whole = np.block([[mass, -pulls.T], [pulls, np.zeros((n, n))]])
        solution = np.linalg.solve(whole, np.append(force, known))[:size]
    return np.append(y[half:], solution)


def nodes(crane: Crane, group: dict[str, Any], start: Array, rates: Array, times: Array) -> Array:
    """Return the trolley's and the nodes' places in the world at `times` (K, N + 1, 3).

    Args:
        crane, group: the crane, and the motion of its base.
        start, rates: place and velocity on the base of the trolley (first row, z = 0) and the nodes
            (N + 1, 3).
        times: s, from 0 on.
    """
    rotation, place = pose(group, 0.0)
    world = np.array(
        [
            place + product(rotation, np.array([r, v, 0.0 * r]))
            for r, v in zip(start, rates, strict=True)
        ]
    )
    y = np.concatenate([start[0, :2], world[1:, 0].ravel(), rates[0, :2], world[1:, 1].ravel()])
    run = solve_ivp(
        lambda t, y: accelerations(crane, group, t, y),
        (0.0, times[-1]),
        y,
        "DOP853",
        times,
        **TIGHT,
    )
    places = np.empty((len(times), len(start), 3))
    for i, (t, row) in enumerate(zip(times, run.y.T, strict=True)):
        rotation, place = pose(group, t)
        places[i, 0] = place[0] + rotation[0] @ np.append(row[:2], 0.0)
        places[i, 1:] = row[2 : 2 + 3 * len(crane.masses)].reshape(-1, 3)
    return places


class Plane(NamedTuple):
    """A trolley with viscous friction, and links that turn as rods.

    The first link's length is a function of time.
    """

    trolley: float
    viscous: float
    masses: tuple[float, ...]
    lengths: tuple[float, ...]
    inertia: float
    hoist: Any  # the first length and its derivatives (3,) at a time


def plane_rates(crane: Plane, group: dict[str, Any], t: float, y: Array) -> Array:
    """Return the derivative of y = (trolley x, angles, their rates).

    By d'Alembert's principle in the world.
    """
    n, (rotation, place), half = len(crane.masses), pose(group, t), len(y) // 2
    q, v = y[:half], y[half:]
    lengths = np.zeros((3, n))
    lengths[0], lengths[:, 0] = crane.lengths, crane.hoist(t)
    at, by = np.array([[q[0], 0.0, 0.0], [v[0], 0.0, 0.0], np.zeros(3)]), np.zeros((3, half))
    by[0, 0] = 1.0
    mass, force = np.zeros((half, half)), np.zeros(half)

    def add(m: float) -> None:
        """Add a mass at `at`, which moves by `by` (3, half) on the base with the joints."""
        left = (rotation[0] @ by).T * m
        mass[:] += left @ rotation[0] @ by
        force[:] += left @ (DOWN - (place + product(rotation, at))[2])

    add(crane.trolley)
    force[0] -= crane.viscous * v[0]
    tilt = motion(group, t)[2, 4]  # angles of links grow against turns about y
    for k in range(n):
        s, c, rate = np.sin(q[k + 1]), np.cos(q[k + 1]), v[k + 1]
        down, across, (length, paid, gain) = (
            np.array([s, 0.0, -c]),
            np.array([c, 0.0, s]),
            lengths[:, k],
        )
        at[0] += length * down
        at[1] += paid * down + length * rate * across
        at[2] += (gain - length * rate**2) * down + 2.0 * paid * rate * across
        by[:, k + 1] = length * across
        add(crane.masses[k])
        mass[k + 1, k + 1] += crane.inertia
        force[k + 1] += crane.inertia * tilt
    return np.append(v, np.linalg.solve(mass, force))


def plane_nodes(crane: Plane, group: dict[str, Any], y: Array, times: Array) -> Array:
    """Return places in the world at `times` (K, N + 1, 3), from joints and rates y at 0.

    They are those of trolley and nodes.
    """
    run = solve_ivp(
        lambda t, y: plane_rates(crane, group, t, y), (0.0, times[-1]), y, "DOP853", times, **TIGHT
    )
    places = np.zeros((len(times), len(crane.masses) + 1, 3))
    for i, (t, row) in enumerate(zip(times, run.y.T, strict=True)):
        rotation, place = pose(group, t)
        lengths, angles = (
            np.append(crane.hoist(t)[0], crane.lengths[1:]),
            row[1 : 1 + len(crane.masses)],
        )
        links = lengths[:, None] * np.stack([np.sin(angles), 0.0 * angles, -np.cos(angles)], axis=1)
        local = np.cumsum(np.vstack([[row[0], 0.0, 0.0], links]), axis=0)
        places[i] = place[0] + local @ rotation[0].T
    return places
