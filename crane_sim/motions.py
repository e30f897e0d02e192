"""Prescribed motions: functions of time with their first two derivatives."""

from math import cos, sin
from typing import NamedTuple

from crane_sim.jit import generic
from crane_sim.quantities import Angle, Positive, Real


class Smooth(NamedTuple):
    """From one value to another by the quintic 10s³ - 15s⁴ + 6s⁵, at rest before and after."""

    begin: Real
    end: Real
    start: Real = 0.0  # s
    duration: Positive = 1.0  # s


class Wave(NamedTuple):
    """offset + amplitude sin(frequency t + phase)."""

    amplitude: Real
    frequency: Real  # rad/s
    offset: Real = 0.0
    phase: Angle = 0.0  # rad


class Series(NamedTuple):
    """The sum of coefficients[k] t^k."""

    coefficients: tuple[Real, ...]


Motion = Smooth | Wave | Series


@generic
def position_at(motion, t):
    """Return (position, velocity) at time t [s]."""
    raise NotImplementedError


@generic
def acceleration_at(motion, t):
    """Return the acceleration at time t [s]."""
    raise NotImplementedError


@position_at.register(Smooth)
def _(motion, t):
    s = min(max((t - motion.start) / motion.duration, 0.0), 1.0)
    way = motion.end - motion.begin
    shape = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s)
    return motion.begin + way * shape, way / motion.duration * 30.0 * s * s * (1.0 - s) * (1.0 - s)


@acceleration_at.register(Smooth)
def _(motion, t):
    s = min(max((t - motion.start) / motion.duration, 0.0), 1.0)
    way = (motion.end - motion.begin) / (motion.duration * motion.duration)
    return way * 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s)


@position_at.register(Wave)
def _(motion, t):
    angle = motion.frequency * t + motion.phase
    return motion.offset + motion.amplitude * sin(angle), motion.amplitude * motion.frequency * cos(angle)


@acceleration_at.register(Wave)
def _(motion, t):
    return -motion.amplitude * motion.frequency * motion.frequency * sin(motion.frequency * t + motion.phase)


@position_at.register(Series)
def _(motion, t):
    value, rate = 0.0, 0.0
    for k in range(len(motion.coefficients) - 1, -1, -1):
        rate = rate * t + value
        value = value * t + motion.coefficients[k]
    return value, rate


@acceleration_at.register(Series)
def _(motion, t):
    value, rate, half = 0.0, 0.0, 0.0
    for k in range(len(motion.coefficients) - 1, -1, -1):
        half = half * t + rate
        rate = rate * t + value
        value = value * t + motion.coefficients[k]
    return 2.0 * half
