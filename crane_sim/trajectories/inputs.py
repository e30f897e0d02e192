"""Open-loop inputs: functions of time that drive the actuated joints where no law commands."""

from collections.abc import Sequence
from math import sin
from typing import Annotated, NamedTuple

from pydantic import Field

from crane_sim import system
from crane_sim.files.types import Angle, Real
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

    coefficients: Annotated[tuple[Real, ...], Field(min_length=1)]  # input's unit, of the powers 0,
    # 1, 2, ... of t, over s, s², ...


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


Channel = Constant | Sine | Polynomial | Table | Delayed


class Inputs(NamedTuple):
    """The inputs of the actuated joints."""

    channels: tuple[Channel, ...]  # (nu,)


def delay_inputs(inputs: Inputs, delays: Sequence[float], before: Sequence[float]) -> Inputs:
    """Return the inputs of nu joints, `delays[j]` [s] later; `before[j]` until then."""
    each = zip(inputs.channels, delays, before, strict=True)
    return Inputs(
        tuple(Delayed(channel, delay, held) if delay else channel for channel, delay, held in each)
    )


def value_at(channel, t):
    """Return the input's value at time t [s]."""
    if isinstance(channel, Constant):
        return channel.value
    if isinstance(channel, Sine):
        return channel.offset + channel.amplitude * sin(channel.frequency * t + channel.phase)
    if isinstance(channel, Polynomial):
        value = 0.0
        for coefficient in channel.coefficients[::-1]:
            value = value * t + coefficient
        return value
    if isinstance(channel, Delayed):
        return (
            value_at(channel.channel, t - channel.delay) if t >= channel.delay else channel.before
        )
    return table_value(channel.times, channel.values, t)


def table_value(times, values, t):
    """Return the value of a table at time t [s]."""
    last = len(times) - 1
    if t <= times[0]:
        return values[0]
    if t >= times[last]:
        return values[last]
    low = find_piece(times, last, t)
    high = low + 1
    return values[low] + (values[high] - values[low]) * (t - times[low]) / (
        times[high] - times[low]
    )


def values_at(inputs, t):
    """Return the values of all inputs (nu,) at time t."""
    return tuple([value_at(channel, t) for channel in inputs.channels])


@system.demand.register(Inputs)
def input_demand(u, p, t, x):
    """Return the values of the inputs at time t."""
    return values_at(u, t)


@system.effort.register(Inputs)
def input_effort(u, p, t, x):
    """Return the values of the inputs at time t within what the actuators give."""
    return system.saturate(p, values_at(u, t))


@system.command.register(Inputs)
def input_command(law, t, q, v):
    """Return the values of the inputs at time t."""
    return values_at(law, t)
