"""A second way to the same cases: d'Alembert's principle in angles, lengths and trolley.

It is in double precision.

Nodes r(c) with Jacobian J give (J' m J + I) c'' = J' (f - m b) + Q, b being r'' at c'' = 0. No
constraint, no tension; generalised forces Q act on the coordinates themselves. Link k points along
n = (sin a cos b, sin b, -cos a cos b).
"""

from typing import NamedTuple

import numpy as np
from elastic import Elastic
from friction import StickSlip
from rigid import Real, Rigid
from scipy.integrate import solve_ivp
from solution import TIGHT, Case, world

Vector = np.ndarray


class Layout(NamedTuple):
    """The coordinates: trolley along `axes`, links' angles a (and b in space), free lengths.

    Lengths are those of links.
    """

    system: Rigid
    axes: list[int]
    free: list[int]  # links whose length is a coordinate

    @property
    def links(self) -> int:
        """Number of links."""
        return len(self.system.masses)

    @property
    def spatial(self) -> bool:
        """Whether links leave the plane."""
        return self.system.axes == 3

    @property
    def angles(self) -> int:
        """Where the angles begin among the coordinates."""
        return len(self.axes)

    @property
    def lengths(self) -> int:
        """Where the free lengths begin."""
        return self.angles + self.links * (2 if self.spatial else 1)


def layout(system: Rigid) -> Layout:
    """Return the coordinates of a system."""
    winch = [0] if system.winch_inertia is not None else []
    free = list(range(len(system.masses))) if isinstance(system, Elastic) else winch
    return Layout(system, [a for a, m in enumerate(system.trolley) if np.isfinite(m)], free)


def begin(case: Case, form: Layout) -> Vector:
    """Return coordinates and rates at the start of a case, from its nodes and velocities."""
    r, w = (world(half).astype(float) for half in (case.nodes, case.velocities))
    d, rate = np.diff(r, axis=0), np.diff(w, axis=0)
    size = np.linalg.norm(d, axis=1)
    n, speed = d / size[:, None], np.sum(d * rate, axis=1) / size
    turn = (rate - speed[:, None] * n) / size[:, None]
    flat = n[:, 0] ** 2 + n[:, 2] ** 2
    a, b = np.arctan2(n[:, 0], -n[:, 2]), np.arcsin(n[:, 1])
    adot, bdot = (turn[:, 2] * n[:, 0] - turn[:, 0] * n[:, 2]) / flat, turn[:, 1] / np.sqrt(flat)
    extra = ([b], [bdot]) if form.spatial else ([], [])
    q = np.concatenate([r[0, form.axes], a, *extra[0], size[form.free]])
    return np.concatenate([q, w[0, form.axes], adot, *extra[1], speed[form.free]])


def directions(a: Vector, b: Vector) -> tuple[Vector, Vector, Vector, Vector, Vector]:
    """Return n (N, 3), its derivatives by a, by b, by a and b, twice by a.

    Each is (N, 3); twice by b it is -n.
    """
    sa, ca, sb, cb = np.sin(a), np.cos(a), np.sin(b), np.cos(b)
    unit = np.stack([sa * cb, sb, -ca * cb], axis=1)
    by_a, by_b = (
        np.stack([ca * cb, 0 * a, sa * cb], axis=1),
        np.stack([-sa * sb, cb, ca * sb], axis=1),
    )
    by_ab, by_aa = (
        np.stack([-ca * sb, 0 * a, -sa * sb], axis=1),
        np.stack([-sa * cb, 0 * a, ca * cb], axis=1),
    )
    return unit, by_a, by_b, by_ab, by_aa


def kinematics(form: Layout, t: float, q: Vector, v: Vector) -> tuple[Vector, Vector, Vector]:
    """Return nodes (N + 1, 3), Jacobian (N + 1, 3, coordinates) and accelerations at c'' = 0."""
    n, start = form.links, form.angles
    a, adot = q[start : start + n], v[start : start + n]
    b, bdot = (
        (q[start + n : start + 2 * n], v[start + n : start + 2 * n])
        if form.spatial
        else (0 * a, 0 * a)
    )
    table = form.system.links(Real(t), Real(1), Real(0)).astype(float)
    table[:, form.free] = q[form.lengths :], v[form.lengths :], 0 * q[form.lengths :]
    length, rate, growth = table[:, :, None]
    unit, by_a, by_b, by_ab, by_aa = directions(a, b)
    a1, b1 = adot[:, None], bdot[:, None]
    spin = by_a * a1 + by_b * b1
    bias = (
        growth * unit
        + 2 * rate * spin
        + length * (by_aa * a1**2 + 2 * by_ab * a1 * b1 - unit * b1**2)
    )
    jacobian = np.zeros((n, 3, len(q)))
    for k in range(n):
        jacobian[k, :, start + k] = length[k] * by_a[k]
        if form.spatial:
            jacobian[k, :, start + n + k] = length[k] * by_b[k]
    for place, k in enumerate(form.free):
        jacobian[k, :, form.lengths + place] = unit[k]
    nodes, carried, bias = (
        np.concatenate([np.zeros((1, *part.shape[1:])), np.cumsum(part, axis=0)])
        for part in (length * unit, jacobian, bias)
    )
    for place, axis in enumerate(form.axes):
        nodes[:, axis] += q[place]
        carried[:, axis, place] = 1.0
    return nodes, carried, bias


def own_terms(form: Layout, t: float, q: Vector, v: Vector) -> tuple[Vector, Vector]:
    """Return inertias and generalised forces (coordinates,) of the coordinates themselves."""
    system, start = form.system, form.angles
    inertia, force = np.zeros(len(q)), np.zeros(len(q))
    angle = slice(start, start + form.links)
    if system.rotational_inertias is not None:
        inertia[angle] = system.rotational_inertias
    if system.stiffness is not None and system.damping is not None:
        torque = -np.array(system.stiffness) * np.diff(q[angle], prepend=0.0)
        torque -= np.array(system.damping) * np.diff(v[angle], prepend=0.0)
        force[angle] = torque - np.append(torque[1:], 0.0)
    if isinstance(system, Elastic):
        force[form.lengths :] = -system.spring * (q[form.lengths :] - np.array(system.lengths))
        force[form.lengths :] -= system.dashpot * v[form.lengths :]
    elif form.free:
        inertia[form.lengths], force[form.lengths] = (
            system.winch_inertia or 0.0,
            float(system.winch_force(Real(t))),
        )
    return inertia, force


def slope(t: float, y: Vector, form: Layout) -> Vector:
    """Return dy/dt of coordinates and rates."""
    q, v = np.split(y, 2)
    system = form.system
    _, jacobian, bias = kinematics(form, t, q, v)
    moved = [m if np.isfinite(m) else 0.0 for m in [*system.trolley, np.inf, np.inf]][:3]
    mass = np.vstack([moved, np.repeat(np.array(system.masses)[:, None], 3, axis=1)])
    force = -mass * bias
    force[:, 2] -= np.array([0.0, *system.masses]) * system.gravity
    push = system.drive(Real(t)).astype(float)
    force[0, form.axes] += push[form.axes]
    inertia, own = own_terms(form, t, q, v)
    flat = jacobian.reshape(-1, len(q))
    matrix = flat.T @ (mass.reshape(-1, 1) * flat) + np.diag(inertia)
    return np.concatenate([v, np.linalg.solve(matrix, flat.T @ force.ravel() + own)])


def covers(case: Case) -> bool:
    """Return whether a case has no events, nor stiffness beyond double precision.

    Events are those of friction or slackness.
    """
    systems, stiff = (
        [system for _, system in case.phases],
        case.settings[0].tolerance > TIGHT.tolerance,
    )
    return not stiff and not any(
        isinstance(s, StickSlip) or (isinstance(s, Elastic) and s.tension_only) for s in systems
    )


def course(case: Case) -> Vector:
    """Return the nodes (K, N + 1, 3) [m] at the instants of a case that this form covers."""
    y, t, found = begin(case, layout(case.phases[0][1])), 0.0, []
    for end, system in case.phases:
        form, stops = layout(system), [stop for stop in case.times if t < stop <= end]
        run = solve_ivp(
            slope, (t, end), y, "DOP853", [*stops], rtol=1e-13, atol=1e-13, args=(form,)
        )
        for stop, state in zip(stops, run.y.T, strict=True):
            found.append(kinematics(form, stop, *np.split(state, 2))[0])
        y, t = run.y[:, -1], end
    return np.array(found)
