"""Functions of `crane_sim.system` shared by cranes whose load hangs by links, springs or falls.

They differ in what hangs between support and load: its energies, its forces, and guards that follow
from them.
"""

from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.models.carrier.dynamics import (
    mode_of_winch,
    support_limits_guard,
    winch_guard,
    winch_sticks,
)
from crane_sim.models.carrier.exchange import count_exchanges, exchange_guard
from crane_sim.models.carrier.layout import layout_of, rope_length, state_size, winch_index
from crane_sim.models.elastic import crane as elastic
from crane_sim.models.elastic.crane import (
    ElasticCrane,
    elastic_energies,
    initialize_link_modes,
    links_guard,
)
from crane_sim.models.energy_meter import Meter
from crane_sim.models.falls import crane as falls
from crane_sim.models.falls.contact_events import contact_guard, fill_contact, total_normal_force
from crane_sim.models.falls.crane import (
    FallsCrane,
    falls_energies,
    falls_guard,
    initialize_fall_modes,
)
from crane_sim.models.hanging.joints import accelerations_of_joints, joint_coordinates, write_joints
from crane_sim.models.moving_base import base_state
from crane_sim.models.supports.backlash import mean_of_drives
from crane_sim.models.supports.bridge import Bridge
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.hoist import (
    MotionHoist,
    PrescribedHoist,
    hoist_entry,
    hoist_modes,
    limit_hoist,
)
from crane_sim.models.supports.joint_modes import any_joint_sticks, initialize_modes, sticking_guard
from crane_sim.models.supports.reeved_hoist import ReevedHoist, hoist_falls, write_fall_tensions
from crane_sim.models.supports.support import own_count, polyline_size, read_state, takes_energy
from crane_sim.models.suspended import crane as suspended
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.suspended.outputs import suspended_energies, taut_guard, twist_guard
from crane_sim.models.wind_kink import kink_guard
from crane_sim.numerics.jit import routine

HANGING = SuspendedCrane, FallsCrane, ElasticCrane

system.kink_guard.register(*HANGING)(kink_guard)
system.contact_force.register(FallsCrane)(total_normal_force)


def solve(p, t, x, tau, work):
    """Return the solution of the equations at time t in state x under joint efforts tau.

    `work` is of `system.workspace`; that of a suspended crane has its tensions then.
    """
    if isinstance(p, FallsCrane):
        return falls.solve_dynamics(p, t, x, tau)
    if isinstance(p, ElasticCrane):
        return elastic.solve_dynamics(p, t, x, tau, np.empty(len(x)))
    return suspended.solve_dynamics(p, t, x, tau, work)


def energies(p, base, x):
    """Return the energies [J] of the crane, see `carrier_energies`."""
    if isinstance(p, FallsCrane):
        return falls_energies(p, base, x)
    if isinstance(p, ElasticCrane):
        return elastic_energies(p, base, x)
    return suspended_energies(p, base, x)


@system.kinetic.register(*HANGING)
def kinetic_energy(p, x):
    """Return the kinetic energy [J] relative to the base."""
    return energies(p, None, x)[0]


@system.potential.register(*HANGING)
def potential_energy(p, x):
    """Return the potential energy [J] relative to the base."""
    return energies(p, None, x)[1]


@system.base_energy.register(*HANGING)
def base_energies(p, t, x):
    """Return (kinetic, potential) energy [J] that the base's motion adds."""
    _, _, kinetic, potential = energies(p, base_state(p.base, t, 0.0), x)
    return kinetic, potential


@system.power.register(*HANGING)
def external_power(p, t, x, u):
    """Return the power [W] under a source of efforts."""
    solved = solve(p, t, x, system.effort(u, p, t, x), system.workspace(p))
    if isinstance(p, FallsCrane):
        return falls.falls_power(p, x, solved)
    if isinstance(p, ElasticCrane):
        return elastic.elastic_power(p, x, solved)
    return suspended.suspended_power(p, x, solved)


@system.energy_supplied.register(*HANGING)
def energy_supplied(p, x):
    """Return the meter's reading [J]."""
    return 0.0 if p.energy_meter is None else x[2 * layout_of(p)[0]]


@system.with_meter.register(*HANGING)
def with_meter(p, held):
    """Return the crane with a meter where work is done that samples of efforts do not show."""
    return p._replace(energy_meter=Meter()) if works_between_samples(p) or not held else p


def works_between_samples(p: Any) -> bool:
    """Return whether anything but efforts held at samples does work.

    These are motions, losses, forces and exchanges.
    """
    imposed = isinstance(p.hoist, PrescribedHoist | MotionHoist | ReevedHoist)
    imposed = imposed or moves_by_itself(p.support.structure) or hoist_modes(p.hoist) > 0
    damped = isinstance(p, FallsCrane) and bool(np.any(p.falls.relaxation))
    damped = damped or (isinstance(p, ElasticCrane) and bool(np.any(p.cable.damping)))
    others = (
        "drag",
        "force",
        "forces",
        "wind",
        "base",
        "exchange",
        "torsion",
        "contact",
        "swing_friction",
    )
    return (
        imposed
        or damped
        or takes_energy(p.support)
        or any(getattr(p, name, None) is not None for name in others)
    )


def moves_by_itself(structure: Any) -> bool:
    """Return whether a drive of a structure prescribes a motion."""
    return isinstance(structure, DrivenPoint) or (
        isinstance(structure, Bridge) and structure.moves_by_itself()
    )


@system.project.register(*HANGING)
def project(p, x):
    """Return the state, an array, projected in place."""
    system.project_in_place(p, x)
    return x


@system.link_count.register(*HANGING)
def count_links(p):
    """Return the number of links or falls."""
    return len(p.falls.offset) if isinstance(p, FallsCrane) else len(p.cable.masses)


@system.point_count.register(*HANGING)
def count_points(p):
    """Return the number of points of support and nodes, or load on falls."""
    return polyline_size(p.support) + (1 if isinstance(p, FallsCrane) else len(p.cable.masses))


@system.tip_index.register(*HANGING)
def tip_index(p):
    """Return the index of the support's tip among the points."""
    return polyline_size(p.support) - 1


@system.state.register(*HANGING)
def initial_state(p, t, q, v):
    """Return the state, an array, with the modes that follow from positions and velocities."""
    x = np.zeros(state_size(p))
    write_joints(p, x, q, v)
    count_exchanges(p, t, x)
    if isinstance(p, FallsCrane):
        initialize_fall_modes(p, x)
    if isinstance(p, ElasticCrane):
        initialize_link_modes(p, x)
    if hoist_modes(p.hoist) > 0:
        x[winch_index(p)] = np.sign(rope_length(p, x)[1])
    if isinstance(p, FallsCrane):
        fill_contact(p, t, x)
    initialize_modes(p.support, x, read_state(p.support, x, layout_of(p)[0]))
    return x


@system.joints.register(*HANGING)
def joint_arrays(p, x):
    """Return (q, v), arrays (nj,)."""
    return joint_coordinates(p, x)


@system.acceleration.register(*HANGING)
def joint_accelerations(p, t, x, u):
    """Return the second derivatives (nj,) of the joint coordinates."""
    return accelerations_of_joints(p, x, system.rhs(p, t, x, u))


@system.actuated_joints.register(*HANGING)
def actuated_joints(p, x):
    """Return positions and velocities of what takes an effort."""
    nq, _, _ = layout_of(p)
    return actuated_entries(p, x, 0), actuated_entries(p, x, nq)


def actuated_entries(p, x, i):
    """Return the coordinates or rates, which begin at x[i], of what takes an effort, as a tuple."""
    n = own_count(p.support)
    entries = mean_of_drives(p.support.drives, x, i, tuple(x[i + k] for k in range(n)), n)
    driven = tuple(entries[k] for k in p.support.structure.mechanism().actuated)
    return (*driven, *hoist_entry(p.hoist, x, i + layout_of(p)[1] - 1))


@system.efforts_from_row.register(*HANGING)
def efforts_from_row(p, row):
    """Return the efforts on support and hoist."""
    count = len(p.support.structure.mechanism().actuated)
    return (*[row[k] for k in range(count)], *hoist_entry(p.hoist, row, count))


@system.saturate.register(*HANGING)
def limit_efforts(p, u):
    """Return what the hoist can apply."""
    return limit_hoist(p.hoist, u)


@system.guard.register(*HANGING)
@routine
def smallest_guard(p, t, x, u, work):
    """Return (the smallest guard, its number, evaluations) of all that ends a step.

    Guards are of limits, exchanges, cable, friction and contact.
    """
    state, tau, pull = read_state(p.support, x, layout_of(p)[0]), system.effort(u, p, t, x), 0.0
    best = cable_guard(p, exchange_guard(p, support_limits_guard(p, x), t, x), x, work)
    forces = must_stay_taut(p) or winch_sticks(p, x) or any_joint_sticks(p.support, state)
    if forces:
        solved = solve(p, t, x, tau, work)
        pull = solved.paid
        best = sticking_guard(p.support, best, state, solved.support)
        if isinstance(p, SuspendedCrane):
            best = taut_guard(p, best, x, solved.length, work.tension)
    best, evaluations = winch_guard(p, best, x, tau, pull), int(forces)
    if isinstance(p, FallsCrane):
        value, number, more = contact_guard(p, t, x, best)
        best, evaluations = (value, number), evaluations + more
    return best[0], best[1], evaluations


def cable_guard(p, best, x, work):
    """Return the smaller one of `best` and the guards of the state: falls, links and twist."""
    if isinstance(p, FallsCrane):
        return falls_guard(p, best, x)
    return (
        links_guard(p, best, x)
        if isinstance(p, ElasticCrane)
        else twist_guard(p, best, x, work.links)
    )


def must_stay_taut(p):
    """Return whether a run ends where a rigid link goes slack."""
    return isinstance(p, SuspendedCrane) and p.stops is not None and p.stops.taut > 0.0


@system.fall_count.register(*HANGING)
def count_falls(p):
    """Return the number of falls of the hoist's reeving."""
    return hoist_falls(p.hoist)


@system.fall_tensions.register(*HANGING)
def write_tensions_of_falls(p, t, x, u, rows, i):
    """Write the tensions of lead line and falls [N], and the drum's torque [N m]."""
    tau = system.effort(u, p, t, x)
    solved = solve(p, t, x, tau, system.workspace(p))
    motion = (*rope_length(p, x), solved.length)
    write_fall_tensions(p.hoist, tau, mode_of_winch(p, x), motion, solved.paid, p.gravity, rows[i])
