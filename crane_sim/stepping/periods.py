"""Compiled loops over control periods, the same in `simulate` and under ROS.

A row of results is [q (nq), v (nq), effort applied (nu), energy supplied, tensions (L)], see
`crane_sim.stepping.rows`. Functions `zero_order_hold_*` hold the commanded efforts within a period.
In functions `continuous_*` the equations evaluate a source themselves (open-loop inputs, a law in
continuous time): the error alone determines the steps, and rows are interpolated between them.
"""

from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.integrators import (
    OK,
    EventLog,
    apply_pending_events,
    dense_output,
    integrate_to,
    latest_step_end,
    make_event_log,
    start,
)
from crane_sim.integrators.step_control import MAX_FACTOR
from crane_sim.numerics.arrays import store
from crane_sim.numerics.jit import entry_point, generic, routine, seldom_called
from crane_sim.numerics.lanes import put_entry, take_entry
from crane_sim.trajectories.breakpoints import PiecewiseSource, last_instant_before, next_breakpoint


class Replay(NamedTuple):
    """A law that replays recorded commands."""

    model: Any  # of the plant, which fixes the number of efforts
    period: float  # s
    commands: Any  # (steps, nu)


@system.command.register(Replay)
def recorded_command(law, t, q, v):
    """Return the command of the period that begins at time t [s]."""
    return system.efforts_from_row(law.model, law.commands[round(t / law.period)])


class Sampled(NamedTuple):
    """A law that is sampled every period; the equations evaluate any other source themselves."""

    law: Any


class Output(NamedTuple):
    """Arrays that a rollout of so many steps fills; None: not wanted."""

    steps: int
    rows: Any  # (steps, width) or more, at the start of each period
    commands: Any  # (steps, nu), of law or inputs at the start of each period, before limits
    end: Any  # (1, width), the row at the end, or at the start of the period in which the
    # integration failed
    times: Any  # (m,) s, increasing: sample times
    samples: Any  # (m, width), rows at these times


class StoredIntegration(NamedTuple):
    """An integration that stays in arrays from period to period.

    That at the start of period k is in entries k % 2: a period that fails leaves what it began
    with.
    """

    columns: Any  # two entries of each of its numbers and states
    event_rows: Any  # of its log, None for a model that does not switch
    scratch: Any  # its work arrays

    def load(self, k):
        """Return the integration at the start of period k."""
        integration, log = take_entry(self.columns, k % 2), None
        if self.event_rows is not None:
            log = EventLog(integration.event_log, self.event_rows)
        return integration._replace(event_log=log, scratch=self.scratch)

    def store(self, k, integration):
        """Keep the integration at the start of period k."""
        put_entry(self.columns, k % 2, entries(integration))


def entries(integration):
    """Return the integration with its numbers and states only: of its log the number of events."""
    log = integration.event_log
    return integration._replace(event_log=None if log is None else log.total, scratch=None)


class RunUnderWay(NamedTuple):
    """What stays from period to period, so that a call passes it once."""

    method: Any
    p: Any  # parameters
    integration: Any  # `StoredIntegration`
    period: float  # s
    steps: int  # periods of the run
    rows: Any  # (K, width), of which row k % K is that of period k
    like: Any  # (nq,), any tuple of as many floats as there are joints


def output_of(rows: Any, commands: Any, times: Any, samples: Any) -> Output:
    """Return the output of a whole run: rows (steps + 1, width), the last one of the end."""
    return Output(len(rows) - 1, rows, commands, rows[len(rows) - 1 :], times, samples)


@entry_point
@seldom_called
def begin(p, q, v):
    """Return the integration at t = 0, before its first step, and the joints q, v of its state.

    The state is that of joint positions and velocities q, v, projected onto the constraints.
    """
    integration = start(
        p, 0.0, system.project(p, system.state(p, 0.0, q, v)), make_event_log(system.switching(p))
    )
    return integration, *system.joints(p, integration.x)


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


@generic
def integrate_source_to(u, method, p, integration, t, latest):
    """Return the result of `integrate_to` under a source u.

    Steps pass neither `latest` nor a breakpoint of u.
    """
    return integrate_to(method, p, u, integration, t, latest)


@integrate_source_to.register(PiecewiseSource)
def integrate_pieces_to(u, method, p, integration, t, latest):
    """Return the result of `integrate_source_to` under a source in pieces; steps end with each."""
    return integrate_to_breakpoints(u, u, method, p, integration, t, latest)


def integrate_to_breakpoints(inputs, u, method, p, integration, t, latest):
    """Return the result of `integrate_source_to` under a source u with breakpoints of `inputs`."""
    while integration.t < t and integration.status == OK:
        breakpoint_ = next_breakpoint(inputs, integration.t)
        end = min(latest, last_instant_before(breakpoint_, integration.t))
        integration = integrate_to(method, p, u, integration, min(t, end), end)
        if integration.t == end and end < latest:
            # the size to try next may be one of a crane at rest: take it as if it had grown in this
            # step
            largest = MAX_FACTOR * (integration.t - integration.t0)
            integration = integration._replace(h=min(integration.h, largest))
            integration = integration._replace(t=breakpoint_)
    return integration


@routine
def integrate_period(method, p, u, integration, end, latest, times, samples, i):
    """Return (integration covering `end`, index of the next sample); write the period's samples.

    Args:
        method, p, u, integration: settings, parameters, source, integration under way.
        end: of the period [s].
        latest: instant [s] that no step may pass: `end` when u is held, since u jumps there.
        times, samples: of an `Output`; the samples are written.
        i: index of the first sample not yet written.
    """
    while (
        i < len(times)
        and times[i] < end
        and (integration.status == OK or integration.t >= times[i])
    ):
        integration = integrate_source_to(u, method, p, integration, times[i], latest)
        write(samples, i, p, times[i], dense_output(method, p, u, integration, times[i]), u)
        i += 1
    return integrate_source_to(u, method, p, integration, end, latest), i


@entry_point
def zero_order_hold_step(run, command, k):
    """Integrate over period k with the efforts of `command` after limits.

    Args:
        run: `RunUnderWay`.
        command: (nu,).
        k: period.

    Returns:
        (whether the period's end was reached, (q, v), effort applied), q and v tuples
    """
    end, i = (k + 1) * run.period, k % len(run.rows)
    integration, q, v, u = hold_period(
        run.method, run.p, command, run.integration.load(k), end, run.rows, i
    )
    run.integration.store(k + 1, integration)
    return reaches(integration, end), (as_floats(run.like, q), as_floats(run.like, v)), u


def reaches(integration, end):
    """Return whether an integration came to the end [s] of a period."""
    return integration.status == OK or integration.t >= end


def hold_period(method, p, command, integration, end, rows, i):
    """Write row i, then integrate up to `end` [s] with the efforts of `command` after limits.

    `end` is that of the period.

    Returns:
        (integration, q, v, effort applied)
    """
    u = system.saturate(p, command)
    integration = apply_pending_events(system.switching(p), p, u, integration)
    write(rows, i, p, integration.t, integration.x, u)
    integration = integrate_to(method, p, u, integration, end, end)
    q, v = system.joints(p, integration.x)
    return integration, q, v, u


def as_floats(like, vector):
    """Return a tuple of the first floats of a vector, as many as there are in the tuple `like`."""
    return tuple([vector[j] for j in range(len(like))])


@entry_point
def continuous_step(run, source, k):
    """Integrate over period k with the source in the equations; see `zero_order_hold_step`.

    Returns:
        (whether the period's end was reached, (q, v), effort applied, effort demanded), as of
        `zero_order_hold_step`
    """
    method, p, period, integration = run.method, run.p, run.period, run.integration.load(k)
    t, end = k * period, (k + 1) * period
    integration = apply_pending_events(system.switching(p), p, source, integration)
    x = dense_output(method, p, source, integration, t)
    u, demanded = system.effort(source, p, t, x), system.demand(source, p, t, x)
    write(run.rows, k % len(run.rows), p, t, x, u)
    latest = latest_step_end(method, k, run.steps, period)
    integration = integrate_source_to(source, method, p, integration, end, latest)
    q, v = system.joints(p, dense_output(method, p, source, integration, end))
    run.integration.store(k + 1, integration)
    return reaches(integration, end), (as_floats(run.like, q), as_floats(run.like, v)), u, demanded


@routine
def finish(method, p, u, integration, end, out, i):
    """Write the row and the samples at the very end of a run."""
    x = dense_output(method, p, u, integration, end)
    write(out.end, 0, p, end, x, u)
    while i < len(out.times):
        write(out.samples, i, p, end, x, u)
        i += 1


@entry_point
def roll_out(method, p, source, integration, period, out):
    """Run under a source, `Sampled` or evaluated by the equations.

    Args:
        method, p, source, integration: settings, parameters, source, integration at its start.
        period: s.
        out: `Output` to fill.

    Returns:
        (last integration, number of whole periods)
    """
    if isinstance(source, Sampled):
        return hold_each_period(method, p, source.law, integration, period, out)
    return pass_each_period(method, p, source, integration, period, out)


@routine
def hold_each_period(method, p, law, integration, period, out):
    """Return the result of `roll_out` under a law that is sampled every period."""
    i = 0
    for k in range(out.steps):
        u, end = (
            sampled_source(law, p, k * period, integration.x, out.commands, k),
            (k + 1) * period,
        )
        before = apply_pending_events(system.switching(p), p, u, integration)
        if out.rows is not None:
            write(out.rows, k, p, before.t, before.x, u)
        integration, i = integrate_period(method, p, u, before, end, end, out.times, out.samples, i)
        if integration.status != OK and integration.t < end:
            write(out.end, 0, p, before.t, before.x, u)
            return integration, k
        if k == out.steps - 1:
            finish(method, p, u, integration, integration.t, out, i)
    return integration, out.steps


def sampled_source(law, p, t, x, commands, k):
    """Return the source of a sampled law from time t on, efforts (nu,); write command k.

    The efforts are those that actuators apply.

    A law that has `source_at(p, t, x)` gives another source, and has no commands.
    """
    if hasattr(law, "source_at"):
        return law.source_at(p, t, x)
    q, v = system.joints(p, x)
    command = system.command(law, t, q, v)
    if commands is not None:
        store(commands, k, 0, command)
    return system.saturate(p, command)


@routine
def pass_each_period(method, p, source, integration, period, out):
    """Return the result of `roll_out` under a source that the equations evaluate."""
    i = 0
    integration = apply_pending_events(system.switching(p), p, source, integration)
    for k in range(out.steps):
        t, end, before = k * period, (k + 1) * period, integration
        if out.rows is not None:
            x = dense_output(method, p, source, integration, t)
            store(out.commands, k, 0, system.demand(source, p, t, x))
            write(out.rows, k, p, t, x, source)
        latest = latest_step_end(method, k, out.steps, period)
        integration, i = integrate_period(
            method, p, source, integration, end, latest, out.times, out.samples, i
        )
        if integration.status != OK and integration.t < end:
            write(out.end, 0, p, t, dense_output(method, p, source, before, t), source)
            return integration, k
    finish(method, p, source, integration, out.steps * period, out, i)
    return integration, out.steps
