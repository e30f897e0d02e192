"""An overhead crane with two rigid links of fixed length in the vertical plane, in closed form.

The two tensions solve a symmetric 2 x 2 system (`chain` has the equations for any number of links).
State: a flat tuple (x, α_1, α_2, x', α_1', α_2', (energy supplied)).
"""

from math import cos, sin
from typing import NamedTuple

from crane_sim import system
from crane_sim.models.energy_meter import Meter, meter_entry
from crane_sim.models.supports.rails import Axis, axis_mass
from crane_sim.numerics.arrays import store
from crane_sim.numerics.elementary import sincos


class TwoLinks(NamedTuple):
    """Masses [kg] and lengths [m] of the upper and lower link; the second mass is the payload."""

    mass1: float
    mass2: float
    length1: float
    length2: float

    def with_payload(self, mass):
        """Return the cable with another payload [kg]."""
        return self._replace(mass2=mass)


class DoubleCrane(NamedTuple):
    """Parameters of a whole crane; None: not modelled."""

    trolley: Axis
    cable: TwoLinks
    gravity: float = 9.81  # m/s²
    energy_meter: Meter | None = None

    hoist = event_limits = None

    def cable_coordinates(self):
        """Return the number of angles."""
        return 2


def double_dynamics(p, t, x, tau):
    """Return (accelerations of trolley and both angles, tensions of upper, lower link, sin α_1)."""
    (s1, c1), (s2, c2) = sincos(x[1]), sincos(x[2])
    cable, g = p.cable, p.gravity
    inv_mass, bias_acc = p.trolley.response(t, tau, 0, x[3], 0.0)
    i1, i2 = 1.0 / cable.mass1, 1.0 / cable.mass2
    cos_bend, sin_bend = s1 * s2 + c1 * c2, c1 * s2 - s1 * c2  # cosine and sine of α_2 - α_1
    a, b, c = i1 + s1 * s1 * inv_mass, -cos_bend * i1, i1 + i2
    upper = cable.length1 * x[4] * x[4] + g * c1 - s1 * bias_acc
    lower = cable.length2 * x[5] * x[5]
    inverse = 1.0 / (a * c - b * b)
    tension1, tension2 = (c * upper - b * lower) * inverse, (a * lower - b * upper) * inverse
    trolley = bias_acc + inv_mass * tension1 * s1
    turning1 = (sin_bend * tension2 * i1 - g * s1 - c1 * trolley) / cable.length1
    turning2 = -sin_bend * tension1 * i1 / cable.length2
    return (trolley, turning1, turning2), (tension1, tension2), s1


@system.rhs.register(DoubleCrane)
def state_derivative(p, t, x, u):
    """Return the derivative of the state."""
    tau = system.effort(u, p, t, x)
    acceleration, tension, s1 = double_dynamics(p, t, x, tau)
    power = meter_entry(p.energy_meter, p.trolley.power(tau, 0, x[3], tension[0] * s1))
    return (x[3], x[4], x[5], *acceleration, *power)


@system.kinetic.register(DoubleCrane)
def kinetic_energy(p, x):
    """Return the kinetic energy [J]."""
    cable = p.cable
    u1, u2 = cable.length1 * x[4], cable.length2 * x[5]
    vx, vz = x[3] + u1 * cos(x[1]), u1 * sin(x[1])
    wx, wz = vx + u2 * cos(x[2]), vz + u2 * sin(x[2])
    nodes = cable.mass1 * (vx * vx + vz * vz) + cable.mass2 * (wx * wx + wz * wz)
    return 0.5 * (axis_mass(p.trolley) * x[3] * x[3] + nodes)


@system.potential.register(DoubleCrane)
def potential_energy(p, x):
    """Return the potential energy [J]."""
    cable = p.cable
    upper = (cable.mass1 + cable.mass2) * cable.length1 * cos(x[1])
    return -p.gravity * (upper + cable.mass2 * cable.length2 * cos(x[2]))


@system.link_count.register(DoubleCrane)
def count_links(p):
    """Return the number of links."""
    return 2


@system.tensions.register(DoubleCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write both tensions [N]."""
    store(rows, i, first, double_dynamics(p, t, x, system.effort(u, p, t, x))[1])


@system.power.register(DoubleCrane)
def external_power(p, t, x, u):
    """Return the power [W] of the trolley's drive."""
    tau = system.effort(u, p, t, x)
    _, tension, s1 = double_dynamics(p, t, x, tau)
    return p.trolley.power(tau, 0, x[3], tension[0] * s1)


@system.points.register(DoubleCrane)
def write_points(p, t, x, out):
    """Write trolley and nodes."""
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for k, length in enumerate((p.cable.length1, p.cable.length2)):
        out[k + 1, 0] = out[k, 0] + length * sin(x[1 + k])
        out[k + 1, 1] = 0.0
        out[k + 1, 2] = out[k, 2] - length * cos(x[1 + k])
