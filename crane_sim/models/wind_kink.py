"""The kink of the mean wind at the lowest height of its profile: steps end where the payload passes it."""

from crane_sim.models.guards import smaller_guard
from crane_sim.models.loads import RigidLoad
from crane_sim.models.moving_base import dot, pose_at, to_world
from crane_sim.numerics.jit import generic, lean_generic, lean_kernel
from crane_sim.numerics.states import replace_field
from crane_sim.system import KinkStepControl, Switching
from crane_sim.trajectories.wind import Kink, Wind

BAND = 1e-9  # m, beyond the kink, where a step ends: what begins there is certain to be on the other side


@lean_generic
def pressed_point(p, x):
    """Return where the wind presses on the payload in state x (3,) [m], in the axes of the base."""
    raise NotImplementedError


@lean_kernel
def height_above_kink(p, t, x):
    """Return the height [m] above that of the kink at which the wind presses on the payload."""
    return p.wind.origin_height + to_world(pose_at(p.base, t), pressed_point(p, x))[2] - p.wind.profile.lowest


@lean_generic
def kink_guard(wind, best, p, t, x):
    """Return the smaller one of `best` and the guard of the wind's kink, which leaves the number as it is."""
    return best


@kink_guard.register(Wind)
def _(wind, best, p, t, x):
    return kink_guard(wind.kink, best, p, t, x)


@kink_guard.register(Kink)
def _(wind, best, p, t, x):
    return smaller_guard(best, wind.side * height_above_kink(p, t, x) + BAND, best[1])


@lean_generic
def orient_wind(wind, p, t, x):
    """Return the result of `system.orient` for a crane in this wind."""
    return p


@orient_wind.register(Wind)
def _(wind, p, t, x):
    return orient_wind(wind.kink, p, t, x)


@orient_wind.register(Kink)
def _(wind, p, t, x):
    side = 1.0 if height_above_kink(p, t, x) > 0.0 else -1.0
    return replace_field(p, "wind", replace_field(p.wind, "kink", Kink(side)))


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


@lean_generic
def pressed_point_of(load, state):
    """Return where the wind presses on a load of these kinematics (3,) [m]."""
    return state.position


@pressed_point_of.register(RigidLoad)
def _(load, state):
    (x, y, z), (a, b, c), r = state.position, state.rows, load.pressure_centre
    return x + dot(a, r), y + dot(b, r), z + dot(c, r)
