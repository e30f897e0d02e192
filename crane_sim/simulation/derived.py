"""Quantities derived from the joint coordinates of a run: positions, energies, tensions."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.models.moving_base import pose_at, rotate_to_base
from crane_sim.numerics.jit import LIGHT, NONE, entry_point, optimisation, seldom_called
from crane_sim.numerics.lanes import take_entry
from crane_sim.scenes.scene import Scene

Array = npt.NDArray[np.float64]

# s: rounding leaves 1e-8 of an acceleration, what the third power of time does less
DIFFERENCE_STEP = 1e-3


def tip_acceleration(p, t, q, v, u):
    """Return the magnitude of the tip's acceleration relative to the base [m/s²] at q, v, u.

    These are joint positions, joint velocities and efforts.

    Second difference of the tip's position, along a parabola of the joints with the model's
    accelerations: exact up to the square of its step.
    """
    points, tip = np.empty((3, system.point_count(p), 3)), system.tip_index(p)
    qdd, position = system.acceleration(p, t, system.state(p, t, q, v), u), np.empty(len(q))
    for k in range(3):
        s = (k - 1) * DIFFERENCE_STEP
        for j in range(len(position)):
            position[j] = q[j] + s * (v[j] + 0.5 * s * qdd[j])
        system.points(p, t, system.state(p, t, position, v), points[k])
    squared_norm = 0.0
    for j in range(3):
        second = (points[0, tip, j] - 2.0 * points[1, tip, j] + points[2, tip, j]) / (
            DIFFERENCE_STEP * DIFFERENCE_STEP
        )
        squared_norm += second * second
    return np.sqrt(squared_norm)


def to_base(base, t, point):
    """Return a point of the world (3,) [m] at time t [s] in the base frame."""
    pose, (x, y, z) = pose_at(base, t), point
    return rotate_to_base(pose.rows, (x - pose.origin[0], y - pose.origin[1], z - pose.origin[2]))


@entry_point
@optimisation(LIGHT)
def in_base(base, t, points):
    """Return points of the world (K, 3) [m] at times t (K,) [s] in the base frame."""
    out = np.empty_like(points)
    for i in range(len(points)):
        out[i] = to_base(base, t[i], (points[i, 0], points[i, 1], points[i, 2]))
    return out


@entry_point
def in_bases(bases, t, points):
    """Return points of the world (n, 3) [m] at times t (n,), each in the frame of its base.

    `bases` are columns.
    """
    out = np.empty_like(points)
    for i in range(len(points)):
        out[i] = to_base(take_entry(bases, i), t[i], (points[i, 0], points[i, 1], points[i, 2]))
    return out


def swing_angles(tips: Array, payloads: Array) -> Array:
    """Return the angles (K,) [rad] from the world's vertical of ropes, tips to payloads (K, 3)."""
    x, y, z = (payloads - tips).T
    return np.arctan2(np.hypot(x, y), -z)


class Derived(NamedTuple):
    """Quantities of K instants, world frame unless it says otherwise."""

    nodes: Array  # (K, N, 3) m, base .. tip .. payload
    tip: Array  # (K, 3) m
    payload: Array  # (K, 3) m
    kinetic: Array  # (K,) J
    potential: Array  # (K,) J, from height 0 of the world
    kinetic_relative: Array  # (K,) J, relative to the base
    potential_relative: Array  # (K,) J, as if the base were level at height 0
    tensions: Array  # (K, L) N, of the links from the top to the payload
    swing: Array  # (K,) rad, angle of the rope from the vertical
    falls: Array  # (K, n + 2), of a rope with n falls, see `fall_tensions`; (K, 0) without one

    @property
    def energy(self) -> Array:
        """Total energy (K,) [J]."""
        return self.kinetic + self.potential

    @property
    def energy_relative(self) -> Array:
        """Total energy relative to the base (K,) [J]: the same where the base rests."""
        return self.kinetic_relative + self.potential_relative

    @property
    def tension(self) -> Array:
        """Tension of the uppermost link (K,) [N]."""
        return self.tensions[:, 0]


@entry_point
@optimisation(NONE)
def fill_falls(p, t, q, v, u, out):
    """Fill `out` (K, n + 2) as `system.fall_tensions` does.

    The times are t (K,), the joints q, v (K, nq), the efforts u.
    """
    for i in range(len(q)):
        x = system.state(p, t[i], q[i], v[i])
        system.fall_tensions(p, t[i], x, system.efforts_from_row(p, u[i]), out, i)


def fall_tensions(model: Any, t: Array, q: Array, v: Array, u: Array) -> Array:
    """Return (K, n + 2) of a rope with n falls: lead line and falls [N], drum torque [N m].

    It is (K, 0) without such a rope.

    Args:
        model: the crane.
        t, q, v, u: times (K,), positions and velocities of the joints (K, nq), efforts applied (K,
            nu).
    """
    falls = system.fall_count(model)
    out = np.empty((len(t), falls + 2 if falls else 0))
    if falls:
        fill_falls(
            model, *(np.ascontiguousarray(part, dtype=np.float64) for part in (t, q, v, u)), out
        )
    return out


@entry_point
@optimisation(NONE)
def fill_derived(p, t, q, v, u, nodes, scalars, tensions):
    """Fill what follows from joint coordinates at times t (K,).

    Args:
        p: parameters.
        t, q, v, u: times, positions, velocities, efforts applied.
        nodes: (K, N, 3), to fill.
        scalars: (K, 4), to fill: kinetic and potential energy relative to the base, and what the
            base adds to each.
        tensions: (K, L), to fill.
    """
    for i in range(len(q)):
        x = system.state(p, t[i], q[i], v[i])
        system.points(p, t[i], x, nodes[i])
        scalars[i, 0] = system.kinetic(p, x)
        scalars[i, 1] = system.potential(p, x)
        scalars[i, 2], scalars[i, 3] = system.base_energy(p, t[i], x)
        system.tensions(p, t[i], x, system.efforts_from_row(p, u[i]), tensions, i, 0)


@entry_point
@seldom_called
def world_points(p, t, q, v):
    """Return (points from base to payload in the world [m] (N, 3), index of the tip).

    The instant is t [s], with joints q, v.
    """
    points = np.empty((system.point_count(p), 3))
    system.points(p, t, system.state(p, t, q, v), points)
    return points, system.tip_index(p)


@entry_point
@optimisation(LIGHT)
def fill_contact_forces(p, t, q, v, out):
    """Fill out (K,) with a surface's normal force [N] on the load at times t (K,), q, v (K, nq)."""
    for i in range(len(q)):
        out[i] = system.contact_force(p, t[i], system.state(p, t[i], q[i], v[i]))


def derive(scene: Scene, t: Array, q: Array, v: Array, u: Array) -> Derived:
    """Return what follows from q, v (K, nq) and the efforts applied u (K, nu) at times t (K,).

    q and v are joint positions and velocities.
    """
    points, tip_index = world_points(
        scene.model, 0.0, np.array(scene.initial_q), np.array(scene.initial_v)
    )
    nodes, scalars = np.empty((len(q), *points.shape)), np.empty((len(q), 4))
    tensions = np.empty((len(q), system.link_count(scene.model)))
    rows = (np.ascontiguousarray(part, dtype=np.float64) for part in (t, q, v, u))
    fill_derived(scene.model, *rows, nodes, scalars, tensions)
    swing = swing_angles(nodes[:, tip_index], nodes[:, -1])
    kinetic, potential, more_kinetic, more_potential = scalars.T
    world = kinetic + more_kinetic, potential + more_potential
    falls = fall_tensions(scene.model, t, q, v, u)
    return Derived(
        nodes, nodes[:, tip_index], nodes[:, -1], *world, kinetic, potential, tensions, swing, falls
    )


def derive_instant(scene: Scene, t: float, q: Sequence[float], v: Sequence[float]) -> Derived:
    """Return `derive` of one instant, K = 1, without efforts: q (nq,), v (nq,), t in s."""
    return derive(
        scene, np.array([t]), np.array([q]), np.array([v]), np.zeros((1, len(scene.actuated)))
    )
