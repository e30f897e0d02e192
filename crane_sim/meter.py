"""A meter makes the energy supplied a state, for runs whose work and losses cannot be had exactly from samples."""

from typing import NamedTuple

from crane_sim.jit import lean_generic


class Meter(NamedTuple):
    """The presence of a meter."""


@lean_generic
def meter_size(meter):
    """Return how many floats the meter adds to the state."""
    return 1


@meter_size.register(type(None))
def _(meter):
    return 0
