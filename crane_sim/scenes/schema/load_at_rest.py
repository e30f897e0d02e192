"""Where a rigid load hangs at rest on elastic falls: a minimum of its potential.

A posture y is (x, y, z, roll, pitch, yaw), its attitude Rz(yaw) Ry(pitch) Rx(roll) of a load that
is either level at zero angles or, once it is steep, stands on end: roll and yaw of a steep one turn
it about nearly the same axis.

Newton's method goes to any stationary point, or nowhere where falls go slack. So first steps
descend: by the absolute curvatures of the potential, within a radius in which they predict its
change (Dauphin et al., NIPS 2014), on soft falls first, whose potential is no narrow valley, and
then on stiffer ones. Where the potential's last digits are reached, Newton's method goes on with
the forces.
"""

from math import cos, sin
from typing import Any, NamedTuple

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.models.falls.crane import Falls
from crane_sim.models.loads import RigidLoad

DESCENTS, TRIALS = 200, 50
"""Largest number of steps down one potential, and of Newton's method."""
CLOSE, DECIMALS = 1e-12, 10
"""Relative residual at rest, and the decimals [m, rad] of the result.

Rounded so that a run begins with the same bits on every machine: LAPACK's last digits differ by
processor.
"""
SOFT, STIFFER = 100.0, 10.0
"""Axial stiffness of the softest falls over the load's weight, and the step from one stiffness to
the next."""
FLATTEST, ROUNDING = 1e-6, 1e-14
"""Least curvature that counts: over the load's weight [1/m], and relative to the largest one."""
STATIONARY, UNSTABLE, ASIDE = 1e-6, 1e-3, 1e-3
"""Length [m] of a step at a stationary point, negative curvature [1/m] of a saddle over the load's
weight, and the step [m] away from it."""
STEEP = 1.0  # rad, of a pitch
LEVEL, ON_END = np.array([1.0, 0.0, 0.0, 0.0]), np.array([0.5**0.5, 0.0, 0.5**0.5, 0.0])
"""Attitudes of a load at zero angles."""


class _Hanging(NamedTuple):
    """A load whose posture is looked for."""

    falls: Falls  # with lower ends as at zero angles
    weight: float  # N
    free: int  # number of coordinates of the posture that are free: 5 where yaw is held
    zero: Any = LEVEL  # attitude at zero angles


class _Forces(NamedTuple):
    """Forces and moments on a load in a posture, by displacements and turns in support axes."""

    potential: float  # J
    loads: Any  # (6,) N and N m
    slope: Any  # (6, 6), derivative of the loads
    axes: Any  # (6, free), displacement and turn by each free coordinate


@np.errstate(all="ignore")  # the largest numbers overflow
def load_at_rest(
    falls: Falls, load: RigidLoad, gravity: float, yaw: float | None, near: Any = None
) -> Any:
    """Return the load's place (x, y, z) [m] and attitude (w, x, y, z) at rest.

    Both are in the axes of the tip, the place is that of the load's centre, from the tip.

    Args:
        falls, load: the parameters; the falls' length is their unstretched one.
        gravity: m/s².
        yaw: angle [rad] about the vertical at which the load is held; None: it hangs free.
        near: place and attitude (7,) from which the search begins; None: level, and as deep as the
            falls are long.

    Raises:
        SceneError: no position of rest was found.
    """
    hanging = _Hanging(falls, load.mass * gravity, 5 if yaw is not None else 6)
    y = np.full(6, np.nan)
    if near is not None:
        hanging, y = _search(
            hanging, np.array([*near[:3], *_angles(rotation_matrix(near[3:]))]), 1.0
        )
    if not np.isfinite(y).all():
        softness = max(1.0, float(falls.axial_stiffness.max()) / (SOFT * load.mass * gravity))
        hanging, y = _search(
            hanging._replace(falls=falls, zero=LEVEL), _level(falls, yaw or 0.0), softness
        )
    if not np.isfinite(y).all():
        raise SceneError(
            "falls: no position of rest was found; give initial.position and initial.orientation"
        )
    y = np.round(y, DECIMALS) + 0.0  # no negative zero
    turned = quaternion(y[3:])
    return y[:3], turned if hanging.zero is LEVEL else product(turned, hanging.zero)


def _search(hanging: _Hanging, y: Any, softness: float) -> tuple[_Hanging, Any]:
    """Return (the load, its posture at rest or NaN), searched from y on falls softened first."""
    stiffness = hanging.falls.axial_stiffness
    while softness > 1.0:
        hanging, y = _descend(_with_stiffness(hanging, stiffness / softness), y)
        softness /= STIFFER
    hanging, y = _descend(_with_stiffness(hanging, stiffness), y)
    return hanging, _solve(hanging, y)


def _level(falls: Falls, yaw: float) -> Any:
    """Return the posture of a level load below the upper ends, as deep as the falls are long."""
    depth = falls.length + float(
        np.mean(falls.offset) - np.mean(falls.top[:, 2]) + np.mean(falls.bottom[:, 2])
    )
    aside = (falls.top - falls.bottom).mean(axis=0)
    return np.array([aside[0], aside[1], -depth, 0.0, 0.0, yaw])


def _with_stiffness(hanging: _Hanging, stiffness: Any) -> _Hanging:
    return hanging._replace(falls=hanging.falls._replace(axial_stiffness=stiffness))


def _descend(hanging: _Hanging, y: Any) -> tuple[_Hanging, Any]:
    """Return (the load, its posture) after steps down until the potential is at rounding."""
    radius, lever = 0.5, np.sqrt(np.mean(np.sum(hanging.falls.bottom**2, axis=1))) or 1.0
    # m: angles as displacements at the ends
    scale = np.array([1.0, 1.0, 1.0, lever, lever, lever])[: hanging.free]
    for _ in range(DESCENTS):
        if hanging.free == 6 and abs(y[4]) > STEEP:
            hanging, y = _stand_on_end(hanging, y)
        forces = _forces(hanging, y)
        gradient, curvature = (
            -(forces.loads @ forces.axes) / scale,
            _curvature(forces) / np.outer(scale, scale),
        )
        if not np.isfinite(curvature).all():
            break
        move = _step(gradient, curvature, hanging.weight, radius)
        expected, ahead = -float(gradient @ move + 0.5 * move @ curvature @ move), y.copy()
        if not expected > CLOSE * hanging.weight * max(1.0, abs(y[2])):
            break
        ahead[: hanging.free] += move / scale
        part = (forces.potential - _forces(hanging, ahead).potential) / expected
        y = ahead if part > 0.0 else y
        radius *= 2.0 if part > 0.75 else 1.0 if part > 0.25 else 0.25
    return hanging, y


def _step(gradient: Any, curvature: Any, weight: float, radius: float) -> Any:
    """Return the step down by the absolute curvatures within the radius, also from a saddle."""
    values, axes = np.linalg.eigh(curvature)
    axes *= np.where(axes.sum(axis=0) < 0.0, -1.0, 1.0)  # LAPACK's signs differ by processor
    # N/m: a load on slack falls has none
    least = max(FLATTEST * weight, ROUNDING * float(np.abs(values).max()))
    along = -(axes.T @ gradient) / np.maximum(np.abs(values), least)
    if np.linalg.norm(along) < STATIONARY:
        along = np.where(values < -UNSTABLE * weight, ASIDE, along)
    move = axes @ along
    return move * min(1.0, radius / max(radius, float(np.linalg.norm(move))))


def _solve(hanging: _Hanging, y: Any) -> Any:
    """Return the posture of zero force and moment on what is free, by Newton's method near y.

    It is NaN where the method finds none.
    """
    free, stiffness = hanging.free, float(hanging.falls.axial_stiffness.max())
    most = CLOSE * hanging.weight * max(1.0, abs(y[2])) + 1e-14 * stiffness
    for _ in range(TRIALS):
        forces, y = _forces(hanging, y), y.copy()
        slope, residual = (forces.slope @ forces.axes)[:free], forces.loads[:free]
        if not (np.isfinite(slope).all() and np.isfinite(residual).all()):
            break
        if np.abs(residual).max() <= most:
            return y
        y[:free] += np.clip(np.linalg.lstsq(slope, -residual, rcond=1e-12)[0], -0.5, 0.5)
    return np.full(6, np.nan)


def _curvature(forces: _Forces) -> Any:
    """Return the potential's second derivatives (free, free), without turns under moments."""
    curvature = -forces.axes.T @ forces.slope @ forces.axes
    return 0.5 * (curvature + curvature.T)


def _forces(hanging: _Hanging, y: Any) -> _Forces:
    """Return what acts on the load in a posture."""
    falls, weight = hanging.falls, hanging.weight
    arms = falls.bottom @ rotation_matrix(quaternion(y[3:])).T
    apart, rest = falls.top - (y[:3] + arms), falls.length + falls.offset
    distance = np.maximum(np.linalg.norm(apart, axis=1), CLOSE)
    stretch, stiffness, up = (
        distance - rest,
        falls.axial_stiffness / rest,
        apart / distance[:, None],
    )
    tension = np.maximum(stiffness * stretch, 0.0)
    pulls = tension[:, None] * up
    loads = np.concatenate(
        [pulls.sum(0) - np.array([0.0, 0.0, weight]), np.cross(arms, pulls).sum(0)]
    )
    along = (
        np.hstack([up, np.cross(arms, up)])
        * np.sqrt(np.where(stretch > 0.0, stiffness - tension / distance, 0.0))[:, None]
    )
    ends = np.zeros((len(arms), 3, 6))  # displacements of the lower ends
    ends[:, :, :3], ends[:, :, 3:] = np.eye(3), -_cross_matrices(arms)
    slope = -along.T @ along - np.einsum("n,nij,nik->jk", tension / distance, ends, ends)
    slope[3:, 3:] += arms.T @ pulls - np.sum(arms * pulls) * np.eye(3)
    energy = weight * y[2] + 0.5 * np.sum(tension * np.maximum(stretch, 0.0))
    return _Forces(float(energy), loads, slope, _axes(y)[:, : hanging.free])


def _axes(y: Any) -> Any:
    """Return displacement and turn (6, 6) by each coordinate of a posture."""
    (sp, sy), (cp, cy), axes = np.sin(y[4:]), np.cos(y[4:]), np.eye(6)
    axes[3:, 3:] = [[cy * cp, -sy, 0.0], [sy * cp, cy, 0.0], [-sp, 0.0, 1.0]]
    return axes


def _cross_matrices(vectors: Any) -> Any:
    """Return the matrices (n, 3, 3) of cross products with vectors (n, 3)."""
    out = np.zeros((len(vectors), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        out[:, k, j], out[:, j, k] = vectors[:, i], -vectors[:, i]
    return out


def _stand_on_end(hanging: _Hanging, y: Any) -> tuple[_Hanging, Any]:
    """Return the load and its posture by angles from the other one of two zero attitudes."""
    zero = ON_END if hanging.zero is LEVEL else LEVEL
    turn = rotation_matrix(ON_END) if zero is ON_END else rotation_matrix(ON_END).T
    angles = _angles(rotation_matrix(quaternion(y[3:])) @ turn.T)
    falls = hanging.falls._replace(bottom=hanging.falls.bottom @ turn.T)
    return hanging._replace(falls=falls, zero=zero), np.array([*y[:3], *angles])


def _angles(rotation: Any) -> tuple[float, float, float]:
    """Return (roll, pitch, yaw) [rad] of a rotation matrix."""
    (a, _, _), (b, _, _), (c, d, e) = rotation
    return float(np.arctan2(d, e)), float(np.arctan2(-c, np.hypot(a, b))), float(np.arctan2(b, a))


def quaternion(angles: Any) -> Any:
    """Return the unit quaternion (w, x, y, z) of Rz(yaw) Ry(pitch) Rx(roll)."""
    half = [0.5 * float(angle) for angle in angles]
    (sr, sp, sy), (cr, cp, cy) = map(sin, half), map(cos, half)
    vector = (cy * cp * sr - sy * sp * cr, cy * sp * cr + sy * cp * sr, sy * cp * cr - cy * sp * sr)
    return np.array([cy * cp * cr + sy * sp * sr, *vector])


def product(p: Any, q: Any) -> Any:
    """Return the product of two quaternions."""
    p, q = np.asarray(p), np.asarray(q)
    vector = p[0] * q[1:] + q[0] * p[1:] + np.cross(p[1:], q[1:])
    return np.array([p[0] * q[0] - p[1:] @ q[1:], *vector])


def rotation_matrix(q: Any) -> Any:
    """Return the rotation matrix (3, 3) of a unit quaternion."""
    w, x, y, z = q
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + 2.0 * w * cross + 2.0 * cross @ cross
