"""Functions of `crane_sim.system` that suspended cranes and those with elastic falls share: support, hoist and a load.

The two differ in what hangs between support and load: its energies, its forces, and guards that follow from them.
"""

from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.models.elastic import crane as elastic
from crane_sim.models.elastic import outputs as elastic_outputs
from crane_sim.models.elastic.crane import ElasticCrane
from crane_sim.models.energy_meter import Meter
from crane_sim.models.falls import crane as falls
from crane_sim.models.falls import outputs as falls_outputs
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.guards import Guard, decode, friction_event
from crane_sim.models.moving_base import base_state
from crane_sim.models.stops import WINCH, make_switching
from crane_sim.models.supports.backlash import mean_of_drives
from crane_sim.models.supports.bridge import Bridge
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.friction import friction_of, step_control_of
from crane_sim.models.supports.hoist import MotionHoist, PrescribedHoist, hoist_entry, hoist_modes, limit_hoist
from crane_sim.models.supports.joint_modes import (
    friction_state_index,
    mode_after_guard,
    switch_drive,
    with_support_switching,
)
from crane_sim.models.supports.reeved_hoist import ReevedHoist, mode_of_stopped_winch
from crane_sim.models.supports.reeving_outputs import hoist_falls, write_fall_tensions
from crane_sim.models.supports.support import own_count, polyline_size, read_state, takes_energy
from crane_sim.models.suspended import crane as suspended
from crane_sim.models.suspended import impulses
from crane_sim.models.suspended import outputs as suspended_outputs
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.suspended.exchange import with_exchange_switching
from crane_sim.models.suspended.layout import layout_of, rope_length, winch_index
from crane_sim.models.suspended.winch import mode_of_winch
from crane_sim.models.wind_kink import kink_guard, with_kink_switching
from crane_sim.numerics.jit import routine
from crane_sim.system import EVENT_LOG_CAPACITY, Switching

HANGING = SuspendedCrane, FallsCrane, ElasticCrane

system.kink_guard.register(*HANGING)(kink_guard)


def solve(p, t, x, tau):
    """Return the solution of the equations at time t in state x under joint efforts tau."""
    if isinstance(p, FallsCrane):
        return falls.solve_dynamics(p, t, x, tau)
    if isinstance(p, ElasticCrane):
        return elastic.solve_dynamics(p, t, x, tau, np.empty(len(x)))
    return suspended.solve_dynamics(p, t, x, tau, system.workspace(p))


def energies(p, base, x):
    """Return (kinetic, potential) energy [J] relative to the base, and those that it adds; base: BaseState or None."""
    if isinstance(p, FallsCrane):
        return falls_outputs.falls_energies(p, base, x)
    if isinstance(p, ElasticCrane):
        return elastic_outputs.elastic_energies(p, base, x)
    return suspended_outputs.suspended_energies(p, base, x)


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
    solved = solve(p, t, x, system.effort(u, p, t, x))
    if isinstance(p, ElasticCrane):
        return elastic.elastic_power(p, x, solved)
    return falls.falls_power(p, x, solved) if isinstance(p, FallsCrane) else suspended.suspended_power(p, x, solved)


@system.energy_supplied.register(*HANGING)
def energy_supplied(p, x):
    """Return the meter's reading [J]."""
    return 0.0 if p.energy_meter is None else x[2 * layout_of(p)[0]]


@system.with_meter.register(*HANGING)
def with_meter(p, held):
    """Return the crane with a meter where work is done that samples of efforts do not show."""
    return p._replace(energy_meter=Meter()) if works_between_samples(p) or not held else p


def works_between_samples(p: Any) -> bool:
    """Return whether work is done besides that of held efforts at samples: by motions, losses, forces and exchanges."""
    imposed = isinstance(p.hoist, PrescribedHoist | MotionHoist | ReevedHoist)
    imposed = imposed or moves_by_itself(p.support.structure) or hoist_modes(p.hoist) > 0
    damped = isinstance(p, FallsCrane) and bool(np.any(p.falls.relaxation))
    damped = damped or (isinstance(p, ElasticCrane) and bool(np.any(p.cable.damping)))
    others = ("drag", "force", "forces", "wind", "base", "exchange", "torsion", "contact", "swing_friction")
    return imposed or damped or takes_energy(p.support) or any(getattr(p, name, None) is not None for name in others)


def moves_by_itself(structure: Any) -> bool:
    """Return whether a drive of a structure prescribes a motion."""
    return isinstance(structure, DrivenPoint) or (isinstance(structure, Bridge) and structure.moves_by_itself())


@system.project.register(*HANGING)
def project(p, x):
    """Return the state, an array, projected in place."""
    system.project_in_place(p, x)
    return x


@system.tip_index.register(*HANGING)
def tip_index(p):
    """Return the index of the support's tip among the points."""
    return polyline_size(p.support) - 1


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


@system.switching.register(*HANGING)
def switching(p):
    """Return how the equations switch: by what hangs, the support, exchanges of the load and the kink of a wind."""
    of_support = with_support_switching(p.support, rope_switching(p))
    return with_kink_switching(p.wind, with_exchange_switching(p.exchange, of_support))


def rope_switching(p):
    """Return how the equations switch by falls, by friction of a winch, or by the stops."""
    slackens = isinstance(p, FallsCrane) or (isinstance(p, ElasticCrane) and p.cable.slack is not None)
    if slackens or isinstance(p.hoist, ReevedHoist) or hoist_modes(p.hoist) > 0:
        return Switching(EVENT_LOG_CAPACITY, 0, step_control_of(friction_of(p.hoist)))
    return make_switching(p.stops, 0)


@system.apply_reset_map.register(*HANGING)
def switch(p, t, x, u, number):
    """Return (state after an event, the event, whether the run goes on)."""
    kind, joint, _ = decode(number)
    if kind == Guard.FRICTION:
        return after_friction_guard(p, t, x, system.effort(u, p, t, x), joint)
    if kind == Guard.BACKLASH:
        return switch_drive(p.support, x, read_state(p.support, x, layout_of(p)[0]), number)
    if isinstance(p, FallsCrane):
        return falls_outputs.switch(p, t, x, number)
    if isinstance(p, ElasticCrane):
        return elastic_outputs.switch(p, t, x, number)
    if p.exchange is not None and kind == Guard.PAYLOAD:
        return impulses.apply_exchange(p, t, x)
    return x, number, False


def after_friction_guard(p, t, x, tau, joint):
    """Return the result of `switch` after the guard of the friction of a joint or of the winch has failed."""
    if hoist_modes(p.hoist) > 0 and joint == WINCH:
        return after_winch_guard(p, t, x, tau)
    return after_joint_guard(p, t, x, tau, joint)


@routine
def after_joint_guard(p, t, x, tau, joint):
    """Return the result of `switch` after the guard of the friction of a support's joint has failed."""
    nq, _, _ = layout_of(p)
    x, k = x.copy(), friction_state_index(p.support, x, joint)
    mode_before = stop(x, nq + joint, k)
    x[k] = mode_after_guard(p.support, joint, mode_before, solve(p, t, x, tau))
    return x, friction_event(joint, x[k]), True


@routine
def after_winch_guard(p, t, x, tau):
    """Return the result of `switch` after the guard of the winch's friction has failed."""
    nq, first, _ = layout_of(p)
    x, k = x.copy(), winch_index(p)
    mode_before = stop(x, nq + first - 1, k)
    pull, (length, _) = solve(p, t, x, tau).paid, rope_length(p, x)
    x[k] = mode_of_stopped_winch(p.hoist, mode_before, tau, pull, length, p.gravity)
    return x, friction_event(WINCH, x[k]), True


def stop(x, rate, mode):
    """Return the mode x[mode] of what friction held or slowed down, and set its rate and mode to those of rest."""
    mode_before = x[mode]
    x[rate], x[mode] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
    return mode_before


@system.fall_count.register(*HANGING)
def count_falls(p):
    """Return the number of falls of the hoist's reeving."""
    return hoist_falls(p.hoist)


@system.fall_tensions.register(*HANGING)
def write_tensions_of_falls(p, t, x, u, rows, i):
    """Write the tensions of lead line and falls [N], and the drum's torque [N m]."""
    tau = system.effort(u, p, t, x)
    solved = solve(p, t, x, tau)
    motion = (*rope_length(p, x), solved.length)
    write_fall_tensions(p.hoist, tau, mode_of_winch(p, x), motion, solved.paid, p.gravity, rows[i])
