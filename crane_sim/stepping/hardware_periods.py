"""Control periods of a crane with hardware: the one way in which its time passes, in `simulate` and under ROS alike.

Period k: the drives take the demand, brakes and faults act, the equations pass the period (steps end where a drive's
rate limit stops binding), brakes slip, and the sensors look at the state that period k + 1 begins with.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.hardware.brakes import POSITION, slip
from crane_sim.hardware.drives import Drives, accept_command, latch, next_breakpoint
from crane_sim.hardware.faults import Faults, Log, apply_to_drives, apply_to_sensors, payload_mass, update_active
from crane_sim.hardware.payloads import PayloadFault, with_payload
from crane_sim.hardware.sensors import SHOWN, sense
from crane_sim.integrators import Status, apply_pending_events, reach
from crane_sim.numerics.arrays import store
from crane_sim.numerics.jit import entry, generic, kernel, routine
from crane_sim.numerics.states import replace_entry
from crane_sim.stepping.periods import finish, pass_period, write

BRAKING, LIMITED, LOST_SAMPLES, GIVEN, MASS, BRAKED = 0, 1, 2, 3, 4, 5
"""Places in the books: 1 while all brakes are to hold; periods in which a demand was limited; samples lost; energy [J]
that changes of the payload brought; the payload's mass [kg]; periods in which all brakes held."""
COUNTERS = 6


class Hardware(NamedTuple):
    """What does not change in a run."""

    seed: Any  # a word
    faults: Faults
    reload: PayloadFault | None = None


class HardwareState(NamedTuple):
    """What the hardware of one run remembers: arrays that kernels change."""

    drives: Any  # (DRIVE_ROWS, nu)
    queue: Any  # (depth, nu), the last demands
    signals: Any  # (SENSOR_ROWS, 2 nq)
    ring: Any  # (depth, 2 nq), the last samples
    orders: Any  # (faults,)
    present: Any  # (faults,)
    log: Log
    books: Any  # (BOOKS,)


@generic
def like(q, row, first):
    """Return as many floats of the array `row`, from index `first` on, as q has, and as q has them: tuple or array."""
    for j in range(len(q)):
        q = replace_entry(q, j, row[first + j])
    return q


@like.register(np.ndarray)
def _(q, row, first):
    return row[first : first + len(q)].copy()


@routine
def sample_sensors(p, h, m, flow, k, period):
    """Let the sensors see the state at the begin of period k, with the faults that are there by then."""
    update_active(h.faults, m.orders, m.present, m.log, k * period, 1e-9 * period)
    apply_to_sensors(h.faults, m.present, m.signals)
    q, v = system.joints(p, flow.x)
    m.books[LOST_SAMPLES] += sense(h.seed, m.signals, m.ring, k, q, v)


@kernel
def read_sensors(p, m, flow):
    """Return (q, v) as the sensors show them, of the kind that `system.joints` returns."""
    q, v = system.joints(p, flow.x)
    return like(q, m.signals[SHOWN], 0), like(v, m.signals[SHOWN], len(q))


@entry
def first_sample(p, h, m, flow, period):
    """Let the sensors see the first state; return (q, v) as they show them."""
    sample_sensors(p, h, m, flow, 0, period)
    return read_sensors(p, m, flow)


@routine
def update_payload(p, h, m, flow):
    """Return the crane with the payload that hangs from it now, and keep the books of what the change brought."""
    now = with_payload(h.reload, p, m.books[MASS])
    mass = payload_mass(h.faults, m.present, base_mass(h.reload))
    if mass != m.books[MASS]:
        before = system.kinetic(now, flow.x) + system.potential(now, flow.x)
        m.books[MASS] = mass
        now = with_payload(h.reload, p, mass)
        m.books[GIVEN] += system.kinetic(now, flow.x) + system.potential(now, flow.x) - before
    return now


@generic
def base_mass(reload):
    """Return the payload's mass [kg] without faults; 0 where none changes it."""
    return 0.0


@base_mass.register(PayloadFault)
def _(reload):
    return reload.mass


@routine
def apply_command(p, h, m, flow, k, period, demand):
    """Return the source of period k, in which the drives take `demand` (nu,)."""
    update_active(h.faults, m.orders, m.present, m.log, k * period, 1e-9 * period)
    braking = m.books[BRAKING] > 0.0
    limited = accept_command(p, m.drives, m.queue, k, demand)
    m.books[LIMITED] += 1.0 if limited and not braking else 0.0
    m.books[BRAKED] += 1.0 if braking else 0.0
    store(m.drives, POSITION, 0, system.actuated_joints(p, flow.x)[0])
    apply_to_drives(h.faults, m.present, m.drives, braking)
    return Drives(k * period, m.drives)


@routine
def pass_driven(method, p, u, flow, end, times, samples, i):
    """Return as `pass_period` does, by steps that also end where a drive's effort has a kink."""
    while flow.status == Status.OK and flow.t < end:
        kink = next_breakpoint(u, flow.t, end)
        flow, i = pass_period(method, p, u, flow, kink, kink, times, samples, i)
    return flow, i


@routine
def end_period(p, h, m, u, flow, k, period):
    """Note at the end of period k where drives and brakes are, and let the sensors see the state."""
    latch(p, u, flow.t, flow.x)
    for i in range(m.drives.shape[1]):
        slip(m.drives, i)
    sample_sensors(p, h, m, flow, k + 1, period)


@entry
def hardware_step(method, p, h, m, demand, flow, k, period, rows, i):
    """Write row i, then pass period k with the demand given to the drives.

    Returns:
        (flow, (q, v), (q, v) as the sensors show them, effort applied at the begin of the period)
    """
    u = apply_command(p, h, m, flow, k, period, demand)
    now = update_payload(p, h, m, flow)
    flow = apply_pending_events(system.switching(now), now, u, flow)
    applied = system.effort(u, now, flow.t, flow.x)
    write(rows, i, now, flow.t, flow.x, u)
    while flow.status == Status.OK and flow.t < (k + 1) * period:
        kink = next_breakpoint(u, flow.t, (k + 1) * period)
        flow = reach(method, now, u, flow, kink, kink)
    if flow.status == Status.OK or flow.t >= (k + 1) * period:
        end_period(now, h, m, u, flow, k, period)
    return flow, system.joints(now, flow.x), read_sensors(now, m, flow), applied


@entry
def hardware_rollout(method, p, law, h, m, flow, period, rows, demands, times, samples, loads):
    """Run a law that is asked every period with what the sensors show.

    Args:
        method, p, law, flow, period, rows, demands, times, samples: as of `stepping.periods.held_rollout`.
        h, m: hardware, and its memory at the start.
        loads: to fill with the payload's mass [kg] in every period and the energy [J] that its changes brought up to
            there (steps, 2).

    Returns:
        (last flow, number of periods passed)
    """
    steps = len(rows) - 1
    i = 0 * steps  # a variable: for the literal 0 everything below would be compiled once more
    sample_sensors(p, h, m, flow, i, period)
    for k in range(steps):
        q, v = read_sensors(p, m, flow)
        demand = system.command(law, k * period, q, v)
        store(demands, k, 0, demand)
        u = apply_command(p, h, m, flow, k, period, demand)
        now = update_payload(p, h, m, flow)
        loads[k, 0], loads[k, 1] = m.books[MASS], m.books[GIVEN]
        flow = apply_pending_events(system.switching(now), now, u, flow)
        write(rows, k, now, flow.t, flow.x, u)
        end = (k + 1) * period
        flow, i = pass_driven(method, now, u, flow, end, times, samples, i)
        if flow.status != Status.OK and flow.t < end:
            return flow, k
        if k == steps - 1:
            finish(method, now, u, flow, flow.t, rows, times, samples, i)
        end_period(now, h, m, u, flow, k, period)
    return flow, steps


@entry
def read_inputs(source, t, q, v):
    """Return the demand (nu,) of open-loop inputs at time t [s]."""
    return system.command(source, t, q, v)
