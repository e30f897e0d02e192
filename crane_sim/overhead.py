"""An overhead crane in the vertical plane: trolley x chain, with a hoist or without."""

from math import cos, sin
from typing import NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.cables.chain import (
    Chain,
    ForceHoist,
    PrescribedHoist,
    drum,
    drum_inertia,
    drum_power,
    first_link,
    hoisted,
    tensions,
)
from crane_sim.jit import generic, kernel, routine
from crane_sim.meter import Meter, meter_size
from crane_sim.supports.trolley import FixedTrolley, ForceTrolley, PrescribedTrolley, rail, rail_power, trolley_mass


class OverheadCrane(NamedTuple):
    """Parameters of a whole crane; what is None is not modelled."""

    trolley: ForceTrolley | PrescribedTrolley | FixedTrolley
    cable: Chain
    hoist: PrescribedHoist | ForceHoist | None = None
    gravity: float = 9.81  # m/s²
    meter: Meter | None = None

    def metered(self, sampled: bool) -> "OverheadCrane":
        """Return the model with a meter where held efforts do not tell all the energy supplied."""
        imposed = isinstance(self.trolley, PrescribedTrolley) or isinstance(self.hoist, PrescribedHoist)
        return self._replace(meter=Meter()) if imposed or not sampled else self


@kernel
def layout(p):
    """Return (number of coordinates, index of the first angle)."""
    first = 1 + hoisted(p.hoist)
    return first + len(p.cable.masses), first


@routine
def solved(p, t, x, tau):
    """Return (the array of `tensions`, acceleration of the trolley, of the first link's length)."""
    nq, first = layout(p)
    give, push = rail(p.trolley, t, tau)
    pay, run = drum(p.hoist, t, tau)
    length, _ = first_link(p.hoist, p.cable, x, nq)
    out = tensions(p.cable, x, first, nq, length, (give, push, pay, run), p.gravity)
    return out, push + give * out[2, 0] * out[0, 0], run + pay * out[2, 0]


@system.rhs.register(OverheadCrane)
def _(p, t, x, u):
    return derivative(p, t, x, u)


@routine
def derivative(p, t, x, u):
    """Return the time derivative of the state, an array like x."""
    nq, first = layout(p)
    n, m, lengths = len(p.cable.masses), p.cable.masses, p.cable.lengths
    out, trolley, paid = solved(p, t, x, system.effort(u, p, t, x))
    length, rate = first_link(p.hoist, p.cable, x, nq)
    dx = np.empty(2 * nq + meter_size(p.meter))
    for i in range(nq):
        dx[i] = x[nq + i]
    dx[nq] = trolley
    if first == 2:
        dx[nq + 1] = paid
    above = 0.0
    for k in range(n):
        below = 0.0
        if k + 1 < n:
            below = (out[0, k + 1] * out[1, k] - out[1, k + 1] * out[0, k]) * out[2, k + 1] / m[k]
        if k == 0:
            pull = p.gravity * out[0, 0] + out[1, 0] * trolley + 2.0 * rate * x[nq + first]
            dx[nq + first] = (below - pull) / length
        else:
            dx[nq + first + k] = (below - above) / lengths[k]
        if k + 1 < n:
            above = (out[0, k + 1] * out[1, k] - out[1, k + 1] * out[0, k]) * out[2, k] / m[k]
    if len(dx) > 2 * nq:
        dx[2 * nq] = system.power(p, t, x, u)
    return dx


@system.joints.register(OverheadCrane)
def _(p, x):
    nq, _ = layout(p)
    return x[:nq].copy(), x[nq : 2 * nq].copy()


@system.state.register(OverheadCrane)
def _(p, q, v):
    nq, _ = layout(p)
    x = np.zeros(2 * nq + meter_size(p.meter))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    return x


@system.limited.register(OverheadCrane)
def _(p, u):
    return u


@generic
def commands(trolley, hoist, row):
    """Return the efforts in the array `row` as a tuple, the trolley's first."""
    return ()


@commands.register(ForceTrolley)
def _(trolley, hoist, row):
    return (row[0], *hoist_command(hoist, row, 1))


@commands.register(PrescribedTrolley)
@commands.register(FixedTrolley)
def _(trolley, hoist, row):
    return hoist_command(hoist, row, 0)


@generic
def hoist_command(hoist, row, i):
    """Return the hoist's effort as a tuple, empty where it takes none."""
    return ()


@hoist_command.register(ForceHoist)
def _(hoist, row, i):
    return (row[i],)


@system.held.register(OverheadCrane)
def _(p, row):
    return commands(p.trolley, p.hoist, row)


@system.acceleration.register(OverheadCrane)
def _(p, t, x, u):
    nq, _ = layout(p)
    return system.rhs(p, t, x, u)[nq : 2 * nq].copy()


@routine
def energies(p, x):
    """Return (kinetic, potential) energy."""
    nq, first = layout(p)
    length, rate = first_link(p.hoist, p.cable, x, nq)
    v = x[nq]
    vx, vz, z = v, 0.0, 0.0
    kinetic = 0.5 * trolley_mass(p.trolley) * v * v + 0.5 * drum_inertia(p.hoist) * rate * rate
    potential = 0.0
    for k in range(len(p.cable.masses)):
        link = length if k == 0 else p.cable.lengths[k]
        paid = rate if k == 0 else 0.0
        s, c, w = sin(x[first + k]), cos(x[first + k]), x[nq + first + k]
        vx = vx + paid * s + link * c * w
        vz = vz - paid * c + link * s * w
        z = z - link * c
        kinetic = kinetic + 0.5 * p.cable.masses[k] * (vx * vx + vz * vz)
        potential = potential + p.cable.masses[k] * p.gravity * z
    return kinetic, potential


@system.kinetic.register(OverheadCrane)
def _(p, x):
    return energies(p, x)[0]


@system.potential.register(OverheadCrane)
def _(p, x):
    return energies(p, x)[1]


@system.tension.register(OverheadCrane)
def _(p, t, x, u):
    out, _, _ = solved(p, t, x, system.effort(u, p, t, x))
    return out[2].min()


@system.power.register(OverheadCrane)
def _(p, t, x, u):
    nq, _ = layout(p)
    tau = system.effort(u, p, t, x)
    out, _, _ = solved(p, t, x, tau)
    _, rate = first_link(p.hoist, p.cable, x, nq)
    rail_share = rail_power(p.trolley, tau, x[nq], out[2, 0] * out[0, 0])
    return rail_share + drum_power(p.hoist, tau, rate, out[2, 0])


@system.supplied.register(OverheadCrane)
def _(p, x):
    nq, _ = layout(p)
    return x[2 * nq] if len(x) > 2 * nq else 0.0


@system.point_count.register(OverheadCrane)
def _(p):
    return 1 + len(p.cable.masses)


@system.tip_index.register(OverheadCrane)
def _(p):
    return 0


@system.points.register(OverheadCrane)
def _(p, x, out):
    nq, first = layout(p)
    length, _ = first_link(p.hoist, p.cable, x, nq)
    out[0, 0], out[0, 1], out[0, 2] = x[0], 0.0, 0.0
    for k in range(len(p.cable.masses)):
        link = length if k == 0 else p.cable.lengths[k]
        out[k + 1, 0] = out[k, 0] + link * sin(x[first + k])
        out[k + 1, 1] = 0.0
        out[k + 1, 2] = out[k, 2] - link * cos(x[first + k])
