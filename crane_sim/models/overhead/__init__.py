"""Overhead cranes: a trolley (and a bridge) on rails, a hoist, and a cable of links with lumped masses.

Equations: Brogliato, "Lagrange dynamics of lumped-mass multibody models of overhead cranes", written in link tensions.

A state is positions, their rates, the energy supplied where there is a meter, and modes: an array, of small models a
tuple. What `shared_implementations` needs of a model beside its fields is here.
"""

from crane_sim.numerics.jit import generic, routine


@generic
def layout_of(p):
    """Return (number nq of coordinates, index of the first link's or node's, index of the first mode)."""
    raise NotImplementedError


@generic
@routine
def energies(p, x):
    """Return (kinetic, potential) energy [J], as `system.kinetic` and `system.potential` do."""
    raise NotImplementedError


@generic
@routine
def smallest_guard(p, t, x, tau, work):
    """Return the result of `system.guard` at joint efforts tau."""
    raise NotImplementedError


@generic
def mode_of_stopped_axis(p, t, x, tau, axis, mode):
    """Return the friction's new mode of an axis whose guard has failed in `mode`, which is at rest."""
    raise NotImplementedError


@generic
@routine
def switch(p, t, x, tau, number):
    """Return the result of `system.apply_reset_map` at joint efforts tau."""
    raise NotImplementedError
