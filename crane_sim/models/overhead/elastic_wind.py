"""Exact derivatives of the wind on the payload of an overhead crane with an elastic cable."""

from crane_sim.models.moving_base import airspeed, dot
from crane_sim.models.overhead.elastic import ZERO_VECTOR, elastic_layout, entry_of, mass_of, node_vector, unit_vector
from crane_sim.models.overhead.payload_wind import payload_force
from crane_sim.models.wind_load import airflow_at, drag_gradient, flow_gradient, relative_flow


def force_gradients(wind, p, base, t, x, b):
    """Return the derivatives (3,) of the force by coordinate b of the payload's position [N/m] and velocity [N s/m]."""
    n, axis = len(p.cable.masses), unit_vector(elastic_layout(p)[2], b)
    flow, r = airflow_at(wind, p.base, t, 0.0), node_vector(p, x, n, 0)
    v = relative_flow(flow, r, airspeed(base, r, node_vector(p, x, n, 1)))
    (ux, uy, uz), (wx, wy, wz) = flow_gradient(flow, r, axis), airspeed(base, axis, ZERO_VECTOR)
    (ox, oy, oz) = airspeed(base, ZERO_VECTOR, ZERO_VECTOR)
    by_place = drag_gradient(flow, p.windage, v, (ux - wx + ox, uy - wy + oy, uz - wz + oz))
    return by_place, drag_gradient(flow, p.windage, v, (-axis[0], -axis[1], -axis[2]))


def elastic_wind_jacobian(wind, p, base, t, x, bands):
    """Add the derivatives of an elastic cable's accelerations by the wind to `elastic_jacobian.Bands`."""
    if wind is None:
        return
    _, first, d, _ = elastic_layout(p)
    n = len(p.cable.masses)
    i, inverse = first + d * (n - 1), 1.0 / mass_of(p, x, n)
    for b in range(d):
        by_place, by_speed = force_gradients(wind, p, base, t, x, b)
        for a in range(d):
            bands.positions[i + a, 2 * d - 1 + b - a] += inverse * entry_of(d, a, by_place)
            bands.velocities[i + a, 2 * d - 1 + b - a] += inverse * entry_of(d, a, by_speed)


def elastic_wind_power_jacobian(wind, p, base, t, x, power):
    """Add the derivatives of the wind's power by positions and velocities of an elastic cable to `power` (2 nq,)."""
    if wind is None:
        return
    nq, first, d, _ = elastic_layout(p)
    n = len(p.cable.masses)
    i, v = first + d * (n - 1), node_vector(p, x, n, 1)
    force = payload_force(p, base, t, node_vector(p, x, n, 0), v)
    for b in range(d):
        by_place, by_speed = force_gradients(wind, p, base, t, x, b)
        power[i + b] += dot(by_place, v)
        power[nq + i + b] += dot(by_speed, v) + entry_of(d, b, force)
