"""Tensions of a rope over sheaves below any support, and the torque of its drum, as outputs."""

from crane_sim import system
from crane_sim.models.supports.hoist import MotionHoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist, drum_torque, rope_direction
from crane_sim.models.supports.reeving import Reeving, dead_end_of, fall_tension, follow_rope, sheave_factor
from crane_sim.numerics.jit import generic


@generic
def pull_on_winch(p, t, x, tau):
    """Return (pull of all falls [N], mode of the winch, motion) of a crane p under efforts tau.

    `motion` is (length [m], its rate [m/s], its acceleration [m/s²]).
    """
    raise NotImplementedError


@generic
def hoist_falls(hoist):
    """Return the number of falls of a hoist's reeving, 0 without one."""
    return 0


@hoist_falls.register(MotionHoist)
@hoist_falls.register(ReevedHoist)
def _(hoist):
    return falls_of(hoist.reeving)


@generic
def falls_of(reeving):
    """Return the number of falls of a reeving, 0 for None."""
    return 0


@falls_of.register(Reeving)
def _(reeving):
    return reeving.falls


@generic
def write_hoist_falls(hoist, p, t, x, u, rows, i):
    """Write the result of `system.fall_tensions` of a crane with this hoist."""


@write_hoist_falls.register(MotionHoist)
@write_hoist_falls.register(ReevedHoist)
def _(hoist, p, t, x, u, rows, i):
    write_falls(hoist.reeving, p, t, x, u, rows, i)


@generic
def write_falls(reeving, p, t, x, u, rows, i):
    """Write the result of `system.fall_tensions` of a crane whose hoist has this reeving, None without one."""


@write_falls.register(Reeving)
def _(reeving, p, t, x, u, rows, i):
    tau = system.effort(u, p, t, x)
    pull, mode, motion = pull_on_winch(p, t, x, tau)
    factor = sheave_factor(reeving.loss, rope_direction(p.hoist, tau, mode, pull, motion, p.gravity))
    dead_end = dead_end_of(reeving, factor, pull, motion, p.gravity)
    _, lead, _, _ = follow_rope(reeving, factor, dead_end, motion, p.gravity)
    rows[i, 0] = lead
    for k in range(1, reeving.falls + 1):
        rows[i, k] = fall_tension(reeving, factor, dead_end, motion, p.gravity, k)
    rows[i, reeving.falls + 1] = drum_torque(reeving, lead, motion)
