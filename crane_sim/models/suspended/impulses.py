"""The impact of an exchange of the load on the whole crane.

The load and what it takes up are one body first (`exchange.join`), whose attachment has another
velocity than the cable's end. Then impulses along the rigid links bring both together. They solve
the same system as the tensions do, with jumps of velocities in place of accelerations: inverse
masses of nodes, winch and attachment and the mobility of the tip are the same, and nothing else
acts in no time. A winch that imposes its motion keeps its rate, a massless one transmits no
impulse.

The last link's impulse takes half of its product with the jump of relative velocity along the link
as energy (Carnot).
"""

from math import sqrt

import numpy as np

from crane_sim import system
from crane_sim.models.cables.chain_3d import (
    SupportEnd,
    direction_accelerations,
    hoisted_length_acceleration,
    row_of,
    solve_tensions,
)
from crane_sim.models.carrier.exchange import DONE, carried_energy, join, load_of, vector_at
from crane_sim.models.carrier.layout import exchange_index, layout_of, rope_length
from crane_sim.models.guards import Guard, encode
from crane_sim.models.loads import RigidLoad, end_acceleration_across, end_mobility, load_state
from crane_sim.models.moving_base import rotate_to_base
from crane_sim.models.supports.hoist import hoist_response
from crane_sim.models.supports.joint_modes import reset_friction_modes
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.support import (
    bare_tip,
    compute_posture,
    coordinate_count,
    friction_state_count,
    read_state,
    tip_rate,
)
from crane_sim.models.supports.support_dynamics import (
    compute_dynamics,
    prescribed_power,
    responses,
    tip_efforts,
)
from crane_sim.models.suspended.crane import fill_directions, next_node
from crane_sim.multibody import linear
from crane_sim.multibody.attitude import quaternion_rate
from crane_sim.multibody.tree import to_tree_axes
from crane_sim.multibody.vectors import add, cross, dot, multiply, scale, subtract
from crane_sim.numerics.jit import routine

# of momentum: an impulse of the cable that is zero up to this does not count as pushing
ROUNDING = 1e-12


@routine
def apply_exchange(p, t, x):
    """Return (the state after the next exchange, its event, whether the run goes on)."""
    nq, _, modes = layout_of(p)
    y, mode = x.copy(), exchange_index(p)
    k = int(x[mode])
    y[mode] += 1.0
    before, after, end = load_of(p, x), load_of(p, y), lower_end(p, x)
    state, new_state = load_state(before, x, nq, end), load_state(after, x, nq, end)
    weight, new_weight = p.gravity * before.mass, p.gravity * after.mass
    gained, least = new_weight * new_state.position[2] - weight * state.position[2], 0.0
    if p.exchange.carried[k] > 0.0:
        gained += carried_energy(before, after, state)
    else:
        joined = join(before, after, state, vector_at(p.exchange.velocities, k, 0))
        lost, least = add_jumps(p, after, x, y, state, joined)
        reset_friction_modes(p.support, y, read_state(p.support, y, nq))
        gained += joined.energy - lost
        least += ROUNDING * after.mass * sqrt(dot(joined.jump, joined.jump))
    if modes > 2 * nq:
        y[2 * nq] += gained
    allowed = p.stops.taut == 0.0 or least >= 0.0
    return y, encode(Guard.PAYLOAD, k, DONE), allowed


def lower_end(p, x):
    """Return (position, velocity) of the cable's lower end in state x, relative to the base."""
    nq, _, _ = layout_of(p)
    links, (_, rate) = system.workspace(p).links, rope_length(p, x)
    fill_directions(p, x, links)
    node = bare_tip(compute_posture(p.support, read_state(p.support, x, nq)))
    for k in range(len(links.squared_rates)):
        node = next_node(links, k, rate, node)
        rate = 0.0
    return node


def posture_at_rest(support, x, nq):
    """Return the posture of the support in state x without velocities.

    Its joints are free: dry friction, whose forces are finite, holds none against an impulse.
    """
    still = x.copy()
    still[nq : 2 * nq] = 0.0
    still[len(x) - friction_state_count(support) :] = 1.0
    return compute_posture(support, read_state(support, still, nq))


@routine
def add_jumps(p, load, x, y, state, joined):
    """Add the jumps of all velocities to state y, by the impulses that join cable and load.

    Args:
        p, load: the crane and its new load.
        x, y: state before, and its copy.
        state: kinematics of the load before.
        joined: `Joined`.

    Returns:
        energy [J] that the impulses take, smallest impulse [N s].
    """
    (nq, first, _), ns = layout_of(p), coordinate_count(p.support)
    links, acc, impulse, ratio = system.workspace(p)
    fill_directions(p, x, links)
    links.squared_rates[:], acc[:], n = 0.0, 0.0, len(impulse)
    acc[n, 0], acc[n, 1], acc[n, 2] = joined.jump
    last, upper = row_of(links.units, n - 1), row_of(links.units, 0)
    links.inv_masses[n - 1] = end_mobility(load, state, last)
    pose, nothing = posture_at_rest(p.support, x, nq), (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    winch = 0.0
    if not isinstance(p.hoist, ReevedHoist):
        winch, _ = hoist_response(p.hoist, 0.0, nothing, 1.0, (0.0, x[nq + ns]), p.gravity)
    levers = tip_efforts(pose, to_tree_axes(pose.kinematics.turn, upper))
    dynamics = compute_dynamics(p.support, pose)
    answer = responses(dynamics, levers)
    top = SupportEnd(linear.inner(levers, answer), winch, 0.0, 0.0)
    solve_tensions(links, top, acc, impulse, ratio)
    lost = 0.5 * impulse[n - 1] * dot(last, joined.jump)
    if first > ns:
        y[nq + ns] += hoisted_length_acceleration(links, top, acc, impulse)
        lost += impulse[0] * x[nq + ns] if winch == 0.0 else 0.0
    moving, jumps = (
        compute_posture(p.support, read_state(p.support, x, nq)),
        linear.scale(impulse[0], answer),
    )
    lost += prescribed_power(moving, dynamics, linear.scale(impulse[0], levers), jumps)
    for i, rate in enumerate(answer):
        # a drive's body behind a spring is not
        reached = abs(rate) * dynamics.matrix[i][i] > ROUNDING * abs(levers[i])
        y[nq + i] += impulse[0] * rate if reached else 0.0
    acc[0, 0], acc[0, 1], acc[0, 2] = scale(impulse[0], tip_rate(pose, answer))
    across = end_acceleration_across(load, state, last, impulse[n - 1])
    acc[n, 0], acc[n, 1], acc[n, 2] = add(row_of(acc, n), across)
    rates = np.empty(3 * n)
    direction_accelerations(links, top, acc, impulse, rates, 0)
    for i in range(3 * n):
        y[nq + first + i] += rates[i]
    if isinstance(load, RigidLoad):
        write_spin(load, state, (last, impulse[n - 1]), joined.omega, y, nq)
    return lost, impulse.min()


def write_spin(load, state, pull, omega, y, nq):
    """Write the rates of a rigid load's own coordinates, after a link's impulse.

    They are of omega [rad/s] and `pull`, (direction, impulse) of the link.
    """
    n, impulse = pull
    turn = multiply(load.inverse_inertia, cross(load.attachment, rotate_to_base(state.rows, n)))
    i = 2 * nq - 4
    y[i], y[i + 1], y[i + 2], y[i + 3] = quaternion_rate(
        state.quaternion, subtract(omega, scale(impulse, turn))
    )
