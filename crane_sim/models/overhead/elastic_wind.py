"""Wind on the payload of an overhead crane with an elastic cable."""

from crane_sim.models.moving_base import dot
from crane_sim.models.overhead.elastic import elastic_layout, mass_of, node_vector
from crane_sim.models.overhead.payload_wind import add_elastic_wind, payload_force
from crane_sim.trajectories.wind import Wind


@add_elastic_wind.register(Wind)
def _(wind, p, base, t, x, out):
    nq, first, d, _ = elastic_layout(p)
    n = len(p.cable.masses)
    i, v, inverse = nq + first + d * (n - 1), node_vector(p, x, n, 1), 1.0 / mass_of(p, x, n)
    force = payload_force(wind, p, base, t, node_vector(p, x, n, 0), v)
    out[i] += force[0] * inverse
    if d == 3:
        out[i + 1] += force[1] * inverse
    out[i + d - 1] += force[2] * inverse
    return dot(force, v)
