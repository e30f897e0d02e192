"""An overhead crane whose cable is one spring and damper in the vertical plane, in closed form.

`elastic` has the equations for any number of links. State: a flat tuple (x, X, Z, x', X', Z',
(energy supplied)) with the payload's position (X, Z) in the world. The link pulls with T = k e + c
e', e its length beyond the rest length.
"""

from math import sqrt
from typing import NamedTuple

from crane_sim import system
from crane_sim.models.energy_meter import Meter, meter_entry
from crane_sim.models.supports.rails import Axis, axis_mass


class Spring(NamedTuple):
    """The link and the payload."""

    mass: float  # kg, of the payload
    length: float  # m, at rest
    stiffness: float  # N/m
    damping: float  # N s/m

    def with_payload(self, mass):
        """Return the cable with another payload [kg]."""
        return self._replace(mass=mass)


class SpringCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: Axis
    cable: Spring
    gravity: float = 9.81  # m/s²
    energy_meter: Meter | None = None

    hoist = event_limits = None

    def cable_coordinates(self):
        """Return the number of the payload's coordinates."""
        return 2


def spring_pull(p, x):
    """Return (unit vector down the link (2,), tension [N], elongation [m], damper's loss [W])."""
    dx, dz = x[1] - x[0], x[2]
    inverse = 1.0 / sqrt(dx * dx + dz * dz)
    nx, nz = dx * inverse, dz * inverse
    stretch = (dx * dx + dz * dz) * inverse - p.cable.length
    rate = nx * (x[4] - x[3]) + nz * x[5]
    damping = p.cable.damping * rate
    return (nx, nz), p.cable.stiffness * stretch + damping, stretch, damping * rate


def accelerations(p, t, x, tau):
    """Return the accelerations of trolley and payload (3,) [m/s²]."""
    (nx, nz), tension, _, _ = spring_pull(p, x)
    inv_mass, bias_acc = p.trolley.response(t, tau, 0, x[3], 0.0)
    drawn = tension / p.cable.mass
    return bias_acc + inv_mass * tension * nx, -drawn * nx, -drawn * nz - p.gravity


def net_power(p, x, tau):
    """Return the power [W] that drive and imposed motion supply, less what the damper takes."""
    (nx, _), tension, _, lost = spring_pull(p, x)
    return p.trolley.power(tau, 0, x[3], tension * nx) - lost


@system.rate_entries.register(SpringCrane)
def rate_entries(p):
    """Return the entries of trolley and payload."""
    return ((0, 3),)


@system.rhs.register(SpringCrane)
def state_derivative(p, t, x, u):
    """Return the derivative of the state."""
    tau = system.effort(u, p, t, x)
    return (
        x[3],
        x[4],
        x[5],
        *accelerations(p, t, x, tau),
        *meter_entry(p.energy_meter, net_power(p, x, tau)),
    )


@system.kinetic.register(SpringCrane)
def kinetic_energy(p, x):
    """Return the kinetic energy [J]."""
    return 0.5 * (axis_mass(p.trolley) * x[3] * x[3] + p.cable.mass * (x[4] * x[4] + x[5] * x[5]))


@system.potential.register(SpringCrane)
def potential_energy(p, x):
    """Return the potential energy [J]."""
    stretch = spring_pull(p, x)[2]
    return p.cable.mass * p.gravity * x[2] + 0.5 * p.cable.stiffness * stretch * stretch


@system.tensions.register(SpringCrane)
def write_tension(p, t, x, u, rows, i, first):
    """Write the tension [N]."""
    rows[i, first] = spring_pull(p, x)[1]


@system.power.register(SpringCrane)
def external_power(p, t, x, u):
    """Return the power [W] of drive and damper."""
    return net_power(p, x, system.effort(u, p, t, x))


@system.points.register(SpringCrane)
def write_points(p, t, x, out):
    """Write trolley and payload."""
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    out[1, 0], out[1, 1], out[1, 2] = x[1], 0.0, x[2]
