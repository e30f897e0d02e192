"""Totals of a run up to an instant: one compiled accumulator for runs, batches, studies, plants.

`add_rows` takes instants, however many at once; `finish` takes the end of a run. A run's metrics
are functions of the totals (`metrics`).
"""

from math import asin, atan2, hypot
from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.numerics.jit import LIGHT, NONE, entry_point, optimisation, routine, seldom_called
from crane_sim.scenes.scene import Scene
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.simulation.derived import tip_acceleration, to_base
from crane_sim.simulation.energy_balance import (
    Balance,
    add_energies,
    add_work,
    empty_balance,
    relative_errors,
)
from crane_sim.simulation.settling import is_outside, nearness
from crane_sim.trajectories.trajectory import Trajectory, derivatives_at

LAST = 0.25
"""The residual swing is the largest one in this last part of the run."""
PUSHED = -1e-6
"""N, the tension below which a link pushes: above it is the rounding of nothing."""
LARGEST_ERROR, TIP_ACCELERATION = 2, 3
"""Entries of `Totals.tracking`, after the sums of squares and of sizes."""


class Watched(NamedTuple):
    """What a run's metrics depend on besides its rows; of many runs, each number is a column."""

    late: Any  # s, when the last part of the run begins
    metered: Any  # whether the model's meter tells what is supplied, and not the work of held
    # efforts
    driven: Any  # (nu,), indices of the actuated joints
    target: Any  # (nu,), of the actuated joints
    near: Any  # (nu,), which distance from it counts as near
    limits: tuple[tuple[Any, Any], ...]  # lowest and highest positions of the joints with travel
    # limits
    attitude: Any  # index of the first entry of a load's quaternion among the joints; None without
    # one
    joint_path: Trajectory | None  # of the actuated joints
    payload_path: Trajectory | None  # in the axes of the base


class Totals(NamedTuple):
    """Largest and least values and sums of one run; of many runs, each array is a column."""

    balance: Balance
    swing: Any  # (2, 4) m, from tip to payload at the largest swing of the run, and of its last
    # part; distance across
    effort: Any  # (nu,), largest magnitudes
    tension: Any  # (2,) N, the least and the greatest of all links
    ranges: Any  # (2, nq), least and greatest joint positions
    outside: Any  # (nu,) s, when joints were last not near their targets
    pushed: Any  # (1,), instants at which a link pushed
    tilt: Any  # (4,) rad, largest magnitudes of `Tilt`; None without a body
    contact: Any  # (1,) N, largest normal force; None without contact
    falls: Any  # (2, n + 2), of `system.fall_tensions` the largest magnitudes, and those of an
    # instant; None without
    tracking: Any  # (4,), errors from the path: sums of squares and of sizes, the largest; m/s², of
    # the tip; or None


class Tilt(NamedTuple):
    """Angles of a load [rad], in the axes of the base."""

    tilt: float  # of its z axis from the base's
    skew: float  # about z
    trim: float  # about y, after the skew
    list: float  # about x, after both


def watched_of(scene: Scene, metered: bool) -> Watched:
    """Return what is watched of a scene's run; `metered`: the integrated model has a meter."""
    names, path = scene.joint_names, scene.trajectory
    driven = np.array([names.index(name) for name in scene.actuated], np.int64)
    target, near = np.zeros(len(driven)), np.full(len(driven), np.inf)
    if scene.reference is not None:
        target = np.array(scene.reference)
        near = nearness(target, np.array(scene.initial_q)[driven])
    attitude = names.index(ATTITUDE[0]) if ATTITUDE[0] in names else None
    paths = (path, None) if path is not None and path.of_joints else (None, path)
    limits = tuple((float(limit.low), float(limit.high)) for limit in scene.limits)
    return Watched(
        (1.0 - LAST) * scene.duration, metered, driven, target, near, limits, attitude, *paths
    )


def empty_totals(scene: Scene, *runs: int) -> Totals:
    """Return the totals before the first instant of one or many runs; the start's energy is 0."""
    nq, nu, falls = len(scene.joint_names), len(scene.actuated), system.fall_count(scene.model)
    swing, tension, ranges = (
        np.zeros((*runs, 2, 4)),
        np.full((*runs, 2), np.inf),
        np.full((*runs, 2, nq), np.inf),
    )
    swing[..., 2], tension[..., 1], ranges[..., 1, :] = -1.0, -np.inf, -np.inf
    return Totals(
        empty_balance(nu, *runs),
        swing,
        np.zeros((*runs, nu)),
        tension,
        ranges,
        np.full((*runs, nu), -np.inf),
        np.zeros((*runs, 1), np.int64),
        np.zeros((*runs, 4)) if ATTITUDE[0] in scene.joint_names else None,
        np.zeros((*runs, 1)) if getattr(scene.model, "contact", None) is not None else None,
        np.zeros((*runs, 2, falls + 2)) if falls else None,
        np.zeros((*runs, 4)) if scene.trajectory is not None else None,
    )


@entry_point
@optimisation(LIGHT)
def add_rows(p, watched, totals, t, rows):
    """Take K instants, one a period, into the totals: rows (K, width) at times t (K,) [s].

    For the rows see `stepping.rows`.
    """
    add_instants(p, watched, totals, t, rows, len(rows))


@routine
def add_instants(p, watched, totals, t, rows, count):
    """Take the first `count` rows into the totals; arguments of `add_rows`."""
    nq, nu, points = (
        totals.ranges.shape[1],
        len(totals.effort),
        np.empty((system.point_count(p), 3)),
    )
    for i in range(count):
        q, v = rows[i, :nq], rows[i, nq : 2 * nq]
        x, u = (
            system.state(p, t[i], q, v),
            system.efforts_from_row(p, rows[i, 2 * nq : 2 * nq + nu]),
        )
        add_position(p, watched, totals, t[i], q, x, points, t[i] >= watched.late)
        add_work(totals.balance, watched, q, u, rows[i, 2 * nq + nu])
        add_energies(totals.balance, system.kinetic(p, x), system.potential(p, x))
        add_tensions(totals, rows[i, 2 * nq + nu + 1 :])
        for j in range(len(u)):
            totals.effort[j] = max(totals.effort[j], abs(u[j]))
            if is_outside(watched.target[j], watched.near[j], q[watched.driven[j]]):
                totals.outside[j] = t[i]
        add_forces(p, totals, t[i], x, u)
        if totals.tracking is not None:
            acceleration = tip_acceleration(p, t[i], q, v, u)
            totals.tracking[TIP_ACCELERATION] = max(totals.tracking[TIP_ACCELERATION], acceleration)


def add_position(p, watched, totals, t, q, x, points, is_late):
    """Take what counts at the end of a run, too: positions at time t [s] and state x.

    `points` is overwritten.
    """
    for j in range(len(system.joints(p, x)[0])):  # a tuple of joints is no loop
        totals.ranges[0, j], totals.ranges[1, j] = (
            min(totals.ranges[0, j], q[j]),
            max(totals.ranges[1, j], q[j]),
        )
    system.points(p, t, x, points)
    tip, end = system.tip_index(p), len(points) - 1
    rope = (
        points[end, 0] - points[tip, 0],
        points[end, 1] - points[tip, 1],
        points[end, 2] - points[tip, 2],
    )
    distance = np.sqrt(rope[0] * rope[0] + rope[1] * rope[1])
    for part in range(2 if is_late else 1):
        if swings_further(distance, rope[2], totals.swing[part]):
            totals.swing[part, :3], totals.swing[part, 3] = rope, distance
    if totals.tilt is not None:
        i = watched.attitude
        for k, angle in enumerate(tilt_of((q[i], q[i + 1], q[i + 2], q[i + 3]))):
            totals.tilt[k] = max(totals.tilt[k], abs(angle))
    if totals.tracking is not None:
        payload = points[end, 0], points[end, 1], points[end, 2]
        add_error(totals.tracking, tracking_error(p, watched, t, q, payload))


def swings_further(distance, height, largest):
    """Return whether a rope is further from the vertical than `largest`.

    The height and the distance are those from tip to payload; the sign of a sine decides.
    """
    return largest[3] * height - distance * largest[2] > 0.0


def tilt_of(quaternion):
    """Return the angles of a unit quaternion (4,), w first; R = Rz(skew) Ry(trim) Rx(list)."""
    w, x, y, z = quaternion
    return Tilt(
        2.0 * atan2(hypot(x, y), hypot(w, z)),
        atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
        asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0)),
        atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
    )


def tracking_error(p, watched, t, q, payload):
    """Return the distance from the path, in its coordinates, of joints q or the payload.

    The payload (3,) is in m, the time t in s.
    """
    if watched.joint_path is not None:
        (goal,) = derivatives_at(watched.joint_path, t, (0,))
        point = tuple([q[watched.driven[k]] for k in range(len(goal))])
    else:
        (goal,) = derivatives_at(watched.payload_path, t, (0,))
        base = getattr(p, "base", None)
        point = payload if base is None else to_base(base, t, payload)
    squares = 0.0
    for own, wanted in zip(point, goal, strict=False):
        squares += (own - wanted) * (own - wanted)
    return np.sqrt(squares)


def add_error(tracking, size):
    """Take one error into the sums."""
    tracking[0] += size * size
    tracking[1] += size
    tracking[LARGEST_ERROR] = max(tracking[LARGEST_ERROR], size)


def add_tensions(totals, tensions):
    """Take the tensions (L,) [N] of the links at an instant into the totals."""
    least, greatest = np.inf, -np.inf
    for j in range(len(tensions)):
        least, greatest = min(least, tensions[j]), max(greatest, tensions[j])
    totals.tension[0], totals.tension[1] = (
        min(totals.tension[0], least),
        max(totals.tension[1], greatest),
    )
    totals.pushed[0] += least < PUSHED


def add_forces(p, totals, t, x, u):
    """Take the forces that only some cranes have into the totals.

    The state is x, the efforts are u (nu,).
    """
    if totals.contact is not None:
        totals.contact[0] = max(totals.contact[0], system.contact_force(p, t, x))
    if totals.falls is not None:
        system.fall_tensions(p, t, x, u, totals.falls, 1)
        for j in range(totals.falls.shape[1]):
            totals.falls[0, j] = max(totals.falls[0, j], abs(totals.falls[1, j]))


@entry_point
@optimisation(NONE)
def finish(p, watched, totals, t, q, v, meters):
    """Take the end of a run, joints q, v at t [s], into the totals.

    `meters` are those of `read_final_meters`.
    """
    finish_run(p, watched, totals, t, q, v, meters)


def finish_run(p, watched, totals, t, q, v, meters):
    """Do what `finish` does: the end is part of the last part of a run, wherever it is."""
    points, x = np.empty((system.point_count(p), 3)), system.state(p, t, q, v)
    add_position(p, watched, totals, t, q, x, points, True)
    relative_errors(totals.balance, watched, q, *meters)


@entry_point
@seldom_called
def read_meters(p, x):
    """Return (energy relative to the base [J], energy supplied [J] as metered, or 0)."""
    return system.kinetic(p, x) + system.potential(p, x), system.energy_supplied(p, x)


@entry_point
@seldom_called
def read_final_meters(p, x, t, q, v):
    """Return `read_meters` of a run that ends in state x, with joints q, v at the end t [s].

    That is the last instant that counts.

    One that failed within a period has a state beyond these joints. Without a meter the work is
    that up to them, so the energy must be, too.
    """
    return read_meters(p, system.state(p, t, q, v) if p.energy_meter is None else x)
