"""Guards of a crane with one rope: of positions alone, unless the rope must stay taut or joints stick and slip."""

from crane_sim import system
from crane_sim.models.cables.rope import rope_kinematics
from crane_sim.models.guards import Guard, decode, encode, smaller_guard
from crane_sim.models.moving_base import to_turned_axes
from crane_sim.models.single_rope.crane import Crane, solve_motion
from crane_sim.models.single_rope.joint_friction import (
    JointFriction,
    after_guard,
    any_joint_sticks,
    constraint_efforts,
    friction_guards,
    stop_joint,
    with_friction_state,
)
from crane_sim.models.stops import Stops, describe_stop, length_guard, make_switching
from crane_sim.models.supports import forward_kinematics, support_guard, yaw
from crane_sim.models.supports.friction import first_not_none, step_control_of
from crane_sim.models.wind_kink import pressed_point, wind_kink_guard, with_kink_switching
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic, routine
from crane_sim.system import EVENT_LOG_CAPACITY, Switching

POSITIONS = 6  # of support and payload
NO_EFFORTS = (0.0, 0.0, 0.0, 0.0)


@system.switching.register(Crane)
def _(p):
    return with_kink_switching(p.wind, friction_switching(p.friction, p.stops))


@system.kink_guard.register(Crane)
def _(p, value, t0, x0, t, x):
    return wind_kink_guard(p.wind, p, value, t0, x0, t, x)


@pressed_point.register(Crane)
def _(p, x):
    s, c = sincos(yaw(p.support, x[0]))
    return to_turned_axes((x[1][0], x[1][1], x[1][2]), -s, c)


@generic
def friction_switching(friction, stops):
    """Return the result of `system.switching` for a crane with this friction of its joints."""
    return make_switching(stops, POSITIONS)


@friction_switching.register(JointFriction)
def _(friction, stops):
    turning = first_not_none(
        first_not_none(step_control_of(friction.slew), step_control_of(friction.boom)), step_control_of(friction.jib)
    )
    return Switching(EVENT_LOG_CAPACITY, 0, first_not_none(turning, step_control_of(friction.rope)))


@system.guard.register(Crane)
def _(p, t, x, u, work):
    return smallest_guard(p, t, x, u)


@routine
def smallest_guard(p, t, x, u):
    """Return (the smallest guard, its number, evaluations)."""
    stops, taut = p.stops, p.stops.taut > 0.0
    forces = taut or any_joint_sticks(p.friction, x)
    rope_state = rope_kinematics(forward_kinematics(p.support, x[0]), x[1])
    best = support_guard(p.support, length_guard(stops, rope_state.length, rope_state.rate), x[0])
    tension, efforts = tension_and_constraint_efforts(p.friction, p, t, x, u) if forces else (0.0, NO_EFFORTS)
    if taut:
        best = smaller_guard(best, tension, encode(Guard.LINK, 0))
    value, number = friction_guards(p.friction, best, x, rope_state.rate, efforts)
    return value, number, int(forces)


@generic
def tension_and_constraint_efforts(friction, p, t, x, u):
    """Return (tension [N], result of `constraint_efforts`, zeros of a crane without friction of its joints)."""
    return solve_motion(p, t, x, system.effort(u, p, t, x)).tension, NO_EFFORTS


@tension_and_constraint_efforts.register(JointFriction)
def _(friction, p, t, x, u):
    motion = solve_motion(p, t, x, system.effort(u, p, t, x))
    return motion.tension, constraint_efforts(p, motion)


@system.apply_reset_map.register(Crane)
def _(p, t, x, u, number):
    return switch_joint(p.friction, p, t, x, u, number)


@generic
def switch_joint(friction, p, t, x, u, number):
    """Return the result of `system.apply_reset_map` for a crane with this friction of its joints."""
    return x, number, False


@switch_joint.register(JointFriction)
def _(friction, p, t, x, u, number):
    kind, joint, _ = decode(number)
    if kind != Guard.FRICTION:
        return x, number, False
    still = stop_joint(x, joint, rope_kinematics(forward_kinematics(p.support, x[0]), x[1]))
    efforts = constraint_efforts(p, solve_motion(p, t, still, system.effort(u, p, t, still)))
    return (*with_friction_state(still, joint, after_guard(friction, joint, x[-1][joint], efforts)), True)


@system.describe_event.register(Crane)
def _(p, number):
    return describe_stop(p.support, p.stops or Stops(), number)
