"""The kink of the mean wind at the lowest height of its profile: steps end at its passage."""

from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import pose_at, to_world
from crane_sim.multibody.vectors import add, multiply
from crane_sim.numerics.jit import generic
from crane_sim.system import KinkStepControl, Switching

# m, beyond the kink, where a step ends: what begins there is certain to be on the other side
BAND = 1e-9


@generic
def pressed_point(p, x):
    """Return where the wind presses on the payload in state x (3,) [m], in the axes of the base."""
    raise NotImplementedError


def height_above_kink(p, t, x):
    """Return the height [m] above that of the kink at which the wind presses on the payload."""
    return (
        p.wind.origin_height
        + to_world(pose_at(p.base, t), pressed_point(p, x))[2]
        - p.wind.profile.lowest
    )


def has_kink(wind):
    """Return whether the mean of this wind, None without one, has a kink."""
    return wind is not None and wind.kink is not None


def kink_guard(p, value, t0, x0, t, x):
    """Return the result of `system.kink_guard` for a crane that has a wind."""
    if not has_kink(p.wind):
        return value
    side = 1.0 if height_above_kink(p, t0, x0) > 0.0 else -1.0
    return min(value, side * height_above_kink(p, t, x) + BAND)


def with_kink_switching(wind, switching):
    """Return `system.switching` of a crane in this wind, from that without wind."""
    if not has_kink(wind):
        return switching
    return Switching(
        switching.capacity, switching.positions, KinkStepControl(switching.step_control)
    )


def pressed_point_of(load, state):
    """Return where the wind presses on a load of these kinematics (3,) [m]."""
    if not isinstance(load, RigidLoad):
        return state.position
    return add(state.position, multiply(state.rows, load.pressure_centre))
