"""The winch of a crane whose load hangs below a support: guards of its stick and slip, and of a slack fall."""

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.supports.hoist import MotionHoist, hoist_modes
from crane_sim.models.supports.reeved_hoist import ReevedHoist, slip_direction, winch_guard, winch_mode
from crane_sim.models.supports.reeving import dead_end_of, follow_rope, sheave_factor
from crane_sim.models.suspended.layout import rope_length, winch_index


def mode_of_winch(p, x):
    """Return the mode of the winch in state x, 0 for one without friction."""
    return winch_mode(p.hoist, x, winch_index(p))


def winch_sticks(p, x):
    """Return whether friction holds the winch in state x."""
    return hoist_modes(p.hoist) > 0 and mode_of_winch(p, x) == 0.0


def smallest_winch_guard(p, best, x, tau, pull):
    """Return the smaller one of `best` and the guard of the winch's stick and slip under a pull [N] on the length."""
    return winch_guard(p.hoist, best, tau, mode_of_winch(p, x), (*rope_length(p, x), p.gravity), pull)


def fall_guard(p, best, x, acceleration, tension):
    """Return the smaller one of `best` and the smallest tension of falls and lead line, if the hoist has some.

    Args:
        p, best, x: the crane, the smallest of the other guards, and the state.
        acceleration: of the first link's length [m/s²].
        tension: of the links (N,) [N].
    """
    if not isinstance(p.hoist, MotionHoist | ReevedHoist) or p.hoist.reeving is None:
        return best
    reeving, motion = p.hoist.reeving, (*rope_length(p, x), acceleration)
    factor = sheave_factor(reeving.loss, slip_direction(p.hoist, motion[1], mode_of_winch(p, x)))
    dead_end = dead_end_of(reeving, factor, tension[0], motion, p.gravity)
    _, _, smallest, _ = follow_rope(reeving, factor, dead_end, motion, p.gravity)
    return smaller_guard(best, smallest, encode(Guard.LINK, len(tension)))
