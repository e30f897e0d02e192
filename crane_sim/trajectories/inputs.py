"""Open-loop inputs: functions of time that drive the actuated joints where no law commands."""

from collections.abc import Sequence
from math import sin
from typing import Annotated, NamedTuple

from pydantic import Field

from crane_sim import system
from crane_sim.files.types import Angle, Real
from crane_sim.numerics.jit import generic
from crane_sim.trajectories.piecewise import find_piece, find_table_error


class Constant(NamedTuple):
    """A constant input."""

    value: Real = 0.0  # input's unit, at all times


class Sine(NamedTuple):
    """offset + amplitude sin(frequency t + phase)."""

    amplitude: Real  # input's unit, size of the sine
    frequency: Real  # rad/s, of the sine
    offset: Real = 0.0  # input's unit, added to the sine
    phase: Angle = 0.0  # rad, of the sine at t = 0


class Polynomial(NamedTuple):
    """The sum of coefficients[k] t^k."""

    coefficients: Annotated[tuple[Real, ...], Field(min_length=1)]  # input's unit, of the powers 0, 1, 2, ... of t,
    # over s, s², ...


class Table(NamedTuple):
    """Linear interpolation between (times, values); the ends are held."""

    times: Annotated[tuple[Real, ...], Field(min_length=1)]  # s, increasing
    values: Annotated[tuple[Real, ...], Field(min_length=1)]  # input's unit, as many as times

    def find_error(self) -> str:
        """Return one line on what is wrong with the table, empty when nothing is."""
        return find_table_error(self.times, self.values)


class Delayed(NamedTuple):
    """An input that takes effect later, behind the delay of its drive."""

    channel: "Constant | Sine | Polynomial | Table | Delayed"
    delay: float  # s
    before: float  # input's unit, its value until then


class Inputs(NamedTuple):
    """The input of one actuated joint, and the list of those of the other joints, which equations can walk by type."""

    first: Constant | Sine | Polynomial | Table | Delayed
    tail: "Inputs | None" = None


def delay_inputs(inputs: Inputs | None, delays: Sequence[float], before: Sequence[float]) -> Inputs | None:
    """Return the inputs of n joints, each of them `delays[j]` [s] later, and `before[j]` until then."""
    if inputs is None:
        return None
    first = Delayed(inputs.first, delays[0], before[0]) if delays[0] else inputs.first
    return Inputs(first, delay_inputs(inputs.tail, delays[1:], before[1:]))


@generic
def value_at(channel, t):
    """Return the input's value at time t [s]."""
    raise NotImplementedError


@value_at.register(Constant)
def _(channel, t):
    return channel.value


@value_at.register(Sine)
def _(channel, t):
    return channel.offset + channel.amplitude * sin(channel.frequency * t + channel.phase)


@value_at.register(Polynomial)
def _(channel, t):
    value = 0.0
    for k in range(len(channel.coefficients) - 1, -1, -1):
        value = value * t + channel.coefficients[k]
    return value


@value_at.register(Table)
def _(channel, t):
    times, values = channel.times, channel.values
    last = len(times) - 1
    if t <= times[0]:
        return values[0]
    if t >= times[last]:
        return values[last]
    low = find_piece(times, last, t)
    high = low + 1
    return values[low] + (values[high] - values[low]) * (t - times[low]) / (times[high] - times[low])


@value_at.register(Delayed)
def _(channel, t):
    return value_at(channel.channel, t - channel.delay) if t >= channel.delay else channel.before


@generic
def values_at(inputs, t):
    """Return the values of all inputs (nu,) at time t."""
    return ()


@values_at.register(Inputs)
def _(inputs, t):
    return (value_at(inputs.first, t), *values_at(inputs.tail, t))


@system.demand.register(Inputs)
def _(u, p, t, x):
    return values_at(u, t)


@system.effort.register(Inputs)
def _(u, p, t, x):
    return system.saturate(p, values_at(u, t))


@system.command.register(Inputs)
def _(law, t, q, v):
    return values_at(law, t)
