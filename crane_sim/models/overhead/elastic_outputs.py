"""Outputs and events of the overhead crane with an elastic cable: initial state, energies, nodes, guards, resets."""

import numpy as np

from crane_sim import system
from crane_sim.models.guards import TAUT, Guard, decode, encode, friction_event, smaller_guard
from crane_sim.models.moving_base import base_kinematics_at
from crane_sim.models.overhead import count_axes, first_link, layout_of
from crane_sim.models.overhead.base_load import axes_load, to_world_in_place
from crane_sim.models.overhead.elastic import (
    ElasticCrane,
    elastic_layout,
    link,
    link_pull,
    mass_of,
    node_vector,
    tautness,
    write_elastic_derivative,
)
from crane_sim.models.overhead.events import mode_of_stopped_drive, smallest_drive_guard, switching_of
from crane_sim.models.overhead.modes import count_modes, count_payload_changes, describe_switch
from crane_sim.models.supports.hoist import hoist_reflected_mass
from crane_sim.models.supports.rails import axis_mass
from crane_sim.numerics.jit import routine


@system.state.register(ElasticCrane)
@routine
def initial_state(p, t, q, v):
    """Return the state, with the modes that follow from positions and velocities."""
    (nq, _, modes), axes, n = layout_of(p), count_axes(p), len(p.cable.masses)
    x = np.zeros(modes + count_modes(p.event_limits, axes + n))
    for i in range(nq):
        x[i], x[nq + i] = q[i], v[i]
    if len(x) > modes:
        for axis in range(axes):
            x[modes + axis] = np.sign(v[axis])
        for k in range(n):
            x[modes + axes + k] = 1.0 if p.cable.tension_only == 0.0 or strain(p, x, k) >= 0.0 else 0.0
        x[len(x) - 1] = count_payload_changes(p.event_limits, t)
    return x


@routine
def strain(p, x, k):
    """Return the smaller one of k e and k e + c e' [N] of link k: where it is positive, the link pulls."""
    _, _, stretch, rate = link(p, x, k)
    spring = p.cable.stiffness[k] * stretch
    return spring + min(0.0, p.cable.damping[k] * rate)


@system.kinetic.register(ElasticCrane)
@routine
def kinetic_energy(p, x):
    """Return the kinetic energy [J] of axes, hoist and nodes."""
    nq, first, _ = layout_of(p)
    kinetic = 0.5 * axis_mass(p.trolley) * x[nq] ** 2
    if p.bridge is not None:
        kinetic += 0.5 * axis_mass(p.bridge) * x[nq + 1] ** 2
    if p.hoist is not None:
        kinetic += 0.5 * hoist_reflected_mass(p.hoist) * x[nq + first - 1] ** 2
    for k in range(len(p.cable.masses)):
        vx, vy, vz = node_vector(p, x, k + 1, 1)
        kinetic += 0.5 * mass_of(p, x, k + 1) * (vx * vx + vy * vy + vz * vz)
    return kinetic


@system.potential.register(ElasticCrane)
@routine
def potential_energy(p, x):
    """Return the potential energy [J] of nodes and springs; a slack link stores nothing."""
    _, _, modes = layout_of(p)
    potential = 0.0
    for k in range(len(p.cable.masses)):
        _, _, stretch, _ = link(p, x, k)
        taut = tautness(p.event_limits, x, modes + count_axes(p) + k)
        potential += mass_of(p, x, k + 1) * p.gravity * node_vector(p, x, k + 1, 0)[2]
        potential += 0.5 * taut * p.cable.stiffness[k] * stretch * stretch
    return potential


@system.tensions.register(ElasticCrane)
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = link_pull(p, x, k)[1]


@system.power.register(ElasticCrane)
def external_power(p, t, x, u):
    """Return the power [W] under a source of efforts."""
    return write_elastic_derivative(p, t, x, system.effort(u, p, t, x), np.empty(len(x)))


@system.points.register(ElasticCrane)
def write_points(p, t, x, out):
    """Write trolley and nodes."""
    for k in range(1 + len(p.cable.masses)):
        out[k, 0], out[k, 1], out[k, 2] = node_vector(p, x, k, 0)
    to_world_in_place(p.base, t, out)


@system.switching.register(ElasticCrane)
def switching(p):
    """Return how the equations switch: a link with a damper that only pulls is a guard that depends on forces."""
    return switching_of(p, p.cable.tension_only > 0.0 and has_damper(p.cable.damping))


def has_damper(damping):
    """Return whether a link has a damper: then whether it pulls depends on its rate too."""
    damped = False
    for c in damping:
        damped = damped or c > 0.0
    return damped


def top_forces(p, t, x):
    """Return (tension of the first link, pulls of it and of a moving base on the axes) [N]."""
    (n, tension, _), load = link_pull(p, x, 0), axes_load(base_kinematics_at(p.base, p.gravity, t), p, x)
    return tension, (tension * n[0] + load.x, tension * n[1] + load.y)


@system.guard.register(ElasticCrane)
@routine
def smallest_guard(p, t, x, u, work):
    """Return the smallest guard, of drives, payload and links that only pull."""
    _, _, modes = layout_of(p)
    length = None if p.hoist is None else first_link(p, x)[0]
    best = smallest_drive_guard(p, t, x, system.effort(u, p, t, x), *top_forces(p, t, x), length)
    if p.cable.tension_only > 0.0:
        for k in range(len(p.cable.masses)):
            guard = link_guard(p, x, k, x[modes + count_axes(p) + k])
            best = smaller_guard(best, guard, encode(Guard.LINK, k))
    value, number = best
    return value, number, 0


def link_guard(p, x, k, taut):
    """Return the guard [N] of a link that only pulls: a slack one pulls where both its e and its k e + c e' are > 0."""
    _, _, stretch, rate = link(p, x, k)
    spring, total = p.cable.stiffness[k] * stretch, p.cable.stiffness[k] * stretch + p.cable.damping[k] * rate
    return total if taut > 0.0 else -min(spring, total)


@system.apply_reset_map.register(ElasticCrane)
@routine
def switch(p, t, x, u, number):
    """Return the state after a link has become slack or taut, a change of the payload or of an axis' friction."""
    nq, _, d, modes = elastic_layout(p)
    kind, index, _ = decode(number)
    tau, x, event = system.effort(u, p, t, x), x.copy(), number
    before = system.kinetic(p, x) + system.potential(p, x)
    if kind == Guard.LINK:
        mode = modes + d - 1 + index
        x[mode] = 1.0 - x[mode]
        event = encode(Guard.LINK, index, int(x[mode]))
    elif kind == Guard.PAYLOAD:
        x[len(x) - 1] += 1.0
    elif kind == Guard.FRICTION:
        mode_before = x[modes + index]
        x[nq + index], x[modes + index] = (0.0 if mode_before != 0.0 else x[nq + index]), 0.0
        x[modes + index] = mode_of_stopped_drive(p, index, mode_before, tau, *top_forces(p, t, x))
        event = friction_event(index, x[modes + index])
    else:
        return x, number, False
    gained = system.kinetic(p, x) + system.potential(p, x) - before
    x[2 * nq] += gained  # the payload takes its energy along, a slack spring what was left in it
    return x, event, True


@system.describe_event.register(ElasticCrane)
def describe_event(p, number):
    """Return texts on an event: a link that goes slack does not end the run."""
    kind, link_index, outcome = decode(number)
    if kind == Guard.LINK:
        return f"link {link_index + 1} {'pulls' if outcome == TAUT else 'went slack'}", ""
    return describe_switch(p, number)
