"""Overhead cranes: a trolley (and a bridge) on rails, a hoist, and a cable of links with lumped masses.

Equations: Brogliato, "Lagrange dynamics of lumped-mass multibody models of overhead cranes", written in link tensions.

A state is positions, their rates, the energy supplied where there is a meter, and modes: an array, of small models a
tuple. Positions are those of trolley, bridge, hoist and cable. What a kind of crane never has is None in its class.
"""

from crane_sim.models.energy_meter import meter_size
from crane_sim.models.supports.hoist import hoist_coordinates


def count_axes(p):
    """Return the number of axes: 2 on a bridge."""
    return 1 if p.bridge is None else 2


def layout_of(p):
    """Return (number nq of coordinates, index of the first link's or node's, index of the first mode)."""
    first = count_axes(p) + hoist_coordinates(p.hoist)
    nq = first + p.cable_coordinates()
    return nq, first, 2 * nq + meter_size(p.energy_meter)


def first_link(p, x):
    """Return (length, rate) of the first link, at rest if it is elastic: of a cable with an array of lengths."""
    if p.hoist is None:
        return p.cable.lengths[0], 0.0
    nq, first, _ = layout_of(p)
    return x[first - 1], x[nq + first - 1]


def trolley_motion(p, x):
    """Return position [m] and velocity [m/s] (3,) of the trolley relative to the base."""
    nq, _, _ = layout_of(p)
    if p.bridge is None:
        return (x[0], 0.0, 0.0), (x[nq], 0.0, 0.0)
    return (x[0], x[1], 0.0), (x[nq], x[nq + 1], 0.0)
