"""A meter makes the energy supplied a state, for runs whose work and losses cannot be had exactly from samples."""

from typing import NamedTuple

from crane_sim import system
from crane_sim.numerics.jit import generic, lean_generic


class Meter(NamedTuple):
    """The presence of a meter."""


@lean_generic
def meter_size(meter):
    """Return the number of floats that the meter adds to the state."""
    return 1


@meter_size.register(type(None))
def _(meter):
    return 0


@generic
def meter_entry(meter, value):
    """Return the value of the meter, or its rate, as a tuple, empty where there is none."""
    return ()


@meter_entry.register(Meter)
def _(meter, value):
    return (value,)


@generic
def append_power(meter, derivative, p, t, x, u):
    """Return the derivative of a state of two parts, with the supplied power appended where the crane is metered."""
    return derivative


@append_power.register(Meter)
def _(meter, derivative, p, t, x, u):
    return (derivative[0], derivative[1], system.power(p, t, x, u))


@generic
def metered_state(meter, x):
    """Return the initial state, with no energy supplied yet where the crane is metered."""
    return x


@metered_state.register(Meter)
def _(meter, x):
    return (x[0], x[1], 0.0)


@generic
def metered_like(meter, x, projected):
    """Return the projected state with the meter's reading of x kept."""
    return projected


@metered_like.register(Meter)
def _(meter, x, projected):
    return (projected[0], projected[1], x[2])


@generic
def reading(meter, x):
    """Return the meter's reading [J], 0 where there is none."""
    return 0.0


@reading.register(Meter)
def _(meter, x):
    return x[2]
