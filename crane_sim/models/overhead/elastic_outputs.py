"""Outputs and events of the overhead crane with an elastic cable: initial state, energies, nodes, guards, resets."""

import numpy as np

from crane_sim import system
from crane_sim.models.guards import Guard, decode, encode, friction_event, smaller_guard
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.overhead import energies, layout_of, mode_of_stopped_axis, smallest_guard, switch
from crane_sim.models.overhead.base_load import to_world_in_place
from crane_sim.models.overhead.elastic import (
    ElasticCrane,
    base_load,
    elastic_layout,
    link,
    link_pull,
    mass_of,
    node_vector,
    tautness,
    write_elastic_derivative,
)
from crane_sim.models.overhead.modes import (
    count_modes,
    count_payload_changes,
    hoist_guard,
    limits_guard,
    make_switching,
    payload_guard,
)
from crane_sim.models.supports.friction import first_not_none, step_control_of
from crane_sim.models.supports.hoist import hoist_reflected_mass
from crane_sim.models.supports.rails import axis_guard, axis_mass, has_friction, input_count, mode_after_stop
from crane_sim.models.wind_kink import with_kink_switching
from crane_sim.numerics.jit import routine


@layout_of.register(ElasticCrane)
def _(p):
    nq, first, _, modes = elastic_layout(p)
    return nq, first, modes


@system.state.register(ElasticCrane)
def _(p, t, q, v):
    return initial_state(p, t, q, v)


@routine
def initial_state(p, t, q, v):
    """Return the state, with the modes that follow from positions and velocities."""
    nq, _, d, modes = elastic_layout(p)
    n = len(p.cable.masses)
    x = np.zeros(modes + count_modes(p.event_limits, d - 1 + n))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    if len(x) > modes:
        for axis in range(d - 1):
            x[modes + axis] = np.sign(v[axis])
        for k in range(n):
            x[modes + d - 1 + k] = 1.0 if p.cable.tension_only == 0.0 or strain(p, x, k) >= 0.0 else 0.0
        x[len(x) - 1] = count_payload_changes(p.event_limits, t)
    return x


@routine
def strain(p, x, k):
    """Return the smaller one of k e and k e + c e' [N] of link k: where it is positive, the link pulls."""
    _, _, stretch, rate = link(p, x, k)
    spring = p.cable.stiffness[k] * stretch
    return spring + min(0.0, p.cable.damping[k] * rate)


@energies.register(ElasticCrane)
def _(p, x):  # a slack link stores nothing
    nq, first, d, modes = elastic_layout(p)
    kinetic, potential = 0.5 * axis_mass(p.trolley) * x[nq] ** 2, 0.0
    if d == 3:
        kinetic += 0.5 * axis_mass(p.bridge) * x[nq + 1] ** 2
    if first == d:
        kinetic += 0.5 * hoist_reflected_mass(p.hoist) * x[nq + first - 1] ** 2
    for k in range(len(p.cable.masses)):
        mass, (vx, vy, vz) = mass_of(p, x, k + 1), node_vector(p, x, k + 1, 1)
        _, _, stretch, _ = link(p, x, k)
        taut = tautness(p.event_limits, x, modes + d - 1 + k)
        kinetic += 0.5 * mass * (vx * vx + vy * vy + vz * vz)
        potential += mass * p.gravity * node_vector(p, x, k + 1, 0)[2]
        potential += 0.5 * taut * p.cable.stiffness[k] * stretch * stretch
    return kinetic, potential


@system.tensions.register(ElasticCrane)
def _(p, t, x, u, rows, i, first):
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = link_pull(p, x, k)[1]


@system.power.register(ElasticCrane)
def _(p, t, x, u):
    return write_elastic_derivative(p, t, x, system.effort(u, p, t, x), np.empty(len(x)))


@system.points.register(ElasticCrane)
def _(p, t, x, out):
    for k in range(1 + len(p.cable.masses)):
        out[k, 0], out[k, 1], out[k, 2] = node_vector(p, x, k, 0)
    to_world_in_place(p.base, t, out)


@system.switching.register(ElasticCrane)
def _(p):
    forces = (
        has_friction(p.trolley)
        or has_friction(p.bridge)
        or (p.cable.tension_only > 0.0 and has_damper(p.cable.damping))
    )
    step_control = first_not_none(step_control_of(p.trolley), step_control_of(p.bridge))
    return with_kink_switching(p.wind, make_switching(p.event_limits, forces, elastic_layout(p)[0], step_control))


def has_damper(damping):
    """Return whether a link has a damper: then whether it pulls depends on its rate too."""
    damped = False
    for c in damping:
        damped = damped or c > 0.0
    return damped


@smallest_guard.register(ElasticCrane)
def _(p, t, x, tau, work):
    nq, first, d, modes = elastic_layout(p)
    ((nx, ny, _), tension, _), load = link_pull(p, x, 0), base_load(base_kinematics_at(p.base, p.gravity, t), p, x)
    best = (axis_guard(p.trolley, x[nq], x[modes], tau, 0, tension * nx + load.x), encode(Guard.FRICTION, 0))
    best = limits_guard(p.event_limits, best, 0, x[0])
    if d == 3:
        bridge = axis_guard(p.bridge, x[nq + 1], x[modes + 1], tau, input_count(p.trolley), tension * ny + load.y)
        best = limits_guard(p.event_limits, smaller_guard(best, bridge, encode(Guard.FRICTION, 1)), 1, x[1])
    if first == d:
        best = hoist_guard(p.event_limits, best, x[first - 1])
    best = payload_guard(p.event_limits, best, t, x[len(x) - 1])
    if p.cable.tension_only > 0.0:
        for k in range(len(p.cable.masses)):
            best = smaller_guard(best, link_guard(p, x, k, x[modes + d - 1 + k]), encode(Guard.LINK, k))
    value, number = best
    return value, number, 0


def link_guard(p, x, k, taut):
    """Return the guard [N] of a link that only pulls: a slack one pulls where both its e and its k e + c e' are > 0."""
    _, _, stretch, rate = link(p, x, k)
    spring, total = p.cable.stiffness[k] * stretch, p.cable.stiffness[k] * stretch + p.cable.damping[k] * rate
    return total if taut > 0.0 else -min(spring, total)


@mode_of_stopped_axis.register(ElasticCrane)
def _(p, t, x, tau, axis, mode):
    (n, tension, _), load = link_pull(p, x, 0), base_load(base_kinematics_at(p.base, p.gravity, t), p, x)
    if axis == 0:  # not one call with either axis: they may be of different types, and the type chooses the body
        return mode_after_stop(p.trolley, mode, tau, 0, tension * n[0] + load.x)
    return mode_after_stop(p.bridge, mode, tau, input_count(p.trolley), tension * n[1] + load.y)


@switch.register(ElasticCrane)
def _(p, t, x, tau, number):
    nq, _, d, modes = elastic_layout(p)
    kind, index, _ = decode(number)
    x, event = x.copy(), number
    before = sum(energies(p, x))
    if kind == Guard.LINK:
        mode = modes + d - 1 + index
        x[mode] = 1.0 - x[mode]
        event = encode(Guard.LINK, index, int(x[mode]))
    elif kind == Guard.PAYLOAD:
        x[len(x) - 1] += 1.0
    elif kind == Guard.FRICTION:
        mode_before = x[modes + index]
        x[nq + index], x[modes + index] = (0.0 if mode_before != 0.0 else x[nq + index]), 0.0
        x[modes + index] = mode_of_stopped_axis(p, t, x, tau, index, mode_before)
        event = friction_event(index, x[modes + index])
    else:
        return x, number, False
    x[2 * nq] += sum(energies(p, x)) - before  # the payload takes its energy along, a slack spring what was left in it
    return x, event, True
