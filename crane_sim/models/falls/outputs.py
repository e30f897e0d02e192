"""Outputs of a crane with elastic falls: energies, tensions, points; modes of falls.

Joint coordinates are the support's, the falls' common length where a winch changes it, the position of the load's
centre of mass in the axes of the base, and its attitude, a quaternion (w, x, y, z).
"""

from crane_sim import system
from crane_sim.models.falls.crane import FallsCrane, body_state, fall_state, kinematics_of, taut_fall
from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.hanging.carrier import carrier_energies, posture_of, write_polyline
from crane_sim.models.hanging.exchange import load_of
from crane_sim.models.hanging.layout import layout_of
from crane_sim.models.loads import align_quaternion, load_energies
from crane_sim.models.moving_base import pose_at, to_world
from crane_sim.models.wind_kink import pressed_point, pressed_point_of
from crane_sim.multibody import linear
from crane_sim.numerics.jit import routine


@system.project_in_place.register(FallsCrane)
@routine
def normalise(p, x):
    """Give the quaternion its length 1, and take from its rates what is not across it."""
    nq, first, _ = layout_of(p)
    align_quaternion(x, first + 3, nq + first + 3)


@routine
def initialize_fall_modes(p, x):
    """Set each fall's mode to that of its elongation."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        x[modes + i] = 1.0 if min(fall.spring, fall.tension) > 0.0 else 0.0


@system.tensions.register(FallsCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all falls [N]."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for k in range(len(p.falls.offset)):
        fall = taut_fall(p.contact, fall_state(p.falls, k, *kinematics))
        rows[i, first + k] = x[modes + k] * fall.tension


@routine
def falls_energies(p, base, x):
    """Return the energies [J] of the crane, see `carrier_energies`."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    pose, _, load, (length, _) = kinematics
    total = carrier_energies(p, base, x, pose)
    total = linear.add(total, load_energies(base, load_of(p, x), load, p.gravity))
    for i in range(len(p.falls.offset)):
        spring, rest = fall_state(p.falls, i, *kinematics).spring, length + p.falls.offset[i]
        stored = x[modes + i] * 0.5 * spring * spring * rest / p.falls.axial_stiffness[i]
        total = linear.add(total, (0.0, stored, 0.0, 0.0))
    return total


@system.points.register(FallsCrane)
def write_points(p, t, x, out):
    """Write support and load in the world into out (N, 3)."""
    (_, first, _), base = layout_of(p), pose_at(p.base, t)
    i = write_polyline(posture_of(p, x), base, out)
    out[i, 0], out[i, 1], out[i, 2] = to_world(base, (x[first], x[first + 1], x[first + 2]))


@pressed_point.register(FallsCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    return pressed_point_of(load_of(p, x), body_state(p, x))


@routine
def falls_guard(p, best, x):
    """Return the smaller one of `best` and the guards of taut and slack falls."""
    (_, _, modes), kinematics = layout_of(p), kinematics_of(p, x)
    for i in range(len(p.falls.offset)):
        fall = fall_state(p.falls, i, *kinematics)
        value = fall.tension if x[modes + i] > 0.0 else -min(fall.spring, fall.tension)
        best = smaller_guard(best, value, encode(Guard.LINK, i))
    return best
