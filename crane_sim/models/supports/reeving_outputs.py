"""Tensions of a rope over sheaves below any support, and the torque of its drum, as outputs."""

from crane_sim.models.supports.reeved_hoist import drum_torque, rope_direction
from crane_sim.models.supports.reeving import dead_end_of, fall_tension, follow_rope, reeving_of, sheave_factor


def hoist_falls(hoist):
    """Return the number of falls of a hoist's reeving, 0 without one."""
    reeving = reeving_of(hoist)
    return 0 if reeving is None else reeving.falls


def write_fall_tensions(hoist, tau, mode, motion, pull, gravity, row):
    """Write the result of `system.fall_tensions` of a crane into a row; none without a reeving.

    Args:
        hoist: of the crane.
        tau: efforts of all joints.
        mode: of the winch, by `winch_mode`.
        motion: (length [m], its rate [m/s], its acceleration [m/s²]).
        pull: of all falls [N].
        gravity: acceleration of free fall [m/s²].
        row: (falls + 2,), written.
    """
    reeving = reeving_of(hoist)
    if reeving is None:
        return
    factor = sheave_factor(reeving.loss, rope_direction(hoist, tau, mode, pull, motion, gravity))
    dead_end = dead_end_of(reeving, factor, pull, motion, gravity)
    _, lead, _, _ = follow_rope(reeving, factor, dead_end, motion, gravity)
    row[0] = lead
    for k in range(1, reeving.falls + 1):
        row[k] = fall_tension(reeving, factor, dead_end, motion, gravity, k)
    row[reeving.falls + 1] = drum_torque(reeving, lead, motion)
