"""The winch of falls whose rope runs over sheaves: its stick and slip, and the tensions of lead line and parts.

What a fall pulls and its strain are the pull of all parts of its rope; the falls together have `falls` times the
number of ropes parts. Lead lines of several ropes are one here, of their sum.
"""

from crane_sim import system
from crane_sim.models.falls.crane import (
    FallsCrane,
    common_length,
    falls_layout,
    kinematics_of,
    solve_dynamics,
    sum_falls,
    winch_index,
)
from crane_sim.models.guards import friction_event
from crane_sim.models.stops import WINCH
from crane_sim.models.supports.hoist import hoist_modes
from crane_sim.models.supports.joint_modes import friction_state_index, mode_after_guard
from crane_sim.models.supports.reeved_hoist import ReevedHoist, mode_of_stopped_winch, winch_guard, winch_mode
from crane_sim.models.supports.reeving_outputs import hoist_falls, write_fall_tensions
from crane_sim.models.supports.support import coordinate_count
from crane_sim.numerics.jit import generic, routine


@generic
def falls_winch_guard(hoist, best, p, t, x, u):
    """Return the smaller one of `best` and the guard of the winch's stick and slip."""
    return best


@falls_winch_guard.register(ReevedHoist)
def _(hoist, best, p, t, x, u):
    return reeved_guard(hoist, best, p, t, x, u)


@routine
def reeved_guard(hoist, best, p, t, x, u):
    """Return the result of `falls_winch_guard` for a rope over sheaves."""
    if hoist_modes(hoist) == 0:
        return best
    pose, tip, load, motion = kinematics_of(p, x)
    paid = sum_falls(p, x, pose, tip, load).paid
    mode = winch_mode(hoist, x, winch_index(p))
    return winch_guard(hoist, best, system.effort(u, p, t, x), mode, (*motion, p.gravity), paid)


@generic
def after_friction_guard(hoist, p, t, x, tau, joint):
    """Return (state, number of the event) after the guard of the friction of a joint or of the winch has failed."""
    return after_joint_guard(p, t, x, tau, joint)


@after_friction_guard.register(ReevedHoist)
def _(hoist, p, t, x, tau, joint):
    return after_winch_guard(p, t, x, tau) if joint == WINCH else after_joint_guard(p, t, x, tau, joint)


@routine
def after_winch_guard(p, t, x, tau):
    """Return (state, number of the event) after the guard of the winch's friction has failed."""
    (nq, _, _), k = falls_layout(p), winch_index(p)
    x, rate, mode_before = x.copy(), nq + coordinate_count(p.support), x[k]
    x[rate], x[k] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
    pull = solve_dynamics(p, t, x, tau).pull.paid
    length, _ = common_length(p.hoist, p, x, nq)
    x[k] = mode_of_stopped_winch(p.hoist, mode_before, tau, pull, length, p.gravity)
    return x, friction_event(WINCH, x[k])


@routine
def after_joint_guard(p, t, x, tau, joint):
    """Return (state, number of the event) after the guard of the friction of a support's joint has failed."""
    nq, _, _ = falls_layout(p)
    x, k = x.copy(), friction_state_index(p.support, x, joint)
    mode_before = x[k]
    x[nq + joint], x[k] = (0.0 if mode_before != 0.0 else x[nq + joint]), 0.0
    solved = solve_dynamics(p, t, x, tau)
    x[k] = mode_after_guard(p.support, joint, mode_before, solved)
    return x, friction_event(joint, x[k])


@system.fall_count.register(FallsCrane)
def _(p):
    return hoist_falls(p.hoist)


@system.fall_tensions.register(FallsCrane)
def _(p, t, x, u, rows, i):
    (nq, _, _), tau = falls_layout(p), system.effort(u, p, t, x)
    solved, mode = solve_dynamics(p, t, x, tau), winch_mode(p.hoist, x, winch_index(p))
    motion = (*common_length(p.hoist, p, x, nq), solved.length)
    write_fall_tensions(p.hoist, tau, mode, motion, solved.pull.paid, p.gravity, rows[i])
