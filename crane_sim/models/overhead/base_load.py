"""An overhead crane on a moving base: inertial forces on axes and nodes, whose states are relative to the base.

Each function takes the base as of `moving_base.base_kinematics_at`, and does nothing for a base at rest (None).
"""

from typing import NamedTuple

from crane_sim.models.cables.chain import (
    COS,
    INV_MASS,
    LENGTH,
    RATE,
    RHS_ACROSS,
    RHS_ALONG,
    SIN,
    add_couple,
)
from crane_sim.models.cables.chain_3d import row_of
from crane_sim.models.moving_base import imposed_acceleration, pose_at, to_world
from crane_sim.models.overhead import first_link, trolley_motion
from crane_sim.models.supports.rails import axis_mass
from crane_sim.multibody.vectors import ZERO

NO_LOAD = -0.0
"""Contribution of a base at rest: adding -0.0 does not even change the sign of a zero."""


class Load(NamedTuple):
    """Inertial forces of the base on the axes, and their power."""

    x: float  # N, on the trolley along its rail
    y: float  # N, on the bridge
    power: float  # W


REST = Load(NO_LOAD, NO_LOAD, NO_LOAD)


def axes_load(base, p, x):
    """Return the Load of trolley and bridge alone; an axis with prescribed motion has none."""
    if base is None:
        return REST
    (rx, ry, _), (vx, vy, _) = motion = trolley_motion(p, x)
    along = axis_mass(p.trolley) * imposed_acceleration(base, *motion)[0]
    across = axis_mass(p.bridge) * imposed_acceleration(base, (p.share * rx, ry, 0.0), (p.share * vx, vy, 0.0))[1]
    return Load(along, across, along * vx + across * vy)


def imposed_gradient(base, r, v):
    """Return the change (3,) [m/s²] of the imposed acceleration for a change of position by r [m], of velocity by v."""
    return imposed_acceleration(base._replace(imposed=ZERO), r, v)


def add_links_load(base, p, x, w):
    """Add the accelerations imposed on the nodes of a chain in the plane to the work array w of `chain`.

    Returns:
        The Load of trolley and links; its force along the rail is still to be added.
    """
    if base is None:
        return REST
    _, (vx, _, vz) = motion = trolley_motion(p, x)
    ax, _, az = imposed_acceleration(base, *motion)
    load, couples = axis_mass(p.trolley) * ax, add_rods_load(p.rods, base, w)
    power, paid = load * vx + couples.power, first_link(p, x)[1]
    for k in range(w.shape[1] - 1):
        s, c, swing = w[SIN, k], w[COS, k], w[LENGTH, k] * w[RATE, k]
        dx, dz = paid * s + swing * c, swing * s - paid * c
        ex, _, ez = imposed_gradient(base, (w[LENGTH, k] * s, 0.0, -w[LENGTH, k] * c), (dx, 0.0, dz))
        vx, vz, ax, az = vx + dx, vz + dz, ax + ex, az + ez
        power += (ax * vx + az * vz) / w[INV_MASS, k]
        if k == 0:  # its upper end is on the trolley, whose share is the force along the rail
            ex, ez = ax, az
        w[RHS_ALONG, k] += s * ex - c * ez
        w[RHS_ACROSS, k] += c * ex + s * ez
        paid = 0.0
    return Load(load + couples.x, NO_LOAD, power)


def add_rods_load(rods, base, w):
    """Add the effect of the base's rotation on links with a moment of inertia; return their Load."""
    if rods is None:
        return REST
    power, pull = 0.0, 0.0
    for k in range(len(rods.inertia)):
        couple = rods.inertia[k] * base.angular_acceleration[1]  # angles of links grow against turns about y
        force = couple / w[LENGTH, k]
        power += couple * w[RATE, k]
        if k == 0:
            pull = -force * w[COS, 0]
        add_couple(w, k, force)
    return Load(pull, NO_LOAD, power)


def to_world_in_place(base, t, out):
    """Transform points (N, 3) [m] in `out` from the base to the world at time t [s]."""
    if base is not None:
        pose = pose_at(base, t)
        for k in range(len(out)):
            out[k, 0], out[k, 1], out[k, 2] = to_world(pose, row_of(out, k))
