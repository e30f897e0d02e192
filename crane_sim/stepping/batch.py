"""Compiled loops over many cranes: one after the other, or in the lanes of vectors for fixed steps.

The steps of each crane are those of `simulate`, bit for bit.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.integrators import (
    dense_output,
    make_event_log,
    start,
    step,
)
from crane_sim.integrators.integration import status_of
from crane_sim.integrators.step_control import equal_step, periods_per_step
from crane_sim.numerics.jit import entry_point, routine, simd_range, use_wide_vectors
from crane_sim.numerics.lanes import LANES, lane, put_lane, take_entry
from crane_sim.numerics.states import dimension
from crane_sim.stepping.periods import Output, Sampled, finish, roll_out, sampled_source, write


class Driven(NamedTuple):
    """Method, model and source of one crane; for many of them, each number is a column."""

    method: Any
    model: Any
    source: Any


class TimeGrid(NamedTuple):
    """Control periods and sample times of a run, the same for all cranes."""

    period: float  # s
    steps: int
    times: Any  # (m,) s, sample times


class BatchArrays(NamedTuple):
    """Initial states and results of n cranes.

    The rows of the samples and of the end are as in `stepping.rows`.
    """

    q: Any  # (n, nq), at the start
    v: Any  # (n, nq)
    rows: Any  # (n, m + 1, width)
    payload: Any  # (n, m + 1, 3) m
    reached: Any  # (n,) s, time of the integration
    counts: Any  # (n, 6): status, whole periods, evaluations, steps, steps rejected, terminal guard


@entry_point
def simulate_range(cranes, grid, arrays, first, last):
    """Simulate cranes `first` to `last` (excluded), one after the other."""
    for i in range(first, last):
        method, p, source = take_entry(cranes, i)
        integration = start(
            p, 0.0, state_at_start(p, arrays, i), make_event_log(system.switching(p))
        )
        rows, m = arrays.rows[i], len(grid.times)
        out = Output(grid.steps, None, None, rows[m:], grid.times, rows[:m])
        integration, periods_done = roll_out(method, p, source, integration, grid.period, out)
        store_result(p, grid, arrays, i, integration, periods_done)


def state_at_start(p, arrays, i):
    """Return the initial state of crane i."""
    return system.project(p, system.state(p, 0.0, arrays.q[i], arrays.v[i]))


@routine
def store_result(p, grid, arrays, i, integration, periods_done):
    """Store status, counters and payload positions of crane i.

    Samples beyond the last whole period are NaN.
    """
    counts, rows, nq, m = arrays.counts[i], arrays.rows[i], arrays.q.shape[1], len(grid.times)
    counts[0], counts[1] = integration.status, periods_done
    counts[2], counts[3], counts[4] = (
        integration.evaluations,
        integration.steps,
        integration.rejected,
    )
    counts[5] = integration.terminal_guard
    arrays.reached[i], end = integration.t, periods_done * grid.period
    points = np.empty((system.point_count(p), 3))
    for k in range(m + 1):
        t = grid.times[k] if k < m else end
        if t > end and periods_done < grid.steps:
            rows[k] = np.nan
            arrays.payload[i, k] = np.nan
        else:
            system.points(p, t, system.state(p, t, rows[k, :nq], rows[k, nq : 2 * nq]), points)
            arrays.payload[i, k] = points[-1]


@entry_point
def pass_lanes(method, cranes, grid, arrays, first, last):
    """Pass the whole time of cranes `first` to `last` (not included), whole blocks of LANES.

    A state that becomes infinite is reported without its time: simulate that crane alone.

    Args:
        method: of a fixed step, the same for all cranes.
        cranes: columns of `Driven` whose models do not switch.
        grid, arrays, first, last: see `simulate_range`.
    """
    use_wide_vectors()
    # an index that may be negative would be a gather
    for block in range(max(first, 0), last, LANES):
        like = first_lane(cranes, arrays, block)
        xs, us = np.empty((dimension(like[0]), LANES)), np.empty((len(like[1]), LANES))
        for j in simd_range(LANES):
            put_lane(xs, j, state_at_start(take_entry(cranes, block + j).model, arrays, block + j))
        t, taken, i, span = 0.0, 0, 0, held_periods(like[2], method, grid.period)
        for k in range(0, grid.steps, span):
            for j in simd_range(LANES):
                crane = take_entry(cranes, block + j)
                x = lane(like[0], xs, j)
                put_lane(us, j, held_efforts(crane.source, crane.model, k * grid.period, x))
            end = min(k + span, grid.steps) * grid.period
            while t < end:
                h, after = equal_step(method.step, t, end)
                while i < len(grid.times) and grid.times[i] < after:
                    for j in simd_range(LANES):
                        crane = take_entry(cranes, block + j)
                        x = lane(like[0], xs, j)
                        u = lane(like[1], us, j)
                        sample(method, crane, x, u, t, grid.times[i], arrays.rows[block + j], i)
                    i += 1
                for j in simd_range(LANES):
                    crane, x = take_entry(cranes, block + j), lane(like[0], xs, j)
                    source = driving(crane.source, lane(like[1], us, j))
                    put_lane(xs, j, step(method, crane.model, t, x, source, h, None))
                t, taken = after, taken + 1
        for j in simd_range(LANES):
            crane, x, u = take_entry(cranes, block + j), lane(like[0], xs, j), lane(like[1], us, j)
            end_lane(method, crane, x, u, grid, arrays, block + j, taken, i)


def first_lane(cranes, arrays, block):
    """Return (state, held efforts, source) of the first crane of a block, the type of its lanes."""
    crane = take_entry(cranes, block)
    x = state_at_start(crane.model, arrays, block)
    return x, held_efforts(crane.source, crane.model, 0.0, x), crane.source


def held_periods(source, method, period):
    """Return for how many periods the equations' source does not jump.

    It is as many as a step spans.
    """
    return 1 if isinstance(source, Sampled) else periods_per_step(method, period)


def held_efforts(source, p, t, x):
    """Return the efforts held from time t on as a tuple; empty if the equations use the source."""
    return sampled_source(source.law, p, t, x, None, 0) if isinstance(source, Sampled) else ()


def driving(source, efforts):
    """Return the source of the equations: the source itself, or the efforts that are held."""
    return efforts if isinstance(source, Sampled) else source


@routine
def sample(method, crane, x, efforts, t, time, rows, i):
    """Write row i, the state at `time`, of a crane that is in state x at time t."""
    u, integration = driving(crane.source, efforts), start(crane.model, t, x, None)
    write(rows, i, crane.model, time, dense_output(method, crane.model, u, integration, time), u)


@routine
def end_lane(method, crane, x, efforts, grid, arrays, i, taken, sampled):
    """Write the rows of crane i from `sampled` on; store how its run went.

    It ends in state x.
    """
    end, rows, u = grid.steps * grid.period, arrays.rows[i], driving(crane.source, efforts)
    integration = start(crane.model, end, x, None)
    integration = integration._replace(
        status=status_of(x), evaluations=taken * method.stages, steps=taken
    )
    m = len(grid.times)
    out = Output(grid.steps, None, None, rows[m:], grid.times, rows[:m])
    finish(method, crane.model, u, integration, end, out, sampled)
    store_result(crane.model, grid, arrays, i, integration, grid.steps)
