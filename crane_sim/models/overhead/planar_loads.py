"""Loads on a chain in the plane: inertial forces of a moving base, and those on the payload.

States are relative to the base, which is that of `moving_base.base_kinematics_at`, None at rest. A
crane in the plane takes the part of these forces in its plane; what holds it there carries the
rest.
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
    add_node_acceleration,
)
from crane_sim.models.loads import PointLoad, PointState
from crane_sim.models.moving_base import imposed_acceleration
from crane_sim.models.overhead import first_link, layout_of
from crane_sim.models.supports.rails import axis_mass
from crane_sim.models.suspended.crane import load_force
from crane_sim.models.wind_load import airflow_at
from crane_sim.multibody.vectors import ZERO

NO_LOAD = -0.0
"""Contribution of a base at rest: adding -0.0 does not even change the sign of a zero."""


class Load(NamedTuple):
    """Inertial force of the base on the trolley, and its power."""

    x: float  # N, along its rail
    power: float  # W


REST = Load(NO_LOAD, NO_LOAD)


def trolley_motion(p, x):
    """Return position [m] and velocity [m/s] (3,) of the trolley relative to the base."""
    nq, _, _ = layout_of(p)
    return (x[0], 0.0, 0.0), (x[nq], 0.0, 0.0)


def imposed_gradient(base, r, v):
    """Return the change (3,) [m/s²] of the imposed acceleration.

    It is that for a change of position by r [m] and of velocity by v [m/s].
    """
    return imposed_acceleration(base._replace(imposed=ZERO), r, v)


def add_links_load(base, p, x, w):
    """Add the accelerations imposed on the nodes of a planar chain to the work array w.

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
        ex, _, ez = imposed_gradient(
            base, (w[LENGTH, k] * s, 0.0, -w[LENGTH, k] * c), (dx, 0.0, dz)
        )
        vx, vz, ax, az = vx + dx, vz + dz, ax + ex, az + ez
        power += (ax * vx + az * vz) / w[INV_MASS, k]
        if k == 0:  # its upper end is on the trolley, whose share is the force along the rail
            ex, ez = ax, az
        w[RHS_ALONG, k] += s * ex - c * ez
        w[RHS_ACROSS, k] += c * ex + s * ez
        paid = 0.0
    return Load(load + couples.x, power)


def add_rods_load(rods, base, w):
    """Add the effect of the base's rotation on links with inertia; return their Load."""
    if rods is None:
        return REST
    power, pull = 0.0, 0.0
    for k in range(len(rods.inertia)):
        # angles of links grow against turns about y
        couple = rods.inertia[k] * base.angular_acceleration[1]
        force = couple / w[LENGTH, k]
        power += couple * w[RATE, k]
        if k == 0:
            pull = -force * w[COS, 0]
        add_couple(w, k, force)
    return Load(pull, power)


def add_payload_force(p, base, t, x, w):
    """Add the payload's acceleration by air, wind and a given force to w; return their power.

    w is the work array of a chain.
    """
    if p.wind is None and p.drag is None and p.force is None:
        return NO_LOAD
    n, ((rx, _, rz), (vx, _, vz)), paid = w.shape[1] - 1, trolley_motion(p, x), first_link(p, x)[1]
    for k in range(n):
        s, c, swing = w[SIN, k], w[COS, k], w[LENGTH, k] * w[RATE, k]
        rx, rz = rx + w[LENGTH, k] * s, rz - w[LENGTH, k] * c
        vx, vz = vx + paid * s + swing * c, vz + swing * s - paid * c
        paid = 0.0
    inverse, load = w[INV_MASS, n - 1], PointState((rx, 0.0, rz), (vx, 0.0, vz))
    flow = airflow_at(p.wind, p.base, t, 0.0)
    (fx, _, fz), _ = load_force(p, PointLoad(1.0 / inverse, p.windage), t, flow, base, load)
    add_node_acceleration(w, n, fx * inverse, fz * inverse)
    return fx * vx + fz * vz
