"""Friction of the actuated joints of a crane with one rope: slew, boom, jib, and winch.

Each joint has one float at the end of the state: a mode (`models.supports.friction`) or the
deflection of bristles (`models.supports.lugre`). A joint that sticks is a constraint: it leaves the
equations of the others as if its inertia were infinite, and a winch that sticks is a rope that
keeps its length.
"""

from typing import NamedTuple

from crane_sim.models.cables.rope import winch_pull, without_rate
from crane_sim.models.guards import Guard, encode, friction_event, smaller_guard
from crane_sim.models.stops import WINCH
from crane_sim.models.supports.friction import Friction, friction_effort
from crane_sim.models.supports.lugre import LuGre
from crane_sim.numerics.states import replace_entry

# m/s, of a rope's rate, which is computed from other velocities and so not exactly 0
STANDSTILL = 1e-12


class JointFriction(NamedTuple):
    """Friction of the actuated joints, of either kind."""

    slew: Friction | LuGre | None  # N m, of the tower's bearing
    boom: Friction | LuGre | None  # N m, of the joint at the tower
    jib: Friction | LuGre | None  # N m, of the joint between boom and jib, on the jib's elevation
    rope: Friction | LuGre | None  # N, of a winch driven by force, in terms of the rope


def hold_joints(friction, pose, x):
    """Return the posture of state x with the joints that friction holds."""
    if friction is None:
        return pose
    return pose._replace(free=tuple([not sticks for sticks in sticking_joints(friction, x)]))


def add_joint_friction(friction, tau, rope_state, x):
    """Return the joint efforts tau plus those of friction, none on a joint that sticks."""
    if friction is None:
        return tau
    # three: the winch has an effort or none
    of_support = zip(tau, friction, x[0][3:], x[-1], strict=False)
    turning = [
        effort + friction_effort(part, rate, state) for effort, part, rate, state in of_support
    ]
    if friction.rope is None:
        return (*turning, *tau[WINCH:])
    return (*turning, tau[WINCH] + friction_effort(friction.rope, rope_state.rate, x[-1][WINCH]))


def constraint_efforts(p, motion):
    """Return the constraint efforts (slew, boom, jib, winch) at a Motion of p.

    They are what friction bears where it holds.
    """
    gravity, efforts, tip = p.gravity, motion.efforts, motion.tip_force
    slew, boom, jib = p.support.constraint_efforts(
        motion.pose, gravity, efforts, tip, motion.support_acceleration
    )
    return slew, boom, jib, motion.tension - winch_pull(p.cable, efforts, motion.rope_state)


def any_joint_sticks(friction, x):
    """Return whether friction holds a joint in state x."""
    return friction is not None and any(sticking_joints(friction, x))


def sticking_joints(friction, x):
    """Return which joints friction holds in state x."""
    return [
        part is not None and part.sticks(state) for part, state in zip(friction, x[-1], strict=True)
    ]


def friction_guards(friction, best, x, rate, efforts):
    """Return the smallest one of `best` and of the guards of the joints' friction.

    Args:
        friction: its parameters, None without one.
        best: the smallest of the other guards.
        x: state.
        rate: of the rope [m/s].
        efforts: result of `constraint_efforts`, anything where no joint sticks.
    """
    if friction is None:
        return best
    rates = (*x[0][3:], rate + x[-1][WINCH] * STANDSTILL)
    for joint, (part, v, state, effort) in enumerate(
        zip(friction, rates, x[-1], efforts, strict=True)
    ):
        value = 1.0 if part is None else part.guard(v, state, effort)
        best = smaller_guard(best, value, encode(Guard.FRICTION, joint))
    return best


def stop_joint(x, joint, rope_state):
    """Return state x with a joint at rest whose friction has ended its motion, and held."""
    xs, xc = x[0], x[1]
    if x[-1][joint] != 0.0 and joint < WINCH:
        xs = replace_entry(xs, 3 + joint, 0.0)
    if x[-1][joint] != 0.0 and joint == WINCH:
        xc = without_rate(rope_state, xc)
    return (xs, xc, *x[2:-1], replace_entry(x[-1], joint, 0.0))


def after_guard(friction, x, joint, mode, efforts):
    """Return (state with the new mode of a joint at rest after its guard failed, the event)."""
    for k, part in enumerate(friction):
        if isinstance(part, Friction) and joint == k:
            mode = part.breakaway_mode(mode, efforts[k])
    return (*x[:-1], replace_entry(x[-1], joint, mode)), friction_event(joint, mode)


def initial_friction_states(friction, v):
    """Return the friction states of joints at velocities v (nq,), as a part of a crane's state."""
    if friction is None:
        return ()
    rates = v[0], v[1], v[2], 0.0 if abs(v[WINCH]) <= STANDSTILL else v[WINCH]
    parts = zip(friction, rates, strict=True)
    return (tuple([1.0 if part is None else part.initial_state(rate) for part, rate in parts]),)


def friction_rates(friction, x, rate):
    """Return the derivatives of `initial_friction_states`; `rate` is the rope's [m/s]."""
    if friction is None:
        return ()
    parts = zip(friction, (*x[0][3:], rate), x[-1], strict=True)
    return (
        tuple([0.0 if part is None else part.state_rate(v, state) for part, v, state in parts]),
    )


def hold_rope(friction, x, xc, rope_state):
    """Return the payload's part xc of state x, the rope at rest where friction holds its winch."""
    if friction is None or friction.rope is None:
        return xc
    return without_rate(rope_state, xc) if friction.rope.sticks(x[-1][WINCH]) else xc
