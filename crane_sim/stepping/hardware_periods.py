"""Compiled loops over control periods with hardware, the same in `simulate` and under ROS.

Period k: the drives take the command, brakes and faults act, the equations are integrated (steps end where a drive's
rate limit stops binding), brakes slip, and the sensors sample the state that period k + 1 begins with.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.hardware.brakes import read_limit_switch, slip
from crane_sim.hardware.drives import Drives, accept_command, latch_efforts, next_breakpoint
from crane_sim.hardware.faults import (
    FaultLog,
    Faults,
    apply_to_drives,
    apply_to_sensors,
    compute_payload_mass,
    update_active,
)
from crane_sim.hardware.payloads import PayloadFault, apply_payload_fault
from crane_sim.hardware.sensors import sense
from crane_sim.integrators import OK, apply_pending_events, integrate_to
from crane_sim.numerics.arrays import copy_into, store
from crane_sim.numerics.jit import entry_point, generic, kernel, routine
from crane_sim.numerics.states import replace_entry
from crane_sim.stepping.periods import finish, integrate_period, write


class HardwareState(NamedTuple):
    """The hardware of one run: its parameters, and its state in arrays that compiled functions change in place."""

    seed: Any  # uint64
    faults: Faults
    payload_fault: PayloadFault | None
    drives: Any  # records of DRIVE (nu,)
    servos: Any  # `servos.Servos`, None where all drives are commanded efforts
    queue: Any  # (depth, nu), the last commands
    sensors: Any  # records of SENSOR (2 nq,)
    ring: Any  # (depth, 2 nq), the last samples
    overrides: Any  # (faults,), see `faults.SCHEDULED`
    active: Any  # (faults,)
    log: FaultLog
    totals: Any  # record of TOTALS (1,)


@generic
def copy_in_kind_of(q, values, first):
    """Return len(q) floats of the array `values`, from index `first` on: as a tuple or as an array, whichever q is."""
    for j in range(len(q)):
        q = replace_entry(q, j, values[first + j])
    return q


@copy_in_kind_of.register(np.ndarray)
def _(q, values, first):
    return values[first : first + len(q)].copy()


@routine
def sample_sensors(p, hardware, integration, k, period):
    """Sample the state at the start of period k, with the faults that are active by then."""
    update_active(hardware.faults, hardware.overrides, hardware.active, hardware.log, k * period, 1e-9 * period)
    apply_to_sensors(hardware.faults, hardware.active, hardware.sensors)
    q, v = system.joints(p, integration.x)
    hardware.totals[0].lost_samples += sense(hardware.seed, hardware.sensors, hardware.ring, k, q, v)


@kernel
def read_measurements(p, hardware, integration):
    """Return the measured (q, v), tuples or arrays as `system.joints` returns."""
    q, v = system.joints(p, integration.x)
    readings = hardware.sensors.reading
    return copy_in_kind_of(q, readings, 0), copy_in_kind_of(v, readings, len(q))


@entry_point
def sample_first_state(p, hardware, integration, period):
    """Sample the state at the start of a run; return the measured (q, v)."""
    sample_sensors(p, hardware, integration, 0, period)
    return read_measurements(p, hardware, integration)


@entry_point
def measure_states(hardware, period, q, v, out):
    """Fill out (K, 2 nq) with the measurements of the states q, v (K, nq) at the starts of the first K periods."""
    for k in range(len(q)):
        update_active(hardware.faults, hardware.overrides, hardware.active, hardware.log, k * period, 1e-9 * period)
        apply_to_sensors(hardware.faults, hardware.active, hardware.sensors)
        hardware.totals[0].lost_samples += sense(hardware.seed, hardware.sensors, hardware.ring, k, q[k], v[k])
        for j in range(out.shape[1]):
            out[k, j] = hardware.sensors[j].reading


@kernel
def relative_energy(p, x):
    """Return the sum of kinetic and potential energy [J] relative to the base."""
    return system.kinetic(p, x) + system.potential(p, x)


@routine
def update_payload(p, hardware, integration):
    """Return the crane with the payload of the active faults; the energy that a change supplies goes to the totals."""
    totals = hardware.totals[0]
    crane = apply_payload_fault(hardware.payload_fault, p, totals.payload_mass)
    mass = compute_payload_mass(hardware.faults, hardware.active, nominal_payload_mass(hardware.payload_fault))
    if mass != totals.payload_mass:
        before = relative_energy(crane, integration.x)
        totals.payload_mass = mass
        crane = apply_payload_fault(hardware.payload_fault, p, mass)
        totals.payload_energy += relative_energy(crane, integration.x) - before
    return crane


@generic
def nominal_payload_mass(fault):
    """Return the payload's mass [kg] while no fault is active; 0 in scenes without faults of the payload."""
    return 0.0


@nominal_payload_mass.register(PayloadFault)
def _(fault):
    return fault.nominal_mass


@routine
def apply_command(p, hardware, integration, k, period, command):
    """Return the source of period k, in which the drives take `command` (nu,)."""
    update_active(hardware.faults, hardware.overrides, hardware.active, hardware.log, k * period, 1e-9 * period)
    totals, u = hardware.totals[0], Drives(k * period, hardware.drives, hardware.servos)
    saturated = accept_command(p, u, integration.x, hardware.queue, k, command)
    totals.saturated += 1 if saturated and not totals.braking else 0
    totals.braked += 1 if totals.braking else 0
    copy_into(hardware.drives.position, system.actuated_joints(p, integration.x)[0])
    apply_to_drives(hardware.faults, hardware.active, hardware.drives, totals.braking)
    return u


@routine
def integrate_period_with_drives(method, p, u, integration, end, out, i):
    """Return the result of `integrate_period`, by steps that also end where a drive's effort has a breakpoint."""
    while integration.status == OK and integration.t < end:
        break_time = next_breakpoint(u, integration.t, end)
        integration, i = integrate_period(method, p, u, integration, break_time, break_time, out.times, out.samples, i)
    return integration, i


@routine
def end_period(p, hardware, u, integration, k, period):
    """End period k: latch the drives' efforts, let brakes slip, read limit switches, and sample the state."""
    latch_efforts(p, u, integration.t, integration.x)
    for i in range(len(hardware.drives)):
        slip(hardware.drives[i])
        read_limit_switch(hardware.drives[i])
    sample_sensors(p, hardware, integration, k + 1, period)


@entry_point
def hardware_step(method, p, hardware, command, integration, k, period, rows, i):
    """Write row i, then integrate over period k with `command` (nu,) given to the drives.

    Returns:
        (integration, (q, v), measured (q, v), effort applied at the start of the period)
    """
    u = apply_command(p, hardware, integration, k, period, command)
    crane = update_payload(p, hardware, integration)
    integration = apply_pending_events(system.switching(crane), crane, u, integration)
    applied = system.effort(u, crane, integration.t, integration.x)
    write(rows, i, crane, integration.t, integration.x, u)
    while integration.status == OK and integration.t < (k + 1) * period:
        break_time = next_breakpoint(u, integration.t, (k + 1) * period)
        integration = integrate_to(method, crane, u, integration, break_time, break_time)
    if integration.status == OK or integration.t >= (k + 1) * period:
        end_period(crane, hardware, u, integration, k, period)
    return integration, system.joints(crane, integration.x), read_measurements(crane, hardware, integration), applied


@entry_point
def hardware_rollout(method, p, law, hardware, integration, period, out, loads):
    """Run a law that is evaluated at the start of every period, on the measured positions and velocities.

    Args:
        method, p, law, integration, period, out: see `stepping.periods.zero_order_hold_rollout`.
        hardware: `HardwareState` at the start of the run, which is changed.
        loads: array (steps, 2), filled with the payload's mass [kg] in every period and the energy [J] that changes of
            it have supplied until then.

    Returns:
        (last integration, number of periods integrated)
    """
    steps, totals = len(out.rows) - 1, hardware.totals[0]
    i = 0 * steps  # a variable: for the literal 0 everything below would be compiled once more
    sample_sensors(p, hardware, integration, i, period)
    for k in range(steps):
        q, v = read_measurements(p, hardware, integration)
        command = system.command(law, k * period, q, v)
        store(out.commands, k, 0, command)
        u = apply_command(p, hardware, integration, k, period, command)
        crane = update_payload(p, hardware, integration)
        loads[k, 0], loads[k, 1] = totals.payload_mass, totals.payload_energy
        integration = apply_pending_events(system.switching(crane), crane, u, integration)
        write(out.rows, k, crane, integration.t, integration.x, u)
        end = (k + 1) * period
        integration, i = integrate_period_with_drives(method, crane, u, integration, end, out, i)
        if integration.status != OK and integration.t < end:
            return integration, k
        if k == steps - 1:
            finish(method, crane, u, integration, integration.t, out, i)
        end_period(crane, hardware, u, integration, k, period)
    return integration, steps


@entry_point
def read_inputs(source, t, q, v):
    """Return the command (nu,) of open-loop inputs at time t [s]."""
    return system.command(source, t, q, v)
