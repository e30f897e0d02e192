"""Reference profiles of servo drives in closed form: ramps of speed, motions to a position.

A profile is a sequence of phases of constant jerk, each (duration [s], velocity, acceleration, jerk
at its start), the last one without end. A ramp changes the velocity in the least time within the
largest acceleration and jerk and ends without acceleration: the acceleration grows, holds, and
fades (Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, Springer
2008, section 3.4). A motion to a position is a ramp to a cruise speed, the cruise, and a ramp to
rest; the cruise speed is a root of the distance, found by bisection. From rest, or from motion
towards the target, that takes the least time.
"""

from math import inf, sqrt
from typing import NamedTuple

from crane_sim.numerics.jit import routine

PHASES = 8
"""Phases of a profile: two ramps of three, the cruise between them, and rest."""
_BISECTIONS = 64  # halve the range of speeds to the last bit


class Bounds(NamedTuple):
    """Bounds of a joint's reference; infinite where there is none."""

    speed: float  # m/s or rad/s
    acceleration: float
    jerk: float


class Ramp(NamedTuple):
    """A change of velocity in three phases."""

    rise: float  # s, in which the acceleration changes to its peak
    hold: float  # s
    fall: float  # s, in which it fades to 0
    peak: float  # acceleration
    jerk: float  # while it rises; the opposite while it fades


def plan_ramp(v, a, target, bounds):
    """Return the ramp from velocity v, acceleration a to the target velocity, acceleration 0."""
    largest, jerk = bounds.acceleration, bounds.jerk
    if jerk == inf:
        if largest == inf:
            return Ramp(0.0, 0.0, 0.0, 0.0, 0.0)
        return Ramp(0.0, abs(target - v) / largest, 0.0, largest if target >= v else -largest, 0.0)
    sign = 1.0 if target >= v + 0.5 * a * abs(a) / jerk else -1.0
    change, initial = sign * (target - v), sign * a
    peak, hold = sqrt(max(0.0, jerk * change + 0.5 * initial * initial)), 0.0
    if peak > largest:
        peak, hold = (
            largest,
            (change - (largest * largest - 0.5 * initial * initial) / jerk) / largest,
        )
    return Ramp(max(0.0, peak - initial) / jerk, hold, peak / jerk, sign * peak, sign * jerk)


def phase_distance(duration, v, a, jerk):
    """Return the distance [m or rad] of a phase."""
    return duration * (v + duration * (0.5 * a + duration * jerk / 6.0))


def hold_velocity(ramp, v, a):
    """Return the velocity at which the acceleration of a ramp from (v, a) has reached its peak."""
    return v + 0.5 * (a + ramp.peak) * ramp.rise


def fall_velocity(ramp, target):
    """Return the velocity at which a ramp's acceleration begins to fade before the target."""
    return target - 0.5 * ramp.peak * ramp.fall


def ramp_distance(v, a, target, bounds):
    """Return the distance [m or rad] of the ramp that `plan_ramp` returns."""
    ramp = plan_ramp(v, a, target, bounds)
    rise = phase_distance(ramp.rise, v, a, ramp.jerk)
    hold = phase_distance(ramp.hold, hold_velocity(ramp, v, a), ramp.peak, 0.0)
    return (
        rise + hold + phase_distance(ramp.fall, fall_velocity(ramp, target), ramp.peak, -ramp.jerk)
    )


def motion_distance(v, a, cruise, bounds):
    """Return the distance [m or rad] from velocity v, acceleration a via a cruise speed to rest."""
    return ramp_distance(v, a, cruise, bounds) + ramp_distance(cruise, 0.0, 0.0, bounds)


def write_phase(phases, i, k, duration, v, a, jerk):
    """Write phase k of joint i."""
    phases[i, k, 0], phases[i, k, 1], phases[i, k, 2], phases[i, k, 3] = duration, v, a, jerk


def write_ramp(phases, i, k, v, a, target, bounds):
    """Write the ramp from velocity v, acceleration a to the target as phases k .. k + 2.

    The target is a velocity, the phases are those of joint i.
    """
    ramp = plan_ramp(v, a, target, bounds)
    write_phase(phases, i, k, ramp.rise, v, a, ramp.jerk)
    write_phase(phases, i, k + 1, ramp.hold, hold_velocity(ramp, v, a), ramp.peak, 0.0)
    write_phase(phases, i, k + 2, ramp.fall, fall_velocity(ramp, target), ramp.peak, -ramp.jerk)


@routine
def plan_velocity(phases, i, v, a, target, bounds):
    """Write the phases of joint i from velocity v and acceleration a to a velocity that stays."""
    write_ramp(phases, i, 0, v, a, target, bounds)
    for k in range(3, PHASES):
        write_phase(phases, i, k, inf, target, 0.0, 0.0)


def cruise_speed(v, a, distance, bounds):
    """Return the cruise velocity of a motion over a distance to rest.

    It begins with velocity v and acceleration a.
    """
    sign = 1.0 if distance >= ramp_distance(v, a, 0.0, bounds) else -1.0
    low, high = 0.0, bounds.speed
    if sign * (motion_distance(v, a, sign * high, bounds) - distance) <= 0.0:
        return sign * high
    faded = sign * (v + 0.5 * a * abs(a) / bounds.jerk)  # speed once the acceleration has faded
    if 0.0 < faded < high:  # below it the distance bulges, and a slower way is as long
        if sign * (motion_distance(v, a, sign * faded, bounds) - distance) <= 0.0:
            low = faded
        else:
            high = faded
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        if sign * (motion_distance(v, a, sign * middle, bounds) - distance) <= 0.0:
            low = middle
        else:
            high = middle
    return sign * low


@routine
def plan_position(phases, i, v, a, distance, bounds):
    """Write joint i's phases from velocity v and acceleration a over a distance to rest.

    The speed is bounded.
    """
    cruise = cruise_speed(v, a, distance, bounds)
    rest = distance - motion_distance(v, a, cruise, bounds)
    write_ramp(phases, i, 0, v, a, cruise, bounds)
    write_phase(phases, i, 3, rest / cruise if cruise != 0.0 else 0.0, cruise, 0.0, 0.0)
    write_ramp(phases, i, 4, cruise, 0.0, 0.0, bounds)
    write_phase(phases, i, 7, inf, 0.0, 0.0, 0.0)
