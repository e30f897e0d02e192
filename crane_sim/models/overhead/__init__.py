"""Closed forms of overhead cranes in the plane: a trolley, a hoist, links with lumped masses.

Equations: Brogliato, "Lagrange dynamics of lumped-mass multibody models of overhead cranes",
written in link tensions.

A state is positions, their rates, the energy supplied where there is a meter, and modes: an array,
of small models a tuple. Positions are those of trolley, hoist and cable. What a kind of crane never
has is None in its class.
"""

from crane_sim.models.energy_meter import meter_size
from crane_sim.models.supports.hoist import hoist_coordinates


def layout_of(p):
    """Return (number nq of coordinates, index of the first one of the cable, of the first mode)."""
    first = 1 + hoist_coordinates(p.hoist)
    nq = first + p.cable_coordinates()
    return nq, first, 2 * nq + meter_size(p.energy_meter)


def first_link(p, x):
    """Return (length, rate) of the first link of a cable with an array of lengths."""
    if p.hoist is None:
        return p.cable.lengths[0], 0
    nq, first, _ = layout_of(p)
    return x[first - 1], x[nq + first - 1]


def hoist_mode(x):
    """Return the friction mode of the hoist in state x, ahead of the number of payload changes."""
    return x[len(x) - 2]
