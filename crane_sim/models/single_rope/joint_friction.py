"""Friction of the actuated joints of a crane with one rope: slew, boom and jib, and the winch of the rope.

Each joint has one float at the end of the state: a mode (`models.supports.friction`) or the deflection of bristles
(`models.supports.lugre`). A joint that sticks is a constraint: it leaves the equations of the others as if its inertia
were infinite, and a winch that sticks is a rope that keeps its length.
"""

from typing import NamedTuple

from crane_sim.models.cables.rope import imposed_tension, limit_to_pull, winch_pull, winch_tension, without_rate
from crane_sim.models.guards import Guard, encode, friction_event, smaller_guard
from crane_sim.models.stops import WINCH
from crane_sim.models.supports import joint_constraint_efforts
from crane_sim.models.supports.friction import (
    Friction,
    breakaway_mode,
    friction_effort,
    friction_guard,
    friction_state_rate,
    initial_friction_state,
    joint_sticks,
)
from crane_sim.models.supports.lugre import LuGre
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_entry, replace_field

STANDSTILL = 1e-12  # m/s, of a rope's rate, which is computed from other velocities and so not exactly 0


class JointFriction(NamedTuple):
    """Friction of the actuated joints, of either kind."""

    slew: Friction | LuGre | None  # N m, of the tower's bearing
    boom: Friction | LuGre | None  # N m, of the joint at the tower
    jib: Friction | LuGre | None  # N m, of the joint between boom and jib, on the jib's elevation
    rope: Friction | LuGre | None  # N, of a winch driven by force, in terms of the rope


@generic
def hold_joints(friction, pose, x):
    """Return the posture of state x with the joints that friction holds."""
    return pose


@hold_joints.register(JointFriction)
def _(friction, pose, x):
    slew, boom, jib, rope = x[-1]
    free = (
        not joint_sticks(friction.slew, slew),
        not joint_sticks(friction.boom, boom),
        not joint_sticks(friction.jib, jib),
    )
    return replace_field(pose, "free", (*free, not joint_sticks(friction.rope, rope)))


@generic
def add_joint_friction(friction, tau, rope_state, x):
    """Return the joint efforts tau plus those of friction, which a joint that sticks has none of."""
    return tau


@add_joint_friction.register(JointFriction)
def _(friction, tau, rope_state, x):
    (_, _, _, va, vb, vg), (slew, boom, jib, rope) = x[0], x[-1]
    return (
        tau[0] + friction_effort(friction.slew, va, slew),
        tau[1] + friction_effort(friction.boom, vb, boom),
        tau[2] + friction_effort(friction.jib, vg, jib),
        *winch_effort(friction.rope, tau, rope_state.rate, rope),
    )


@generic
def winch_effort(friction, tau, rate, friction_state):
    """Return the winch's effort with friction as a tuple, empty for a winch without one."""
    return tau[3:]


@winch_effort.register(Friction)
@winch_effort.register(LuGre)
def _(friction, tau, rate, friction_state):
    return (tau[3] + friction_effort(friction, rate, friction_state),)


@winch_tension.register(JointFriction)
def _(friction, p, pose, rope_state, tau, force, reaction):
    if pose.free[WINCH]:
        return winch_pull(p.cable, tau, rope_state)
    return imposed_tension(p, pose, rope_state, tau, force, reaction, 0.0)


@limit_to_pull.register(JointFriction)
def _(friction, u):
    return limit_to_pull(friction.rope, u)


@limit_to_pull.register(Friction)
@limit_to_pull.register(LuGre)
def _(friction, u):
    return u  # the winch overcomes its friction to pay out, while the rope pulls


def constraint_efforts(p, motion):
    """Return the constraint efforts (slew, boom, jib, winch) at a Motion of p: what friction bears where it holds."""
    gravity, efforts, tip = p.gravity, motion.efforts, motion.tip_force
    slew, boom, jib = joint_constraint_efforts(
        p.support, motion.pose, gravity, efforts, tip, motion.support_acceleration
    )
    return slew, boom, jib, motion.tension - winch_pull(p.cable, efforts, motion.rope_state)


@generic
def any_joint_sticks(friction, x):
    """Return whether friction holds a joint in state x."""
    return False


@any_joint_sticks.register(JointFriction)
def _(friction, x):
    slew, boom, jib, rope = x[-1]
    turning = joint_sticks(friction.slew, slew) or joint_sticks(friction.boom, boom) or joint_sticks(friction.jib, jib)
    return turning or joint_sticks(friction.rope, rope)


@generic
def friction_guards(friction, best, x, rate, efforts):
    """Return the smallest one of `best` and of the guards of the joints' friction.

    Args:
        friction: its parameters, None without one.
        best: the smallest of the other guards.
        x: state.
        rate: of the rope [m/s].
        efforts: result of `constraint_efforts`, anything where no joint sticks.
    """
    return best


@friction_guards.register(JointFriction)
def _(friction, best, x, rate, efforts):
    (_, _, _, va, vb, vg), (slew, boom, jib, rope) = x[0], x[-1]
    best = smaller_guard(best, friction_guard(friction.slew, va, slew, efforts[0]), encode(Guard.FRICTION, 0))
    best = smaller_guard(best, friction_guard(friction.boom, vb, boom, efforts[1]), encode(Guard.FRICTION, 1))
    best = smaller_guard(best, friction_guard(friction.jib, vg, jib, efforts[2]), encode(Guard.FRICTION, 2))
    winch = friction_guard(friction.rope, rate + rope * STANDSTILL, rope, efforts[WINCH])
    return smaller_guard(best, winch, encode(Guard.FRICTION, WINCH))


def stop_joint(x, joint, rope_state):
    """Return state x with a joint at rest whose friction has ended its motion, and held."""
    xs, xc = x[0], x[1]
    if x[-1][joint] != 0.0 and joint < WINCH:
        xs = replace_entry(xs, 3 + joint, 0.0)
    if x[-1][joint] != 0.0 and joint == WINCH:
        xc = without_rate(rope_state, xc)
    return (xs, xc, *x[2:-1], replace_entry(x[-1], joint, 0.0))


def after_guard(friction, joint, friction_state, efforts):
    """Return the new mode of a joint whose guard has failed in mode `friction_state`, at rest under `efforts`."""
    if joint == 0:
        mode = breakaway_mode(friction.slew, friction_state, efforts[0])
    elif joint == 1:
        mode = breakaway_mode(friction.boom, friction_state, efforts[1])
    elif joint == 2:
        mode = breakaway_mode(friction.jib, friction_state, efforts[2])
    else:
        mode = breakaway_mode(friction.rope, friction_state, efforts[WINCH])
    return mode


def with_friction_state(x, joint, friction_state):
    """Return state x with the friction state of a joint replaced, and the number of that event."""
    return (*x[:-1], replace_entry(x[-1], joint, friction_state)), friction_event(joint, friction_state)


@generic
def append_friction_states(friction, x, v):
    """Return the initial state x with the friction states of joints at velocities v (nq,) appended."""
    return x


@append_friction_states.register(JointFriction)
def _(friction, x, v):
    rate = 0.0 if abs(v[WINCH]) <= STANDSTILL else v[WINCH]
    turning = (
        initial_friction_state(friction.slew, v[0]),
        initial_friction_state(friction.boom, v[1]),
        initial_friction_state(friction.jib, v[2]),
    )
    return (*x, (*turning, initial_friction_state(friction.rope, rate)))


@generic
def append_friction_rates(friction, derivative, x, rate):
    """Return the derivative of state x with those of the friction states appended; `rate` is the rope's [m/s]."""
    return derivative


@append_friction_rates.register(JointFriction)
def _(friction, derivative, x, rate):
    (_, _, _, va, vb, vg), (slew, boom, jib, rope) = x[0], x[-1]
    turning = friction_state_rate(friction.slew, va, slew), friction_state_rate(friction.boom, vb, boom)
    rates = (*turning, friction_state_rate(friction.jib, vg, jib), friction_state_rate(friction.rope, rate, rope))
    return (*derivative, rates)


@generic
def keep_friction_states(friction, x, projected, rope_state):
    """Return the projected state with the friction states of x, the rope at rest where friction holds its winch."""
    return projected


@keep_friction_states.register(JointFriction)
def _(friction, x, projected, rope_state):
    sticks = joint_sticks(friction.rope, x[-1][WINCH])
    xc = without_rate(rope_state, projected[1]) if sticks else projected[1]
    return (projected[0], xc, *x[2:])
