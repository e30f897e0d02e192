"""Energies of overhead cranes on a moving base: what it adds to those relative to it, mass by mass.

An axis with prescribed motion has no mass, and the drum's reflected mass does not rotate with the base: neither counts.
"""

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import RATE
from crane_sim.models.cables.chain_3d import row_of
from crane_sim.models.moving_base import added_energy, added_spin, base_state
from crane_sim.models.overhead.modes import mass_of
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.supports.rails import axis_mass
from crane_sim.numerics.jit import routine


@system.base_energy.register(PlanarCrane)
def base_energy(p, t, x):
    """Return what a moving base adds to the energies of axes and nodes."""
    base = base_state(p.base, t, 0.0)
    if base is None:
        return 0.0, 0.0
    n = 1 + system.link_count(p)
    mass, r, v = np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3))
    p.write_nodes(x, r, v)
    for k in range(1, n):
        mass[k] = mass_of(p, x, k)
    whole = axis_mass(p.bridge)
    mass[0] = max(axis_mass(p.trolley), p.share * whole)
    kinetic, potential = base_energy_of_masses(base, p.gravity, mass, r, v)
    beam, y, rate = (1.0 - p.share) * whole, r[0, 1], v[0, 1]  # what does not go along x with the trolley
    more = added_energy(base, p.gravity, beam, (0.0, y, 0.0), (0.0, rate, 0.0))
    return kinetic + more[0] + base_energy_of_rods(base, p, x), potential + more[1]


@routine
def base_energy_of_masses(base, gravity, mass, r, v):
    """Return (kinetic, potential) energy [J] of masses in the world less those relative to the base.

    Args:
        base, gravity: see `added_energy`.
        mass: (n,) kg.
        r, v: positions and velocities relative to the base (n, 3).
    """
    kinetic, potential = 0.0, 0.0
    for k in range(len(mass)):
        one, other = added_energy(base, gravity, mass[k], row_of(r, k), row_of(v, k))
        kinetic, potential = kinetic + one, potential + other
    return kinetic, potential


def base_energy_of_rods(base, p, x):
    """Return the kinetic energy [J] that the base adds to links that rotate as rods."""
    if p.rods is None:
        return 0.0
    w, energy = system.workspace(p), 0.0
    p.fill_links(x, w)
    for k in range(len(p.rods.inertia)):  # angles of links grow against turns about y
        energy += added_spin(base, (0.0, p.rods.inertia[k], (0.0, 1.0, 0.0)), (0.0, -w[RATE, k], 0.0))
    return energy
