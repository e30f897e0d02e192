"""Wind on the payload of an overhead crane, the last node of its cable.

A crane in the plane takes the part of the force in its plane; what holds it there carries the rest.
"""

from crane_sim.models.cables.chain import COS, INV_MASS, LENGTH, RATE, SIN, add_node_acceleration
from crane_sim.models.moving_base import airspeed
from crane_sim.models.overhead.base_load import NO_LOAD
from crane_sim.models.wind_load import add_wind, airflow_at
from crane_sim.numerics.jit import generic
from crane_sim.trajectories.wind import Wind


def payload_force(wind, p, base, t, r, v):
    """Return the force (3,) [N] of the wind at time t on the payload of crane p.

    Args:
        wind, p: the crane's wind, the crane.
        base: see `moving_base.base_kinematics_at`.
        t: s.
        r, v: position [m] of the payload and its velocity [m/s] relative to the base (3,).
    """
    return add_wind(airflow_at(wind, p.base, t, 0.0), p.windage, (0.0, 0.0, 0.0), r, airspeed(base, r, v))


@generic
def add_links_wind(wind, p, base, t, w, top):
    """Add the payload's acceleration by the wind to the work array w of a chain in the plane; return its power [W].

    Args:
        wind, p, base, t: see `payload_force`; no wind is None.
        w: work array of `chain`.
        top: position [m] and velocity [m/s] of the trolley, rate of the first link's length [m/s].
    """
    return NO_LOAD


@add_links_wind.register(Wind)
def _(wind, p, base, t, w, top):
    n, (x, vx, paid), z, vz = w.shape[1] - 1, top, 0.0, 0.0
    for k in range(n):
        s, c, swing = w[SIN, k], w[COS, k], w[LENGTH, k] * w[RATE, k]
        x, z = x + w[LENGTH, k] * s, z - w[LENGTH, k] * c
        vx, vz = vx + paid * s + swing * c, vz + swing * s - paid * c
        paid = 0.0
    fx, _, fz = payload_force(wind, p, base, t, (x, 0.0, z), (vx, 0.0, vz))
    inverse = w[INV_MASS, n - 1]
    add_node_acceleration(w, n, fx * inverse, fz * inverse)
    return fx * vx + fz * vz


@generic
def add_nodes_wind(wind, p, base, t, links, top, acc):
    """Add the payload's acceleration by the wind to acc (N + 1, 3) [m/s²] of a chain in space; return its power [W].

    Args:
        wind, p, base, t: see `payload_force`; no wind is None.
        links: `directions.Directions`.
        top: position (2,) [m] and velocity (2,) [m/s] of the trolley, rate of the first link's length [m/s].
        acc: of the nodes.
    """
    return NO_LOAD


@add_nodes_wind.register(Wind)
def _(wind, p, base, t, links, top, acc):
    ((x, y), (vx, vy), paid), z, vz, n = top, 0.0, 0.0, len(links.squared_rates)
    for k in range(n):
        length = links.lengths[k]
        x, y, z = x + length * links.units[k, 0], y + length * links.units[k, 1], z + length * links.units[k, 2]
        vx += length * links.rates[k, 0] + paid * links.units[k, 0]
        vy += length * links.rates[k, 1] + paid * links.units[k, 1]
        vz += length * links.rates[k, 2] + paid * links.units[k, 2]
        paid = 0.0
    fx, fy, fz = payload_force(wind, p, base, t, (x, y, z), (vx, vy, vz))
    inverse = links.inv_masses[n - 1]
    acc[n, 0] += fx * inverse
    acc[n, 1] += fy * inverse
    acc[n, 2] += fz * inverse
    return fx * vx + fy * vy + fz * vz


@generic
def add_elastic_wind(wind, p, base, t, x, out):
    """Add the payload's acceleration to the derivative `out` of an elastic cable's state; return the wind's power [W].

    wind, p, base, t: see `payload_force`; no wind is None.
    """
    return NO_LOAD
