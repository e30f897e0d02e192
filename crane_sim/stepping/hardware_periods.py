"""Compiled loops over control periods with hardware, the same in `simulate` and under ROS.

Period k: the drives take the command, brakes and faults act, the equations are integrated (steps
end where a drive's rate limit stops binding), brakes slip, and the sensors sample the state that
period k + 1 begins with.

Steps end with the period where efforts may change there. Open-loop inputs whose drives have no
state are functions of time: then the error alone determines the steps, as in `stepping.periods`,
and what happens once a period (sensors, limit switches, rows) sees states interpolated between
them. A fault, or a brake, cuts back the step under way.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.hardware.brakes import read_limit_switch, slip
from crane_sim.hardware.drives import (
    Drives,
    accept_command,
    change_with_period,
    latch_efforts,
    next_breakpoint,
)
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
from crane_sim.integrators import (
    OK,
    apply_pending_events,
    dense_output,
    integrate_to,
    latest_step_end,
    restart,
)
from crane_sim.numerics.jit import NONE, entry_point, optimisation, routine
from crane_sim.stepping.periods import (
    Output,
    as_floats,
    finish,
    integrate_period,
    integrate_source_to,
    integrate_to_breakpoints,
    reaches,
    write,
)
from crane_sim.trajectories.breakpoints import PiecewiseSource


class HardwareState(NamedTuple):
    """The hardware of one run: its parameters, and its state, in arrays changed in place."""

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


def state_at(inputs, method, p, u, integration, t):
    """Return the state at time t [s], which the last step covers.

    With held efforts the step ended there.
    """
    if inputs is None or integration.t == t:
        return integration.x
    return dense_output(method, p, u, integration, t)


@integrate_source_to.register(Drives)
def integrate_drives_to(u, method, p, integration, t, latest):
    """Return the result of `integrate_source_to` under drives; steps end at input breakpoints."""
    if isinstance(u.inputs, PiecewiseSource):
        return integrate_to_breakpoints(u.inputs, u, method, p, integration, t, latest)
    return integrate_to(method, p, u, integration, t, latest)


@routine
def sample_sensors(p, hardware, x, k, period):
    """Sample the state x at the start of period k, with the faults that are active by then."""
    update_active(
        hardware.faults,
        hardware.overrides,
        hardware.active,
        hardware.log,
        k * period,
        1e-9 * period,
    )
    apply_to_sensors(hardware.faults, hardware.active, hardware.sensors)
    q, v = system.joints(p, x)
    hardware.totals[0].lost_samples += sense(
        hardware.seed, hardware.sensors, hardware.ring, k, q, v
    )


def read_measurements(p, hardware, x):
    """Return the measured (q, v), tuples or arrays as `system.joints` returns for the state x."""
    q, _ = system.joints(p, x)
    n, readings = len(q), hardware.sensors.reading
    if isinstance(q, np.ndarray):
        return readings[:n].copy(), readings[n:].copy()
    return tuple([readings[j] for j in range(n)]), tuple([readings[n + j] for j in range(n)])


@entry_point
@optimisation(NONE)
def sample_first_state(p, hardware, integration, period):
    """Sample the state at the start of a run; return the measured (q, v)."""
    sample_sensors(p, hardware, integration.x, 0, period)
    return read_measurements(p, hardware, integration.x)


@entry_point
def measure_states(hardware, period, q, v, out):
    """Fill out (K, 2 nq) with measurements of states q, v (K, nq) at starts of periods.

    They are the first K periods.
    """
    for k in range(len(q)):
        update_active(
            hardware.faults,
            hardware.overrides,
            hardware.active,
            hardware.log,
            k * period,
            1e-9 * period,
        )
        apply_to_sensors(hardware.faults, hardware.active, hardware.sensors)
        hardware.totals[0].lost_samples += sense(
            hardware.seed, hardware.sensors, hardware.ring, k, q[k], v[k]
        )
        out[k] = hardware.sensors.reading


def relative_energy(p, x):
    """Return the sum of kinetic and potential energy [J] relative to the base."""
    return system.kinetic(p, x) + system.potential(p, x)


@routine
def update_payload(p, hardware, x):
    """Take the payload of the active faults in state x; return whether that is another one.

    The energy that the change supplies goes to the totals.
    """
    totals = hardware.totals[0]
    mass = compute_payload_mass(
        hardware.faults, hardware.active, nominal_payload_mass(hardware.payload_fault)
    )
    if mass == totals.payload_mass:
        return False
    before = relative_energy(apply_payload_fault(hardware.payload_fault, p, totals.payload_mass), x)
    totals.payload_mass = mass
    totals.payload_energy += (
        relative_energy(apply_payload_fault(hardware.payload_fault, p, mass), x) - before
    )
    return True


def nominal_payload_mass(fault):
    """Return the payload's mass [kg] without active faults; 0 in scenes without payload faults."""
    return 0.0 if fault is None else fault.nominal_mass


@routine
def apply_command(p, hardware, u, x, k, period, command):
    """Let the drives take `command` (nu,) in state x at the start of period k.

    Returns whether faults or brakes change.

    Without faults and brakes, efforts change there of drives only whose steps end with the period
    anyway.
    """
    update_active(
        hardware.faults,
        hardware.overrides,
        hardware.active,
        hardware.log,
        k * period,
        1e-9 * period,
    )
    totals = hardware.totals[0]
    saturated = accept_command(p, u, x, hardware.queue, k, command)
    totals.saturated += 1 if saturated and not totals.braking else 0
    totals.braked += 1 if totals.braking else 0
    hardware.drives.position[:] = system.actuated_joints(p, x)[0]
    changed = apply_to_drives(hardware.faults, hardware.active, hardware.drives, totals.braking)
    return update_payload(p, hardware, x) or changed


@routine
def begin_period(method, p, hardware, u, integration, k, period, command):
    """Begin period k under the drives u, which take `command` (nu,).

    Returns:
        (integration, state at the period's start)
    """
    t, mass = k * period, hardware.totals[0].payload_mass
    x = state_at(
        u.inputs, method, apply_payload_fault(hardware.payload_fault, p, mass), u, integration, t
    )
    if apply_command(p, hardware, u, x, k, period, command) and integration.t > t:
        integration = restart(integration, t, x)
    if integration.t > t:
        return integration, x
    crane = laden(p, hardware)
    integration = apply_pending_events(system.switching(crane), crane, u, integration)
    return integration, integration.x


def laden(p, hardware):
    """Return the crane with its present payload."""
    return apply_payload_fault(hardware.payload_fault, p, hardware.totals[0].payload_mass)


def latest_end(method, u, k, steps, period):
    """Return the instant [s] that no step in period k of `steps` may pass."""
    return (
        (k + 1) * period
        if change_with_period(u.inputs, u.records)
        else latest_step_end(method, k, steps, period)
    )


@routine
def integrate_period_with_drives(method, p, u, integration, end, latest, out, i):
    """Return the result of `integrate_period`; steps also end at breakpoints of drives' efforts."""
    while True:
        break_time = next_breakpoint(u, integration.t, end)
        last = latest if break_time == end else break_time
        integration, i = integrate_period(
            method, p, u, integration, break_time, last, out.times, out.samples, i
        )
        if integration.status != OK or integration.t >= end:
            return integration, i


@routine
def end_period(p, hardware, u, x, k, period):
    """End period k in state x.

    Latches the drives' efforts, lets brakes slip, reads limit switches, samples the state.
    """
    latch_efforts(p, u, (k + 1) * period, x)
    for i in range(len(hardware.drives)):
        slip(hardware.drives[i])
        read_limit_switch(hardware.drives[i])
    sample_sensors(p, hardware, x, k + 1, period)


@entry_point
def hardware_step(run, hardware, inputs, command, k):
    """Integrate over period k.

    Args:
        run: `stepping.periods.RunUnderWay`.
        hardware, inputs, command, k: see `hardware_period`.

    Returns:
        (whether the period's end was reached, (q, v), measured (q, v), effort applied), q and v
        tuples
    """
    p, period, rows, like = run.p, run.period, run.rows, run.like
    integration, out = (
        run.integration.load(k),
        Output(run.steps, rows, None, None, rows[0, :0], rows[:0]),
    )
    args = (inputs, command, integration, k, period, out, k % len(rows), 0)
    integration, _, x, applied = hardware_period(run.method, p, hardware, *args)
    run.integration.store(k + 1, integration)
    (q, v), (measured_q, measured_v) = (
        system.joints(laden(p, hardware), x),
        read_measurements(p, hardware, x),
    )
    measured = as_floats(like, measured_q), as_floats(like, measured_v)
    return (
        reaches(integration, (k + 1) * period),
        (as_floats(like, q), as_floats(like, v)),
        measured,
        applied,
    )


def hardware_period(method, p, hardware, inputs, command, integration, k, period, out, row, i):
    """Write a row of `out`, then integrate over period k, and write the samples in it.

    Args:
        method, p, hardware, integration, k, period: as in `hardware_rollout`.
        inputs: open-loop source of demands; None where `command` is held.
        command: (nu,), at the start of the period.
        out: `Output`; what the end of the run shows is left out where `out.end` is None.
        row: which row is written.
        i: index of the first sample not yet written.

    Returns:
        (integration, index of the next sample, state at the period's end, effort applied at its
        start)
    """
    u, end = Drives(k * period, hardware.drives, hardware.servos, inputs), (k + 1) * period
    integration, x = begin_period(method, p, hardware, u, integration, k, period, command)
    crane = laden(p, hardware)
    applied = system.effort(u, crane, k * period, x)
    write(out.rows, row, crane, k * period, x, u)
    latest = latest_end(method, u, k, out.steps, period)
    integration, i = integrate_period_with_drives(
        method, crane, u, integration, end, latest, out, i
    )
    x = integration.x
    if reaches(integration, end):
        if out.end is not None and k == out.steps - 1:
            finish(method, crane, u, integration, end, out, i)
        x = state_at(inputs, method, crane, u, integration, end)
        end_period(crane, hardware, u, x, k, period)
    return integration, i, x, applied


@entry_point
def hardware_rollout(method, p, law, hardware, inputs, integration, period, out, loads):
    """Run a law that is evaluated at the start of every period, on measured joint coordinates.

    Args:
        method, p, law, integration, period, out: see `stepping.periods.roll_out`.
        hardware: `HardwareState` at the start of the run, which is changed.
        inputs: open-loop source of demands, whose values at the starts of periods `law` gives;
            None: the law commands.
        loads: array (steps, 2), filled with the payload's mass [kg] in every period and the energy
            [J] that changes of it have supplied until then.

    Returns:
        (last integration, number of periods integrated)
    """
    totals, i, x = hardware.totals[0], 0, integration.x
    sample_sensors(p, hardware, x, 0, period)
    for k in range(out.steps):
        q, v = read_measurements(p, hardware, x)
        command = system.command(law, k * period, q, v)
        out.commands[k] = command
        args = (inputs, command, integration, k, period, out, k, i)
        integration, i, x, _ = hardware_period(method, p, hardware, *args)
        loads[k, 0], loads[k, 1] = totals.payload_mass, totals.payload_energy
        if not reaches(integration, (k + 1) * period):
            return integration, k
    return integration, out.steps
