"""Compiled loop over whole runs of many cranes, which gathers the figures of each.

They are gathered by the compiled functions that `metrics.Metrics` calls block by block.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.numerics.jit import entry_point, generic, routine, routine_generic
from crane_sim.numerics.lanes import tree_column
from crane_sim.simulation.energy_balance import Balance, balance_errors, balance_instants
from crane_sim.simulation.extremes import note_range
from crane_sim.simulation.metrics import read_meters
from crane_sim.simulation.peaks import Peaks, fill_watched, watch_instants
from crane_sim.simulation.settling import note_outside
from crane_sim.stepping.batch import Sampled
from crane_sim.stepping.periods import Output, begin, continuous_rollout, zero_order_hold_rollout

AT_ONCE = 16
"""Runs whose states are kept until they are hashed: they fit the second cache."""


class Clock(NamedTuple):
    """Control periods of a run, the same for all cranes of a kind, and whether these have meters."""

    period: float  # s
    steps: int
    late: float  # s, when the last part of the run begins
    metered: bool


class RunColumns(NamedTuple):
    """Initial states of n cranes, and what their runs have shown."""

    q: Any  # (n, nq), at the start
    v: Any  # (n, nq)
    target: Any  # (n, nu), of the actuated joints
    near: Any  # (n, nu), which distance from it counts as near
    peaks: Peaks  # columns
    balance: Balance  # columns
    ranges: Any  # (n, 2, nq), least and greatest joint positions
    outside: Any  # (n, nu) s, when joints were last away from their targets
    audit: Any  # (n, 2), energy errors
    ends: Any  # (n, 6) m, tip and payload at the end
    driven_end: Any  # (n, nu), positions of the actuated joints at the end
    counts: Any  # (n, 5): status, whole periods, evaluations, terminal guard, periods in which a command was limited
    reached: Any  # (n,) s, time of the integration


class RunScratch(NamedTuple):
    """Arrays that one run after another uses."""

    times: Any  # (steps + 1,) s
    driven: Any  # (nu,) indices of the actuated joints
    rows: Any  # (steps + 1, width), see `stepping.rows`
    commands: Any  # (steps, nu)
    energies: Any  # (steps + 1, 2) J
    ends: Any  # (steps + 1, 6) m
    driven_q: Any  # (steps + 1, nu)
    states: Any  # (AT_ONCE, steps + 1, 1 + 2 nq), time and joints of the runs
    lanes: Any  # `figure_lanes.LaneBuffers` where rows have no tensions; None for others


@generic
def roll_out(source, method, p, integration, period, out):
    """Return (last integration, number of whole periods, those in which a command was limited); fill `out`."""
    return (*continuous_rollout(method, p, source, integration, period, out), 0)


@roll_out.register(Sampled)
def _(source, method, p, integration, period, out):
    integration, done = zero_order_hold_rollout(method, p, source.law, integration, period, out)
    limited, nu = 0, out.commands.shape[1]
    first = 2 * len(system.joints(p, integration.x)[0])
    for k in range(done):
        differs = False
        for j in range(nu):
            differs = differs or out.commands[k, j] != out.rows[k, first + j]
        limited += differs
    return integration, done, limited


@generic
def output_of(lanes, scratch):
    """Return the output of a rollout whose rows have tensions by default."""
    return Output(scratch.rows, scratch.commands, np.empty(0), np.empty((0, scratch.rows.shape[1])))


@entry_point
def run_cranes_with_figures(cranes, clock, runs, scratch, first, last):
    """Run cranes `first` to `last` (excluded): columns of `Driven`; fill `RunColumns`, and the states of each run."""
    out = output_of(scratch.lanes, scratch)
    for i in range(first, last):
        method, p, source = tree_column(cranes, i)
        integration, _, _ = begin(p, runs.q[i], runs.v[i])
        runs.balance.start[i, 0] = read_meters(p, integration.x)[0]
        integration, done, limited = roll_out(source, method, p, integration, clock.period, out)
        counts = runs.counts[i]
        counts[0], counts[1], counts[2] = integration.status, done, integration.evaluations
        counts[3], counts[4] = integration.terminal_guard, limited
        runs.reached[i] = integration.t
        watch_run(scratch.lanes, p, clock, tree_column(runs, i), scratch, scratch.states[i - first])
        finish_run(p, clock, tree_column(runs, i), scratch, integration.x)


@routine_generic
def watch_run(lanes, p, clock, run, scratch, states):
    """Gather the figures of one run from its rows, and copy its states."""
    k, nq, nu = run.counts[1], len(run.q), len(run.target)
    rows, t = scratch.rows[: k + 1], scratch.times[: k + 1]
    q, v, u = rows[:, :nq], rows[:, nq : 2 * nq], rows[:, 2 * nq : 2 * nq + nu]
    fill_watched(p, t, q, v, scratch.energies, scratch.ends)
    for i in range(k + 1):
        states[i, 0] = t[i]
        for j in range(2 * nq):
            states[i, 1 + j] = rows[i, j]
        for j in range(nu):
            scratch.driven_q[i, j] = q[i, scratch.driven[j]]
    driven_q, energies = scratch.driven_q[:k], scratch.energies
    supplied, tensions = rows[:k, 2 * nq + nu], rows[:k, 2 * nq + nu + 1 :]
    balance_instants(run.balance, clock.metered, driven_q, u[:k], supplied, energies[:k, 0], energies[:k, 1])
    watch_instants(run.peaks, t[:k], clock.late, u[:k], tensions, scratch.ends)
    note_range(q, run.ranges[0], run.ranges[1])
    note_outside(run.target, run.near, t[:k], driven_q, run.outside)


@routine
def finish_run(p, clock, run, scratch, x):
    """Note the figures of a run at its end, in state x of the integration."""
    k = run.counts[1]
    for j in range(6):
        run.ends[j] = scratch.ends[k, j]
    for j in range(len(run.driven_end)):
        run.driven_end[j] = scratch.driven_q[k, j]
    energy, supplied = read_meters(p, x)
    audit = balance_errors(run.balance, clock.metered, scratch.driven_q[k], energy, supplied)
    run.audit[0], run.audit[1] = audit
