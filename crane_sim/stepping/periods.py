"""Compiled loops over control periods: the one way in which time passes, in `simulate` and under ROS alike.

A row of results is [q (nq), v (nq), effort applied (nu), energy supplied, tensions (L)], see `crane_sim.stepping.rows`.
Within a period the demanded efforts are held; `u` may instead be a source that the equations evaluate themselves
(open-loop inputs, a continuous law): then the steps follow the solution alone and rows are read off between them.
"""

from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.integrators import (
    OK,
    apply_pending_events,
    dense_output,
    integrate_to,
    make_event_log,
    start,
    step_bound,
)
from crane_sim.numerics.arrays import store
from crane_sim.numerics.jit import entry, routine


class Replay(NamedTuple):
    """A law that repeats demands that are known."""

    model: Any  # of the plant: how many efforts there are
    period: float  # s
    demands: Any  # (steps, nu)


@system.command.register(Replay)
def _(law, t, q, v):
    return system.efforts_from_row(law.model, law.demands[round(t / law.period)])


class Output(NamedTuple):
    """Arrays that a rollout fills."""

    rows: Any  # (steps + 1, width), of the begins of all periods and the end
    demands: Any  # (steps, nu), of the law before limits; None where no law is sampled
    times: Any  # (m,) s, increasing: where samples are wanted
    samples: Any  # (m, width), rows at these times


@entry
def begin(p, q, v):
    """Return (flow, q, v) at rest on the initial joint positions and velocities, at t = 0."""
    flow = start(p, 0.0, system.project(p, system.state(p, 0.0, q, v)), make_event_log(system.switching(p)))
    return flow, *system.joints(p, flow.x)


@routine
def write(rows, i, p, t, x, u):
    """Write the row of state x under the source u into rows[i]."""
    q, v = system.joints(p, x)
    tau = system.effort(u, p, t, x)
    for j in range(len(q)):
        rows[i, j] = q[j]
        rows[i, j + len(q)] = v[j]
    store(rows, i, 2 * len(q), tau)
    after = 2 * len(q) + len(tau)
    rows[i, after] = system.energy_supplied(p, x)
    system.tensions(p, t, x, tau, rows, i, after + 1)


@routine
def pass_period(method, p, u, flow, end, bound, out, i):
    """Return (flow covering `end`, index of the next sample), with the samples of this period written on the way.

    Args:
        method, p, u, flow: settings, parameters, source, integration under way.
        end: of the period [s].
        bound: no step passes it [s]: `end` when u is held, since u jumps there.
        out: `Output`, whose samples are written.
        i: index of the first sample not yet written.
    """
    times = out.times
    while i < len(times) and times[i] < end and (flow.status == OK or flow.t >= times[i]):
        flow = integrate_to(method, p, u, flow, times[i], bound)
        write(out.samples, i, p, times[i], dense_output(method, p, u, flow, times[i]), u)
        i += 1
    return integrate_to(method, p, u, flow, end, bound), i


@entry
def held_step(method, p, demand, flow, end, rows, i):
    """Write row i, then pass one period with the efforts that `demand` leaves after limits.

    Returns:
        (flow, q, v, effort applied)
    """
    u = system.saturate(p, demand)
    flow = apply_pending_events(system.switching(p), p, u, flow)
    write(rows, i, p, flow.t, flow.x, u)
    flow = integrate_to(method, p, u, flow, end, end)
    q, v = system.joints(p, flow.x)
    return flow, q, v, u


@entry
def free_step(method, p, source, flow, begin, end, rows, i):
    """Write row i, then pass one period with efforts that the equations evaluate; results as of `held_step`."""
    flow = apply_pending_events(system.switching(p), p, source, flow)
    x = dense_output(method, p, source, flow, begin)
    u = system.effort(source, p, begin, x)
    write(rows, i, p, begin, x, u)
    flow = integrate_to(method, p, source, flow, end, step_bound(method, end))
    q, v = system.joints(p, dense_output(method, p, source, flow, end))
    return flow, q, v, u


@routine
def finish(method, p, u, flow, end, out, i):
    """Write the row and the samples at the very end of a run."""
    x = dense_output(method, p, u, flow, end)
    write(out.rows, len(out.rows) - 1, p, end, x, u)
    while i < len(out.times):
        write(out.samples, i, p, end, x, u)
        i += 1


@entry
def held_rollout(method, p, law, flow, period, out):
    """Run a law that is sampled every period.

    Args:
        method, p, law, flow: settings, parameters, law with a compiled `command`, integration at its start.
        period: s.
        out: `Output` to fill.

    Returns:
        (last flow, number of periods passed)
    """
    steps = len(out.rows) - 1
    i = 0 * steps  # a variable: for the literal 0 everything below would be compiled once more
    q, v = system.joints(p, flow.x)
    u = system.saturate(p, system.command(law, 0.0, q, v))
    for k in range(steps):
        q, v = system.joints(p, flow.x)
        demand = system.command(law, k * period, q, v)
        store(out.demands, k, 0, demand)
        u = system.saturate(p, demand)
        flow = apply_pending_events(system.switching(p), p, u, flow)
        write(out.rows, k, p, flow.t, flow.x, u)
        end = (k + 1) * period
        flow, i = pass_period(method, p, u, flow, end, end, out, i)
        if flow.status != OK and flow.t < end:
            return flow, k
    finish(method, p, u, flow, flow.t, out, i)
    return flow, steps


@entry
def free_rollout(method, p, source, flow, period, out):
    """Run under a source that the equations evaluate; arguments and results as of `held_rollout`."""
    steps = len(out.rows) - 1
    i = 0 * steps  # a variable: for the literal 0 everything below would be compiled once more
    flow = apply_pending_events(system.switching(p), p, source, flow)
    for k in range(steps):
        end = (k + 1) * period
        write(out.rows, k, p, k * period, dense_output(method, p, source, flow, k * period), source)
        flow, i = pass_period(method, p, source, flow, end, step_bound(method, end), out, i)
        if flow.status != OK and flow.t < end:
            return flow, k
    finish(method, p, source, flow, steps * period, out, i)
    return flow, steps
