"""Energies of overhead cranes on a moving base: what it adds to those relative to it, mass by mass.

An axis with prescribed motion has no mass, and the drum's reflected mass does not rotate with the base: neither counts.
"""

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain import COS, LENGTH, RATE, SIN, Rods
from crane_sim.models.cables.chain_3d import node_velocities
from crane_sim.models.moving_base import BaseState, added_energy, added_spin, base_state
from crane_sim.models.overhead import layout_of, planar, spatial
from crane_sim.models.overhead.elastic import ElasticCrane, mass_of, node_vector
from crane_sim.models.overhead.modes import get_payload_mass
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.spatial import SpatialCrane, write_positions
from crane_sim.models.supports.rails import axis_mass
from crane_sim.numerics.jit import generic, routine


@system.base_energy.register(PlanarCrane)
def _(p, t, x):
    return base_energy_in_plane(base_state(p.base, t, 0.0), p, x)


@system.base_energy.register(SpatialCrane)
def _(p, t, x):
    return base_energy_of_nodes(base_state(p.base, t, 0.0), p, x)


@system.base_energy.register(ElasticCrane)
def _(p, t, x):
    return base_energy_of_nodes(base_state(p.base, t, 0.0), p, x)


@generic
def base_energy_in_plane(base, p, x):
    """Return (kinetic, potential) energy [J] in the world less those relative to the base; `base`: `base_state`."""
    return 0.0, 0.0


@base_energy_in_plane.register(BaseState)
def _(base, p, x):
    w, (nq, _, _), (mass, r, v) = system.workspace(p), layout_of(p), allocate_bodies(p)
    planar.fill_links(p, x, w)
    v[:] = planar.node_velocities(p, x, w, planar.hoisted_link(p.hoist, p.cable, x, nq)[1])
    r[0, 0], mass[0] = x[0], axis_mass(p.trolley)
    for k in range(len(r) - 1):
        r[k + 1, 0] = r[k, 0] + w[LENGTH, k] * w[SIN, k]
        r[k + 1, 2] = r[k, 2] - w[LENGTH, k] * w[COS, k]
        mass[k + 1] = node_mass(p, x, k)
    kinetic, potential = base_energy_of_masses(base, p.gravity, mass, r, v)
    return kinetic + base_energy_of_rods(p.rods, base, w), potential


@generic
def base_energy_of_nodes(base, p, x):
    """Return as `base_energy_in_plane` does, for a crane on a bridge, or with an elastic cable."""
    return 0.0, 0.0


@base_energy_of_nodes.register(BaseState)
def _(base, p, x):
    mass, r, v = allocate_bodies(p)
    write_nodes(p, x, mass, r, v)
    whole = axis_mass(p.bridge)
    mass[0] = max(axis_mass(p.trolley), p.share * whole)
    kinetic, potential = base_energy_of_masses(base, p.gravity, mass, r, v)
    beam, y, rate = (1.0 - p.share) * whole, r[0, 1], v[0, 1]  # what does not go along x with the trolley
    more = added_energy(base, p.gravity, beam, (0.0, y, 0.0), (0.0, rate, 0.0))
    return kinetic + more[0], potential + more[1]


def allocate_bodies(p):
    """Return room for masses (N + 1,), positions and velocities (N + 1, 3) of trolley and nodes, zeros."""
    n = 1 + system.link_count(p)
    return np.zeros(n), np.zeros((n, 3)), np.zeros((n, 3))


def node_mass(p, x, k):
    """Return the mass [kg] of the node below link k, from 0, of a chain of rigid links."""
    mass = p.cable.masses[k]
    return mass if k + 1 < len(p.cable.masses) else get_payload_mass(p.event_limits, x, len(x) - 1, mass)


@generic
def write_nodes(p, x, mass, r, v):
    """Write masses of the nodes, and positions and velocities of trolley and nodes relative to the base."""
    raise NotImplementedError


@write_nodes.register(SpatialCrane)
def _(p, x, mass, r, v):
    nq, _, _ = layout_of(p)
    links = system.workspace(p).links
    spatial.fill_links(p, x, links)
    write_positions(p, x, r)
    v[:] = node_velocities(links, x[nq], x[nq + 1], spatial.hoisted_link(p.hoist, p.cable, x, nq)[1])
    for k in range(len(r) - 1):
        mass[k + 1] = node_mass(p, x, k)


@write_nodes.register(ElasticCrane)
def _(p, x, mass, r, v):
    for k in range(len(r)):
        r[k, 0], r[k, 1], r[k, 2] = node_vector(p, x, k, 0)
        v[k, 0], v[k, 1], v[k, 2] = node_vector(p, x, k, 1)
    for k in range(1, len(r)):
        mass[k] = mass_of(p, x, k)


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
        at, moves = (r[k, 0], r[k, 1], r[k, 2]), (v[k, 0], v[k, 1], v[k, 2])
        one, other = added_energy(base, gravity, mass[k], at, moves)
        kinetic, potential = kinetic + one, potential + other
    return kinetic, potential


@generic
def base_energy_of_rods(rods, base, w):
    """Return the kinetic energy [J] that the base adds to links that rotate as rods; `w`: work array of `chain`."""
    return 0.0


@base_energy_of_rods.register(Rods)
def _(rods, base, w):
    energy = 0.0
    for k in range(len(rods.inertia)):  # angles of links grow against turns about y
        energy += added_spin(base, (0.0, rods.inertia[k], (0.0, 1.0, 0.0)), (0.0, -w[RATE, k], 0.0))
    return energy
