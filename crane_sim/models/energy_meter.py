"""An energy meter: a state that integrates the external work, where samples would not give it exactly."""

from typing import NamedTuple

from crane_sim.numerics.jit import generic


class Meter(NamedTuple):
    """Marks a crane whose state has the integral of the external power [J]: of drives, base, wind and losses."""


@generic
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
