"""Wind on the payload of an overhead crane, the last node of its cable.

A crane in the plane takes the part of the force in its plane; what holds it there carries the rest.
"""

from crane_sim.models.cables.chain import COS, INV_MASS, LENGTH, RATE, SIN, add_node_acceleration
from crane_sim.models.moving_base import airspeed
from crane_sim.models.overhead import first_link, trolley_motion
from crane_sim.models.overhead.base_load import NO_LOAD
from crane_sim.models.wind_load import add_wind, airflow_at
from crane_sim.multibody.vectors import ZERO


def payload_force(p, base, t, r, v):
    """Return the force (3,) [N] of the wind at time t on the payload of crane p.

    Args:
        p: the crane.
        base: see `moving_base.base_kinematics_at`.
        t: s.
        r, v: position [m] of the payload and its velocity [m/s] relative to the base (3,).
    """
    return add_wind(airflow_at(p.wind, p.base, t, 0.0), p.windage, ZERO, r, airspeed(base, r, v))


def add_links_wind(p, base, t, x, w):
    """Add the payload's acceleration by the wind to the work array w of a chain in the plane; return its power [W]."""
    if p.wind is None:
        return NO_LOAD
    n, ((rx, _, rz), (vx, _, vz)), paid = w.shape[1] - 1, trolley_motion(p, x), first_link(p, x)[1]
    for k in range(n):
        s, c, swing = w[SIN, k], w[COS, k], w[LENGTH, k] * w[RATE, k]
        rx, rz = rx + w[LENGTH, k] * s, rz - w[LENGTH, k] * c
        vx, vz = vx + paid * s + swing * c, vz + swing * s - paid * c
        paid = 0.0
    fx, _, fz = payload_force(p, base, t, (rx, 0.0, rz), (vx, 0.0, vz))
    inverse = w[INV_MASS, n - 1]
    add_node_acceleration(w, n, fx * inverse, fz * inverse)
    return fx * vx + fz * vz
