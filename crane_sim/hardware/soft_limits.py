"""Soft limits: a joint's largest speed from which its drive can still stop it within its travel.

The reference of a drive by speed follows a command by ramps of limited acceleration and jerk
(`reference_profiles`), so where it would come to rest is known in closed form: the way with the
command held for a while, and the ramp to rest. A speed is permitted where that place is within the
travel; the largest such speed is found by bisection.
"""

from typing import NamedTuple

from crane_sim.hardware.reference_profiles import (
    fall_velocity,
    hold_velocity,
    phase_distance,
    plan_ramp,
    ramp_distance,
)
from crane_sim.numerics.jit import entry_point, routine

_BISECTIONS = 40  # halve the range of speeds to 1e-12 of it


class ReferenceMotion(NamedTuple):
    """The motion of a joint's reference."""

    position: float  # m or rad
    velocity: float
    acceleration: float


def motion_in_phase(s, x, v, a, jerk):
    """Return the motion after s seconds of constant jerk."""
    return ReferenceMotion(
        x + phase_distance(s, v, a, jerk), v + s * (a + 0.5 * s * jerk), a + s * jerk
    )


@routine
def motion_after(motion, command, bounds, s):
    """Return the reference's motion after s seconds in which its command, a speed, holds."""
    ramp = plan_ramp(motion.velocity, motion.acceleration, command, bounds)
    x, v, a = motion.position, motion.velocity, motion.acceleration
    if s < ramp.rise:
        return motion_in_phase(s, x, v, a, ramp.jerk)
    x, v, s = (
        x + phase_distance(ramp.rise, v, a, ramp.jerk),
        hold_velocity(ramp, v, a),
        s - ramp.rise,
    )
    if s < ramp.hold:
        return motion_in_phase(s, x, v, ramp.peak, 0.0)
    x, v, s = (
        x + phase_distance(ramp.hold, v, ramp.peak, 0.0),
        fall_velocity(ramp, command),
        s - ramp.hold,
    )
    if s < ramp.fall:
        return motion_in_phase(s, x, v, ramp.peak, -ramp.jerk)
    x, s = x + phase_distance(ramp.fall, v, ramp.peak, -ramp.jerk), s - ramp.fall
    return ReferenceMotion(x + s * command, command, 0.0)


@routine
def rest_position(motion, command, bounds, ahead):
    """Return where the reference comes to rest [m or rad] after its command ends.

    The command holds for `ahead` seconds and then is zero.
    """
    after = motion_after(motion, command, bounds, ahead)
    return after.position + ramp_distance(after.velocity, after.acceleration, 0.0, bounds)


@entry_point
def follow(motion, command, bounds, s):
    """Return the reference's motion s seconds later; the command is a speed [m/s or rad/s]."""
    return motion_after(motion, command, bounds, s)


@entry_point
def permitted_speed(motion, command, bounds, low, high, ahead):
    """Return the speed between zero and a command, nearest to it, that lets a joint stop in time.

    It stops within its travel.

    Args:
        motion: of the joint's reference.
        command: m/s or rad/s.
        bounds: of the reference.
        low, high: ends of the travel [m or rad]; infinite where there is none.
        ahead: s for which the speed is held until the next one may count.
    """
    sign = 1.0 if command >= 0.0 else -1.0
    limit = high if command >= 0.0 else low
    if sign * (rest_position(motion, command, bounds, ahead) - limit) <= 0.0:
        return command
    least, most = 0.0, abs(command)
    for _ in range(_BISECTIONS):
        middle = 0.5 * (least + most)
        if sign * (rest_position(motion, sign * middle, bounds, ahead) - limit) <= 0.0:
            least = middle
        else:
            most = middle
    return sign * least
