"""The compiled loop over many cranes, each of which passes its time as `stepping.periods` does, bit for bit.

The compiled loop over many cranes in the lanes of vectors, for methods whose steps are all of one size.

The steps are those of `simulate`, lane for lane, in all bits.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.integrators import (
    OK,
    Counters,
    apply_pending_events,
    dense_output,
    make_event_log,
    stages,
    start,
    step,
    step_bound,
)
from crane_sim.integrators.integration import equal_step, status_of
from crane_sim.numerics.jit import entry, generic, kernel, routine
from crane_sim.numerics.lanes import LANES, lane, put_lane, tree_column, use_wide_vectors
from crane_sim.numerics.states import dimension, replace_field
from crane_sim.stepping.periods import Output, finish, pass_period, write


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
    counts: Any  # (n, 6): status, whole periods passed, evaluations, steps, steps rejected, terminal guard


@entry
def pass_cranes(cranes, clock, places, first, last):
    """Pass the whole time of cranes `first` to `last` (not included), one after the other."""
    for i in range(first, last):
        method, p, source = tree_column(cranes, i)
        flow = start(p, 0.0, initial_state(p, places, i), make_event_log(system.switching(p)))
        flow, passed = passed_through(source, method, p, flow, clock, places.rows[i])
        note(p, clock, places, i, flow, passed)


@kernel
def initial_state(p, places, i):
    """Return the state in which crane i starts."""
    return system.project(p, system.state(p, 0.0, places.q[i], places.v[i]))


@generic
def passed_through(source, method, p, flow, clock, rows):
    """Return (last flow, periods passed) of a run, its rows written on the way."""
    i, m = 0 * clock.steps, len(clock.times)  # 0 as a variable: the literal would be compiled once more
    out = Output(rows, None, clock.times, rows[:m])
    flow = apply_pending_events(system.switching(p), p, source, flow)
    for k in range(clock.steps):
        before, end = flow, (k + 1) * clock.period
        bound = step_bound(method, end)
        flow, i = pass_period(method, p, source, flow, end, bound, out, i)
        if flow.status != OK and flow.t < end:
            t = k * clock.period
            write(rows, m, p, t, dense_output(method, p, source, before, t), source)
            return flow, k
    finish(method, p, source, flow, clock.steps * clock.period, out, i)
    return flow, clock.steps


@passed_through.register(Sampled)
def _(source, method, p, flow, clock, rows):
    i, m = 0 * clock.steps, len(clock.times)  # 0 as a variable: the literal would be compiled once more
    out = Output(rows, None, clock.times, rows[:m])
    u = sampled_efforts(source, p, 0.0, flow.x)
    for k in range(clock.steps):
        u, end = sampled_efforts(source, p, k * clock.period, flow.x), (k + 1) * clock.period
        before = apply_pending_events(system.switching(p), p, u, flow)
        flow, i = pass_period(method, p, u, before, end, end, out, i)
        if flow.status != OK and flow.t < end:
            write(rows, m, p, before.t, before.x, u)
            return flow, k
    finish(method, p, u, flow, flow.t, out, i)
    return flow, clock.steps


@kernel
def sampled_efforts(sampled, p, t, x):
    """Return the efforts (nu,) that actuators apply from time t on for what a sampled law demands."""
    q, v = system.joints(p, x)
    return system.saturate(p, system.command(sampled.law, t, q, v))


@routine
def note(p, clock, places, i, flow, passed):
    """Note how the run of crane i went, and where its payload was; samples beyond the last whole period are none."""
    counts, rows, nq, m = places.counts[i], places.rows[i], places.q.shape[1], len(clock.times)
    counts[0], counts[1] = flow.status, passed
    counts[2], counts[3], counts[4] = flow.counters
    counts[5] = flow.terminal_guard
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


@entry
def pass_lanes(method, cranes, clock, places, first, last):
    """Pass the whole time of cranes `first` to `last` (not included), whole blocks of LANES.

    A crane whose state does not stay finite is noted as such, without when: pass it alone.

    Args:
        method: of a fixed step, the same for all cranes.
        cranes: columns of `Driven` whose models do not switch.
        clock, places, first, last: as of `pass_cranes`.
    """
    use_wide_vectors()
    for block in range(first, last, LANES):
        like = first_lane(cranes, places, block)
        xs, us = np.empty((dimension(like[0]), LANES)), np.empty((len(like[1]), LANES))
        for j in range(LANES):
            put_lane(xs, j, initial_state(tree_column(cranes, block + j).model, places, block + j))
        t, taken, i = 0.0, 0, 0
        for k in range(clock.steps):
            for j in range(LANES):
                crane = tree_column(cranes, block + j)
                put_lane(us, j, held_efforts(crane.source, crane.model, k * clock.period, lane(like[0], xs, j)))
            end = (k + 1) * clock.period
            while t < end:
                h, after = equal_step(method.step, t, end)
                while i < len(clock.times) and clock.times[i] < after:
                    for j in range(LANES):
                        crane, x, u = tree_column(cranes, block + j), lane(like[0], xs, j), lane(like[1], us, j)
                        sample(method, crane, x, u, t, clock.times[i], places.rows[block + j], i)
                    i += 1
                for j in range(LANES):  # the loop that becomes vector instructions
                    crane, x = tree_column(cranes, block + j), lane(like[0], xs, j)
                    x = step(method, crane.model, t, x, driving(crane.source, lane(like[1], us, j)), h, None)
                    put_lane(xs, j, x)
                t, taken = after, taken + 1
        for j in range(LANES):
            crane, x, u = tree_column(cranes, block + j), lane(like[0], xs, j), lane(like[1], us, j)
            end_lane(method, crane, x, u, clock, places, block + j, taken, i)


@kernel
def first_lane(cranes, places, block):
    """Return (state, held efforts) of the first crane of a block: what the lanes look like."""
    crane = tree_column(cranes, block)
    x = initial_state(crane.model, places, block)
    return x, held_efforts(crane.source, crane.model, 0.0, x)


@generic
def held_efforts(source, p, t, x):
    """Return the efforts that are held from time t on as a tuple; empty where the equations evaluate the source."""
    return ()


@held_efforts.register(Sampled)
def _(source, p, t, x):
    return sampled_efforts(source, p, t, x)


@generic
def driving(source, efforts):
    """Return what drives the equations: the source itself, or the efforts that are held."""
    return source


@driving.register(Sampled)
def _(source, efforts):
    return efforts


@routine
def sample(method, crane, x, efforts, t, time, rows, i):
    """Write row i, the state at `time`, of a crane that is in state x at time t."""
    u, flow = driving(crane.source, efforts), start(crane.model, t, x, None)
    write(rows, i, crane.model, time, dense_output(method, crane.model, u, flow, time), u)


@routine
def end_lane(method, crane, x, efforts, clock, places, i, taken, sampled):
    """Write the rows of crane i from number `sampled` on, in state x at the end, and note how its run went."""
    end, rows, u = clock.steps * clock.period, places.rows[i], driving(crane.source, efforts)
    flow = replace_field(start(crane.model, end, x, None), "status", status_of(x))
    flow = replace_field(flow, "counters", Counters(taken * stages(method), taken, 0))
    finish(method, crane.model, u, flow, end, Output(rows, None, clock.times, rows[: len(clock.times)]), sampled)
    note(crane.model, clock, places, i, flow, clock.steps)
