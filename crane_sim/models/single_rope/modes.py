"""Guards of a crane with one rope: of positions, and of forces for a taut rope or friction."""

from math import inf

from crane_sim import system
from crane_sim.models.cables.rope import rope_kinematics
from crane_sim.models.guards import Guard, decode, encode, smaller_guard
from crane_sim.models.single_rope.crane import Crane, solve_motion
from crane_sim.models.single_rope.joint_friction import (
    after_guard,
    any_joint_sticks,
    constraint_efforts,
    friction_guards,
    stop_joint,
)
from crane_sim.models.stops import Stops, describe_stop, length_guard, make_switching
from crane_sim.models.supports.friction import step_control_of
from crane_sim.models.wind_kink import kink_guard, pressed_point, with_kink_switching
from crane_sim.multibody.vectors import to_turned_axes
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import routine
from crane_sim.system import EVENT_LOG_CAPACITY, Switching

POSITIONS = 6  # of support and payload
NO_EFFORTS = (0.0, 0.0, 0.0, 0.0)


@system.switching.register(Crane)
def switching(p):
    """Return how the equations switch: by friction of joints, stops and the kink of a wind."""
    if p.friction is None:
        return with_kink_switching(p.wind, make_switching(p.stops, POSITIONS))
    return with_kink_switching(
        p.wind, Switching(EVENT_LOG_CAPACITY, 0, step_control_of(*p.friction))
    )


system.kink_guard.register(Crane)(kink_guard)


@pressed_point.register(Crane)
def payload_position(p, x):
    """Return the payload's position (3,) [m] in the axes of the base."""
    s, c = sincos(p.support.yaw(x[0]))
    return to_turned_axes((x[1][0], x[1][1], x[1][2]), -s, c)


@system.guard.register(Crane)
@routine
def smallest_guard(p, t, x, u, work):
    """Return (the smallest guard, its number, evaluations)."""
    stops, taut = p.stops, p.stops.taut > 0.0
    forces = taut or any_joint_sticks(p.friction, x)
    rope_state = rope_kinematics(p.support.forward_kinematics(x[0]), x[1])
    best = length_guard(stops, (inf, 0), rope_state.length, rope_state.rate)
    best = p.support.guard(best, x[0])
    tension, efforts = tension_and_constraint_efforts(p, t, x, u) if forces else (0.0, NO_EFFORTS)
    if taut:
        best = smaller_guard(best, tension, encode(Guard.LINK, 0))
    value, number = friction_guards(p.friction, best, x, rope_state.rate, efforts)
    return value, number, int(forces)


def tension_and_constraint_efforts(p, t, x, u):
    """Return (tension [N], result of `constraint_efforts`).

    The latter is zeros for a crane without friction of its joints.
    """
    motion = solve_motion(p, t, x, system.effort(u, p, t, x))
    return motion.tension, NO_EFFORTS if p.friction is None else constraint_efforts(p, motion)


@system.apply_reset_map.register(Crane)
def switch_joint(p, t, x, u, number):
    """Return the state after a joint came to rest or broke loose; other guards end a run."""
    kind, joint, _ = decode(number)
    if p.friction is None or kind != Guard.FRICTION:
        return x, number, False
    still = stop_joint(x, joint, rope_kinematics(p.support.forward_kinematics(x[0]), x[1]))
    efforts = constraint_efforts(p, solve_motion(p, t, still, system.effort(u, p, t, still)))
    return (*after_guard(p.friction, still, joint, x[-1][joint], efforts), True)


@system.describe_event.register(Crane)
def describe_event(p, number):
    """Return texts on an event of joints, rope or limits."""
    return describe_stop(p.support, p.stops or Stops(), number)
