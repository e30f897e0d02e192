"""Compiled loops over control periods with hardware: the one way in which its time passes, in `simulate` and under ROS.

Period k: the drives take the demand, brakes and faults act, the equations pass the period (steps end where a drive's
rate limit stops binding), brakes slip, and the sensors sample the state that period k + 1 begins with.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.hardware.brakes import slip
from crane_sim.hardware.drives import Drives, accept_command, latch, next_breakpoint
from crane_sim.hardware.faults import Faults, Log, apply_to_drives, apply_to_sensors, payload_mass, update_active
from crane_sim.hardware.payloads import PayloadFault, with_payload
from crane_sim.hardware.sensors import sense
from crane_sim.integrators import OK, apply_pending_events, integrate_to
from crane_sim.numerics.arrays import assign, store
from crane_sim.numerics.jit import entry, generic, kernel, routine
from crane_sim.numerics.states import replace_entry
from crane_sim.stepping.periods import finish, pass_period, write


class Hardware(NamedTuple):
    """The hardware of one run: what does not change, and the state, arrays that kernels change."""

    seed: Any  # a word
    faults: Faults
    payload_fault: PayloadFault | None
    drives: Any  # records of DRIVE (nu,)
    queue: Any  # (depth, nu), the last demands
    sensors: Any  # records of SENSOR (2 nq,)
    ring: Any  # (depth, 2 nq), the last samples
    orders: Any  # (faults,)
    active: Any  # (faults,)
    log: Log
    tallies: Any  # record of TALLY (1,)


@generic
def like(q, values, first):
    """Return as many floats of the array `values`, from index `first` on, as q has, a tuple or an array as q is."""
    for j in range(len(q)):
        q = replace_entry(q, j, values[first + j])
    return q


@like.register(np.ndarray)
def _(q, values, first):
    return values[first : first + len(q)].copy()


@routine
def sample_sensors(p, hardware, flow, k, period):
    """Sample the state at the begin of period k, with the faults that are active by then."""
    update_active(hardware.faults, hardware.orders, hardware.active, hardware.log, k * period, 1e-9 * period)
    apply_to_sensors(hardware.faults, hardware.active, hardware.sensors)
    q, v = system.joints(p, flow.x)
    hardware.tallies[0].lost_samples += sense(hardware.seed, hardware.sensors, hardware.ring, k, q, v)


@kernel
def read_sensors(p, hardware, flow):
    """Return (q, v) as the sensors show them, of the kind that `system.joints` returns."""
    q, v = system.joints(p, flow.x)
    shown = hardware.sensors.shown
    return like(q, shown, 0), like(v, shown, len(q))


@entry
def first_sample(p, hardware, flow, period):
    """Sample the first state; return (q, v) as the sensors show them."""
    sample_sensors(p, hardware, flow, 0, period)
    return read_sensors(p, hardware, flow)


@kernel
def relative_energy(p, x):
    """Return kinetic and potential energy [J] relative to the base."""
    return system.kinetic(p, x) + system.potential(p, x)


@routine
def update_payload(p, hardware, flow):
    """Return the crane with the payload of the active faults, and count the energy that a change of it brings."""
    tally = hardware.tallies[0]
    laden = with_payload(hardware.payload_fault, p, tally.payload_mass)
    mass = payload_mass(hardware.faults, hardware.active, base_mass(hardware.payload_fault))
    if mass != tally.payload_mass:
        before = relative_energy(laden, flow.x)
        tally.payload_mass = mass
        laden = with_payload(hardware.payload_fault, p, mass)
        tally.payload_energy += relative_energy(laden, flow.x) - before
    return laden


@generic
def base_mass(fault):
    """Return the payload's mass [kg] without faults; 0 where none changes it."""
    return 0.0


@base_mass.register(PayloadFault)
def _(fault):
    return fault.mass


@routine
def apply_command(p, hardware, flow, k, period, demand):
    """Return the source of period k, in which the drives take `demand` (nu,)."""
    update_active(hardware.faults, hardware.orders, hardware.active, hardware.log, k * period, 1e-9 * period)
    tally = hardware.tallies[0]
    limited = accept_command(p, hardware.drives, hardware.queue, k, demand)
    tally.limited += 1 if limited and not tally.braking else 0
    tally.braked += 1 if tally.braking else 0
    assign(hardware.drives.position, system.actuated_joints(p, flow.x)[0])
    apply_to_drives(hardware.faults, hardware.active, hardware.drives, tally.braking)
    return Drives(k * period, hardware.drives)


@routine
def pass_driven(method, p, u, flow, end, out, i):
    """Return as `pass_period` does, by steps that also end where a drive's effort has a kink."""
    while flow.status == OK and flow.t < end:
        kink = next_breakpoint(u, flow.t, end)
        flow, i = pass_period(method, p, u, flow, kink, kink, out, i)
    return flow, i


@routine
def end_period(p, hardware, u, flow, k, period):
    """Latch the drives at the end of period k, let brakes slip, and sample the state."""
    latch(p, u, flow.t, flow.x)
    for i in range(len(hardware.drives)):
        slip(hardware.drives[i])
    sample_sensors(p, hardware, flow, k + 1, period)


@entry
def hardware_step(method, p, hardware, demand, flow, k, period, rows, i):
    """Write row i, then pass period k with the demand given to the drives.

    Returns:
        (flow, (q, v), (q, v) as the sensors show them, effort applied at the begin of the period)
    """
    u = apply_command(p, hardware, flow, k, period, demand)
    laden = update_payload(p, hardware, flow)
    flow = apply_pending_events(system.switching(laden), laden, u, flow)
    applied = system.effort(u, laden, flow.t, flow.x)
    write(rows, i, laden, flow.t, flow.x, u)
    while flow.status == OK and flow.t < (k + 1) * period:
        kink = next_breakpoint(u, flow.t, (k + 1) * period)
        flow = integrate_to(method, laden, u, flow, kink, kink)
    if flow.status == OK or flow.t >= (k + 1) * period:
        end_period(laden, hardware, u, flow, k, period)
    return flow, system.joints(laden, flow.x), read_sensors(laden, hardware, flow), applied


@entry
def hardware_rollout(method, p, law, hardware, flow, period, out, loads):
    """Run a law that is asked every period with what the sensors show.

    Args:
        method, p, law, flow, period, out: as of `stepping.periods.held_rollout`.
        hardware: at the start.
        loads: to fill with the payload's mass [kg] in every period and the energy [J] that its changes brought up to
            there (steps, 2).

    Returns:
        (last flow, number of periods passed)
    """
    steps, tally = len(out.rows) - 1, hardware.tallies[0]
    i = 0 * steps  # a variable: for the literal 0 everything below would be compiled once more
    sample_sensors(p, hardware, flow, i, period)
    for k in range(steps):
        q, v = read_sensors(p, hardware, flow)
        demand = system.command(law, k * period, q, v)
        store(out.demands, k, 0, demand)
        u = apply_command(p, hardware, flow, k, period, demand)
        laden = update_payload(p, hardware, flow)
        loads[k, 0], loads[k, 1] = tally.payload_mass, tally.payload_energy
        flow = apply_pending_events(system.switching(laden), laden, u, flow)
        write(out.rows, k, laden, flow.t, flow.x, u)
        end = (k + 1) * period
        flow, i = pass_driven(method, laden, u, flow, end, out, i)
        if flow.status != OK and flow.t < end:
            return flow, k
        if k == steps - 1:
            finish(method, laden, u, flow, flow.t, out, i)
        end_period(laden, hardware, u, flow, k, period)
    return flow, steps


@entry
def read_inputs(source, t, q, v):
    """Return the demand (nu,) of open-loop inputs at time t [s]."""
    return system.command(source, t, q, v)
