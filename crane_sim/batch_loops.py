"""The compiled loop over many cranes, each of which passes its time as `stepping` does, bit for bit."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.integrators import OK, horizon, record, settled, start, state_at
from crane_sim.jit import entry, generic, kernel, routine
from crane_sim.lane_algebra import picked
from crane_sim.stepping import finish, pass_period, write


class Sampled(NamedTuple):
    """A law that is sampled every period; any other source is evaluated by the equations themselves."""

    law: Any


class Driven(NamedTuple):
    """What one crane is; for many of them, each number is a column."""

    method: Any
    model: Any
    source: Any


class Clock(NamedTuple):
    """The instants of a run, the same for all cranes."""

    period: float  # s
    steps: int
    times: Any  # (m,) s, where samples are wanted


class Places(NamedTuple):
    """Where n cranes start, and where results are written: rows, as of `stepping`, of the samples and of the end."""

    q: Any  # (n, nq), at the start
    v: Any  # (n, nq)
    rows: Any  # (n, m + 1, width)
    payload: Any  # (n, m + 1, 3) m
    reached: Any  # (n,) s, where the integration stands
    counts: Any  # (n, 5): status, whole periods passed, evaluations, steps, steps rejected


@entry
def pass_cranes(cranes, clock, places, first, last):
    """Pass the whole time of cranes `first` to `last` (not included), one after the other."""
    for i in range(first, last):
        method, p, source = picked(cranes, i)
        flow = start(p, 0.0, started(p, places, i), record(system.switching(p)))
        flow, passed = passed_through(source, method, p, flow, clock, places.rows[i])
        note(p, clock, places, i, flow, passed)


@kernel
def started(p, places, i):
    """Return the state in which crane i starts."""
    return system.project(p, system.state(p, 0.0, places.q[i], places.v[i]))


@generic
def passed_through(source, method, p, flow, clock, rows):
    """Return (last flow, periods passed) of a run, its rows written on the way."""
    i, m = 0 * clock.steps, len(clock.times)  # 0 as a variable: the literal would be compiled once more
    flow = settled(system.switching(p), p, source, flow)
    for k in range(clock.steps):
        before, end = flow, (k + 1) * clock.period
        limit = horizon(method, end)
        flow, i = pass_period(method, p, source, flow, end, limit, clock.times, rows[:m], i)
        if flow.status != OK and flow.t < end:
            t = k * clock.period
            write(rows, m, p, t, state_at(method, p, source, before, t), source)
            return flow, k
    finish(method, p, source, flow, clock.steps * clock.period, rows, clock.times, rows[:m], i)
    return flow, clock.steps


@passed_through.register(Sampled)
def _(source, method, p, flow, clock, rows):
    i, m = 0 * clock.steps, len(clock.times)  # 0 as a variable: the literal would be compiled once more
    u = demanded(source, p, 0.0, flow.x)
    for k in range(clock.steps):
        u, end = demanded(source, p, k * clock.period, flow.x), (k + 1) * clock.period
        before = settled(system.switching(p), p, u, flow)
        flow, i = pass_period(method, p, u, before, end, end, clock.times, rows[:m], i)
        if flow.status != OK and flow.t < end:
            write(rows, m, p, before.t, before.x, u)
            return flow, k
    finish(method, p, u, flow, flow.t, rows, clock.times, rows[:m], i)
    return flow, clock.steps


@kernel
def demanded(sampled, p, t, x):
    """Return the efforts (nu,) that actuators apply from time t on for what a sampled law demands."""
    q, v = system.joints(p, x)
    return system.limited(p, system.command(sampled.law, t, q, v))


@routine
def note(p, clock, places, i, flow, passed):
    """Note how the run of crane i went, and where its payload was; samples beyond the last whole period are none."""
    counts, rows, nq, m = places.counts[i], places.rows[i], places.q.shape[1], len(clock.times)
    counts[0], counts[1] = flow.status, passed
    counts[2], counts[3], counts[4] = flow.evaluations, flow.steps, flow.rejected
    places.reached[i], end = flow.t, passed * clock.period
    points = np.empty((system.point_count(p), 3))
    for k in range(m + 1):
        t = clock.times[k] if k < m else end
        if t > end and passed < clock.steps:
            rows[k] = np.nan
            places.payload[i, k] = np.nan
        else:
            system.points(p, t, system.state(p, t, rows[k, :nq], rows[k, nq : 2 * nq]), points)
            places.payload[i, k] = points[-1]
