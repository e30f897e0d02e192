"""The winch of a suspended crane: its stick and slip, a slack fall, and the tensions of its falls as outputs."""

from crane_sim import system
from crane_sim.models.guards import Guard, encode, friction_event, smaller_guard
from crane_sim.models.stops import WINCH, make_switching
from crane_sim.models.supports.friction import step_control_of
from crane_sim.models.supports.hoist import MotionHoist, hoist_modes
from crane_sim.models.supports.reeved_hoist import (
    ReevedHoist,
    mode_of_stopped_winch,
    slip_direction,
    winch_guard,
    winch_mode,
)
from crane_sim.models.supports.reeving import Reeving, dead_end_of, follow_rope, sheave_factor
from crane_sim.models.supports.reeving_outputs import hoist_falls, write_fall_tensions
from crane_sim.models.supports.support import coordinate_count
from crane_sim.models.suspended.crane import SuspendedCrane, first_length, solve_dynamics, suspended_layout
from crane_sim.numerics.jit import generic, routine
from crane_sim.system import EVENT_LOG_CAPACITY, Switching


@generic
def winch_switching(hoist, stops):
    """Return the result of `system.switching` for a crane with this hoist."""
    return make_switching(stops, 0)


@winch_switching.register(ReevedHoist)
def _(hoist, stops):
    return Switching(EVENT_LOG_CAPACITY, 0, step_control_of(hoist.friction))


def winch_sticks(p, x):
    """Return whether friction holds the winch in state x."""
    return hoist_modes(p.hoist) > 0 and winch_mode(p.hoist, x, suspended_layout(p)[2]) == 0.0


def suspended_winch_guard(p, best, x, tau, tension):
    """Return the smaller one of `best` and the guard of the winch's stick and slip at the tensions [N] of the links."""
    nq, _, end = suspended_layout(p)
    motion = (*first_length(p.hoist, p, x, nq), p.gravity)
    return winch_guard(p.hoist, best, tau, winch_mode(p.hoist, x, end), motion, tension[0])


@routine
def after_winch_guard(p, t, x, tau):
    """Return (state, number of the event) after the guard of the winch's friction has failed."""
    nq, _, end = suspended_layout(p)
    x, work, rate, mode_before = x.copy(), system.workspace(p), nq + coordinate_count(p.support), x[end]
    x[rate], x[end] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
    solve_dynamics(p, t, x, tau, work)
    length, _ = first_length(p.hoist, p, x, nq)
    x[end] = mode_of_stopped_winch(p.hoist, mode_before, tau, work.tension[0], length, p.gravity)
    return x, friction_event(WINCH, x[end])


@generic
def fall_guard(hoist, best, p, x, motion, tension):
    """Return the smaller one of `best` and the smallest tension of falls and lead line, if the hoist has some.

    Args:
        hoist: of the crane.
        best: the smallest of the other guards.
        p, x: crane and state.
        motion: (length [m], its rate [m/s], its acceleration [m/s²]).
        tension: of the links (N,) [N].
    """
    return best


@fall_guard.register(MotionHoist)
@fall_guard.register(ReevedHoist)
def _(hoist, best, p, x, motion, tension):
    return smallest_tension(hoist.reeving, best, p, x, motion, tension)


@generic
def smallest_tension(reeving, best, p, x, motion, tension):
    """Return the result of `fall_guard` for a hoist with this reeving, None without one."""
    return best


@smallest_tension.register(Reeving)
def _(reeving, best, p, x, motion, tension):
    mode = winch_mode(p.hoist, x, suspended_layout(p)[2])
    factor = sheave_factor(reeving.loss, slip_direction(p.hoist, motion[1], mode))
    dead_end = dead_end_of(reeving, factor, tension[0], motion, p.gravity)
    _, _, smallest, _ = follow_rope(reeving, factor, dead_end, motion, p.gravity)
    return smaller_guard(best, smallest, encode(Guard.LINK, len(tension)))


@system.fall_count.register(SuspendedCrane)
def _(p):
    return hoist_falls(p.hoist)


@system.fall_tensions.register(SuspendedCrane)
def _(p, t, x, u, rows, i):
    (nq, _, end), work, tau = suspended_layout(p), system.workspace(p), system.effort(u, p, t, x)
    motion = (*first_length(p.hoist, p, x, nq), solve_dynamics(p, t, x, tau, work).length)
    mode = winch_mode(p.hoist, x, end)
    write_fall_tensions(p.hoist, tau, mode, motion, work.tension[0], p.gravity, rows[i])
