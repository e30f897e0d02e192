"""Outputs of a crane with an elastic cable: joint coordinates, energies, tensions and points; its events."""

import numpy as np

from crane_sim import system
from crane_sim.models.elastic.crane import (
    ElasticCrane,
    first_stretch,
    further_stretch,
    node_at,
    payload_state,
    pull_of,
    solve_dynamics,
    tautness,
    tip_of,
)
from crane_sim.models.falls.outputs import joint_accelerations, joint_arrays, stops_guard
from crane_sim.models.guards import TAUT, Guard, decode, encode, smaller_guard
from crane_sim.models.moving_base import pose_at, to_world
from crane_sim.models.supports.hoist import hoist_modes, hoist_reflected_mass
from crane_sim.models.supports.joint_modes import any_joint_sticks, initialize_modes, sticking_guard
from crane_sim.models.supports.reeved_hoist import winch_energy
from crane_sim.models.supports.support import (
    compute_posture,
    drive_count,
    friction_state_count,
    polyline_size,
    read_state,
)
from crane_sim.models.suspended import outputs as suspended_outputs
from crane_sim.models.suspended.exchange import DONE, carried_energy, count_exchanges, exchange_guard, join, load_of
from crane_sim.models.suspended.exchange import vector_at as row_at
from crane_sim.models.suspended.joints import fill_coordinates
from crane_sim.models.suspended.layout import contact_index, exchange_index, layout_of, rope_length, winch_index
from crane_sim.models.suspended.load_dynamics import kinetic_energy as load_kinetic_energy
from crane_sim.models.suspended.load_dynamics import load_base_energy
from crane_sim.models.suspended.outputs import (
    mass_added_energy,
    support_added_energy,
    support_energies,
    write_polyline,
)
from crane_sim.models.suspended.winch import smallest_winch_guard
from crane_sim.models.wind_kink import pressed_point
from crane_sim.multibody.vectors import dot
from crane_sim.numerics.jit import routine

system.joints.register(ElasticCrane)(joint_arrays)
system.acceleration.register(ElasticCrane)(joint_accelerations)


@system.state.register(ElasticCrane)
def initial_state(p, t, q, v):
    """Return the state, an array, with the modes that follow from positions and velocities."""
    nq, _, _ = layout_of(p)
    x = np.zeros(contact_index(p) + drive_count(p.support) + friction_state_count(p.support))
    fill_coordinates(p, x, q, v)
    count_exchanges(p, t, x)
    initialize_link_modes(p, x)
    if hoist_modes(p.hoist) > 0:
        x[winch_index(p)] = np.sign(rope_length(p, x)[1])
    initialize_modes(p.support, x, read_state(p.support, x, nq))
    return x


@routine
def initialize_link_modes(p, x):
    """Set the modes of links that go slack to those of their elongations."""
    if p.cable.slack is None:
        return
    (_, _, modes), tip = layout_of(p), tip_of(p, x)
    for k in range(len(p.cable.masses)):
        x[modes + k] = 1.0 if min(*link_forces(p, x, k, tip)) >= 0.0 else 0.0


def stretch_at(p, x, k, tip):
    """Return the result of `stretch_of` for link k, from 0."""
    return first_stretch(p, x, tip) if k == 0 else further_stretch(p, x, k)


def link_forces(p, x, k, tip):
    """Return (k e, k e + c e') [N] of link k: where it is taut it pulls by the second one."""
    _, stretch, rate = stretch_at(p, x, k, tip)
    spring = p.cable.stiffness[k] * stretch
    return spring, spring + p.cable.damping[k] * rate


def mass_at(p, x, k):
    """Return the mass [kg] of node k, from 1."""
    return p.cable.masses[k - 1] if k < len(p.cable.masses) else load_of(p, x).mass


@routine
def elastic_energies(p, base, x):
    """Return (kinetic, potential) energy [J] relative to the base, and those that it adds; base: BaseState or None."""
    (nq, _, _), (length, rate), n = layout_of(p), rope_length(p, x), len(p.cable.masses)
    pose, body = compute_posture(p.support, read_state(p.support, x, nq)), load_of(p, x)
    (moving, sprung), tip = support_energies(p.support, pose, p.gravity), tip_of(p, x)
    wound, hung = winch_energy(p.hoist, length, rate, p.gravity)
    kinetic = moving + 0.5 * hoist_reflected_mass(p.hoist) * rate * rate + wound
    potential, added = sprung + hung, support_added_energy(base, pose, p.gravity)
    for k in range(n):
        _, stretch, _ = stretch_at(p, x, k, tip)
        potential += 0.5 * tautness(p, x, k) * p.cable.stiffness[k] * stretch * stretch
    for k in range(1, n):
        mass, node = p.cable.masses[k - 1], node_at(p, x, k)
        kinetic += 0.5 * mass * dot(node[1], node[1])
        potential += mass * p.gravity * node[0][2]
        more = mass_added_energy(base, p.gravity, mass, node)
        added = added[0] + more[0], added[1] + more[1]
    load = payload_state(p, x)
    more = load_base_energy(base, body, load, p.gravity)
    kinetic += load_kinetic_energy(body, load)
    potential += body.mass * p.gravity * load.position[2]
    return kinetic, potential, added[0] + more[0], added[1] + more[1]


@system.link_count.register(ElasticCrane)
def count_links(p):
    """Return the number of links."""
    return len(p.cable.masses)


@system.tensions.register(ElasticCrane)
@routine
def write_tensions(p, t, x, u, rows, i, first):
    """Write the tensions of all links [N]."""
    tip = tip_of(p, x)
    for k in range(len(p.cable.masses)):
        rows[i, first + k] = pull_of(p, x, k, stretch_at(p, x, k, tip)).tension


@system.point_count.register(ElasticCrane)
def count_points(p):
    """Return the number of points of support and nodes."""
    return polyline_size(p.support) + len(p.cable.masses)


@system.points.register(ElasticCrane)
@routine
def write_points(p, t, x, out):
    """Write support and nodes in the world into out (N, 3)."""
    (nq, _, _), base = layout_of(p), pose_at(p.base, t)
    i = write_polyline(compute_posture(p.support, read_state(p.support, x, nq)), base, out)
    for k in range(len(p.cable.masses)):
        out[i + k, 0], out[i + k, 1], out[i + k, 2] = to_world(base, node_at(p, x, k + 1)[0])


@pressed_point.register(ElasticCrane)
def pressed_point_of_load(p, x):
    """Return where the wind presses on the load in state x (3,) [m], in the axes of the base."""
    return payload_state(p, x).position


@system.guard.register(ElasticCrane)
@routine
def smallest_guard(p, t, x, u, work):
    """Return (the smallest guard, its number, evaluations): limits, exchanges, links that only pull, friction."""
    best, tip = links_guard(p, x, exchange_guard(p, stops_guard(p, x), t, x)), tip_of(p, x)
    state, tau, sticks = read_state(p.support, x, layout_of(p)[0]), system.effort(u, p, t, x), False
    sticks = any_joint_sticks(p.support, state)
    if sticks:
        solved = solve_dynamics(p, t, x, tau, np.empty(len(x)))
        best = sticking_guard(p.support, best, solved.pose.state, solved)
    pull = pull_of(p, x, 0, first_stretch(p, x, tip)).tension
    value, number = smallest_winch_guard(p, best, x, tau, pull)
    return value, number, int(sticks)


def links_guard(p, x, best):
    """Return the smaller one of `best` and the guards [N] of links that only pull.

    A slack one pulls where both its e and its k e + c e' are > 0.
    """
    if p.cable.slack is None:
        return best
    tip = tip_of(p, x)
    for k in range(len(p.cable.masses)):
        spring, total = link_forces(p, x, k, tip)
        value = total if tautness(p, x, k) > 0.0 else -min(spring, total)
        best = smaller_guard(best, value, encode(Guard.LINK, k))
    return best


def switch(p, t, x, number):
    """Return (state after an event of load or links, the event, whether the run goes on)."""
    kind, _, _ = decode(number)
    if p.exchange is not None and kind == Guard.PAYLOAD:
        return apply_exchange(p, x)
    return switch_link(p, x, number)


@routine
def switch_link(p, x, number):
    """Return (the state with a link's other mode, the event, whether the run goes on)."""
    (nq, _, modes), (kind, i, _) = layout_of(p), decode(number)
    if p.cable.slack is None or kind != Guard.LINK:
        return x, number, False
    y = x.copy()
    y[modes + i] = 1.0 - x[modes + i]
    if modes > 2 * nq:  # a slack link loses what its spring held against the damper
        y[2 * nq] += elastic_energies(p, None, y)[1] - elastic_energies(p, None, x)[1]
    return y, encode(Guard.LINK, i, int(y[modes + i])), True


@routine
def apply_exchange(p, x):
    """Return (state after the next exchange, its event, whether the run goes on): springs transmit no impulse."""
    (nq, _, modes), mode, d = layout_of(p), exchange_index(p), p.dimensions()
    k, y = int(x[mode]), x.copy()
    y[mode] += 1.0
    before, after, state = load_of(p, x), load_of(p, y), payload_state(p, x)
    energy = carried_energy(before, after, state)
    if p.exchange.carried[k] == 0.0:
        joined, i = join(before, after, state, row_at(p.exchange.velocities, k, 0)), 2 * nq - d
        energy = joined.energy
        y[i] += joined.jump[0]
        if d == 3:
            y[i + 1] += joined.jump[1]
        y[i + d - 1] += joined.jump[2]
    if modes > 2 * nq:
        y[2 * nq] += energy + p.gravity * (after.mass - before.mass) * state.position[2]
    return y, encode(Guard.PAYLOAD, k, DONE), True


@system.describe_event.register(ElasticCrane)
def describe_event(p, number):
    """Return texts on an event: a link that goes slack does not end the run."""
    kind, link, outcome = decode(number)
    if kind == Guard.LINK:
        return f"link {link + 1} {'pulls' if outcome == TAUT else 'went slack'}", ""
    return suspended_outputs.describe_event(p, number)
