"""An overhead crane whose cable is a chain of springs and dampers, in the vertical plane or in space.

State: one array [x, (y), (l1), r_1 .. r_N, x', (y'), (l1'), r_1' .. r_N', (energy supplied), (modes)] with the nodes'
positions r_k on the base: (x, z) each in the plane, (x, y, z) in space. Link k pulls with T = k e + c e', e its length
beyond the rest length, l1 of the first link where there is a hoist. Modes: friction of the axes, 1 or 0 for each link
that is taut or slack, changes of the payload.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from crane_sim.jit import lean_generic, lean_kernel
from crane_sim.meter import Meter, meter_size
from crane_sim.overhead.audit import metered
from crane_sim.overhead.axes import Axis
from crane_sim.overhead.carried import Moving
from crane_sim.overhead.forces import NodeForces
from crane_sim.overhead.hoists import Hoist, hoisted
from crane_sim.overhead.switches import Switches, payload_mass, story

LINK = 2000
"""Events of link k, from 0: LINK + 2 k, it went slack; LINK + 2 k + 1, it pulls."""


class Springs(NamedTuple):
    """Node masses and links from the top, (N,) arrays; the last node is the payload."""

    masses: Any  # kg
    lengths: Any  # m, at rest; the first one is the initial one where there is a hoist
    stiffness: Any  # N/m
    damping: Any  # N s/m
    tension_only: float  # 1: a link that would push is slack, 0: links also push


class ElasticCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled. It is in space when it has a bridge."""

    trolley: Axis
    bridge: Axis | None
    cable: Springs
    hoist: Hoist | None = None
    gravity: float = 9.81  # m/s²
    forces: NodeForces | None = None
    switches: Switches | None = None
    meter: Meter | None = None
    base: Moving | None = None
    share: float = 1.0  # of the mass that the bridge moves, at the trolley's place; the rest is where x = 0

    def metered(self, held: bool) -> "ElasticCrane":
        """Return the model with a meter where held efforts do not tell all the energy supplied."""
        return self._replace(meter=Meter()) if np.any(self.cable.damping) else metered(self, held)

    def story(self, which: int) -> tuple[str, str]:
        """Return (what event number `which` tells, what a user can change) in words."""
        if which < LINK:
            return story(self.switches, which)
        return f"link {(which - LINK) // 2 + 1} {'pulls' if which % 2 else 'went slack'}", ""


@lean_generic
def dimensions(bridge):
    """Return in how many dimensions the nodes move."""
    return 3


@dimensions.register(type(None))
def _(bridge):
    return 2


@lean_kernel
def layout(p):
    """Return (number of coordinates, index of the first node's, dimensions, index of the first mode)."""
    d = dimensions(p.bridge)
    first = d - 1 + hoisted(p.hoist)
    nq = first + d * len(p.cable.masses)
    return nq, first, d, 2 * nq + meter_size(p.meter)


@lean_generic
def rest_of_first(hoist, cable, x, top, nq):
    """Return (rest length, its rate) of the first link; its coordinate is number `top`."""
    return x[top], x[nq + top]


@rest_of_first.register(type(None))
def _(hoist, cable, x, top, nq):
    return cable.lengths[0], 0.0


@lean_kernel
def vector(p, x, k, order):
    """Return the position (order 0) or velocity (order 1) of node k on the base, (3,); node 0 is the trolley."""
    nq, first, d, _ = layout(p)
    if k == 0:
        i = order * nq
        return x[i], x[i + 1] if d == 3 else 0.0, 0.0
    i = order * nq + first + d * (k - 1)
    return x[i], x[i + 1] if d == 3 else 0.0, x[i + d - 1]


@lean_kernel
def link(p, x, k):
    """Return (unit vector (3,) from node k to node k + 1, length, elongation, its rate) of link k, from 0."""
    nq, first, _, _ = layout(p)
    rest, paid = p.cable.lengths[k], 0.0
    if k == 0:
        rest, paid = rest_of_first(p.hoist, p.cable, x, first - 1, nq)
    (ax, ay, az), (bx, by, bz) = vector(p, x, k, 0), vector(p, x, k + 1, 0)
    (ux, uy, uz), (vx, vy, vz) = vector(p, x, k, 1), vector(p, x, k + 1, 1)
    dx, dy, dz = bx - ax, by - ay, bz - az
    length = sqrt(dx * dx + dy * dy + dz * dz)
    nx, ny, nz = dx / length, dy / length, dz / length
    return (nx, ny, nz), length, length - rest, nx * (vx - ux) + ny * (vy - uy) + nz * (vz - uz) - paid


@lean_generic
def tautness(switches, x, first):
    """Return the mode, 1 taut or 0 slack, of the link whose mode is number `first`."""
    return 1.0


@tautness.register(Switches)
def _(switches, x, first):
    return x[first]


@lean_kernel
def pull(p, x, k):
    """Return (unit vector (3,), tension [N], power that the damper takes [W]) of link k, from 0."""
    _, _, d, modes = layout(p)
    n, _, stretch, rate = link(p, x, k)
    taut = tautness(p.switches, x, modes + d - 1 + k)
    damping = taut * p.cable.damping[k] * rate
    return n, taut * p.cable.stiffness[k] * stretch + damping, damping * rate


@lean_kernel
def mass_of(p, x, k):
    """Return the mass [kg] of node k, from 1."""
    mass = p.cable.masses[k - 1]
    return mass if k < len(p.cable.masses) else payload_mass(p.switches, x, len(x) - 1, mass)
