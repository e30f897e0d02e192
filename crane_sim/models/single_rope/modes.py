"""Terminal guards of a crane with one rope: functions of positions alone, unless the rope must stay taut."""

from crane_sim import system
from crane_sim.models.cables.rope import rope_kinematics
from crane_sim.models.guards import LOWER, UPPER, Guard, encode, smaller_guard
from crane_sim.models.single_rope.crane import Crane, solve_motion
from crane_sim.models.stops import Stops, describe_stop, switching_of
from crane_sim.models.supports import forward_kinematics, support_guard
from crane_sim.numerics.jit import lean_routine


@system.switching.register(Crane)
def _(p):
    return switching_of(p.stops)


@system.guard.register(Crane)
def _(p, t, x, u, work):
    return smallest_guard(p, t, x, u)


@lean_routine
def smallest_guard(p, t, x, u):
    """Return (the smallest guard, its number, evaluations)."""
    stops, forces = p.stops, p.stops.taut > 0.0
    rope_state = rope_kinematics(forward_kinematics(p.support, x[0]), x[1])
    margin = rope_state.length + stops.lead * min(rope_state.rate, 0.0) - stops.shortest
    best = margin, encode(Guard.LENGTH, LOWER)
    best = smaller_guard(best, stops.longest - rope_state.length, encode(Guard.LENGTH, UPPER))
    best = support_guard(p.support, best, x[0])
    if forces:
        tension = solve_motion(p, t, x[0], x[1], system.effort(u, p, t, x)).tension
        best = smaller_guard(best, tension, encode(Guard.LINK, 0))
    value, number = best
    return value, number, int(forces)


@system.apply_reset_map.register(Crane)
def _(p, t, x, u, number):
    return x, number, False


@system.describe_event.register(Crane)
def _(p, number):
    return describe_stop(p.support, p.stops or Stops(), number)
