"""The kink of the mean wind at the lowest height of its profile: steps end where the payload passes it."""

from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import dot, pose_at, to_world
from crane_sim.numerics.jit import generic
from crane_sim.system import KinkStepControl, Switching
from crane_sim.trajectories.wind import Kink, Wind

BAND = 1e-9  # m, beyond the kink, where a step ends: what begins there is certain to be on the other side


@generic
def pressed_point(p, x):
    """Return where the wind presses on the payload in state x (3,) [m], in the axes of the base."""
    raise NotImplementedError


def height_above_kink(p, t, x):
    """Return the height [m] above that of the kink at which the wind presses on the payload."""
    return p.wind.origin_height + to_world(pose_at(p.base, t), pressed_point(p, x))[2] - p.wind.profile.lowest


@generic
def wind_kink_guard(wind, p, value, t0, x0, t, x):
    """Return the result of `system.kink_guard` for a crane in this wind."""
    return value


@wind_kink_guard.register(Wind)
def _(wind, p, value, t0, x0, t, x):
    return wind_kink_guard(wind.kink, p, value, t0, x0, t, x)


@wind_kink_guard.register(Kink)
def _(wind, p, value, t0, x0, t, x):
    side = 1.0 if height_above_kink(p, t0, x0) > 0.0 else -1.0
    return min(value, side * height_above_kink(p, t, x) + BAND)


@generic
def with_kink_switching(wind, switching):
    """Return the result of `system.switching` for a crane in this wind, without which it is `switching`."""
    return switching


@with_kink_switching.register(Wind)
def _(wind, switching):
    return with_kink_switching(wind.kink, switching)


@with_kink_switching.register(Kink)
def _(wind, switching):
    return Switching(switching.capacity, switching.positions, KinkStepControl(switching.step_control))


@generic
def pressed_point_of(load, state):
    """Return where the wind presses on a load of these kinematics (3,) [m]."""
    return state.position


@pressed_point_of.register(RigidLoad)
def _(load, state):
    (x, y, z), (a, b, c), r = state.position, state.rows, load.pressure_centre
    return x + dot(a, r), y + dot(b, r), z + dot(c, r)
