"""Compiled loop over whole runs of many cranes, which gathers the metrics of each.

They are gathered by the compiled functions that `metrics.Metrics` calls block by block.
"""

from typing import Any, NamedTuple

from crane_sim.numerics.jit import entry_point, routine
from crane_sim.numerics.lanes import take_entry
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
    rows: Any  # (steps + 1, width), see `stepping.rows`; (0, width) with lanes
    commands: Any  # (steps, nu)
    energies: Any  # (steps + 1, 2) J, as many as rows
    ends: Any  # (steps + 1, 6) m, likewise
    driven_q: Any  # (steps + 1, nu), likewise
    states: Any  # (AT_ONCE, steps + 1, 1 + 2 nq), time and joints of the runs
    lanes: Any  # `metric_lanes.LaneBuffers` where instants are watched in lanes as they come; None: at the end, in rows


def roll_out(source, method, p, integration, period, out):
    """Return (last integration, number of whole periods); fill `out`."""
    if isinstance(source, Sampled):
        return zero_order_hold_rollout(method, p, source.law, integration, period, out)
    return continuous_rollout(method, p, source, integration, period, out)


def output_of(clock, run, scratch, states) -> Any:
    """Return the output of the rollout of one run, whose states are to be kept in `states`."""
    if scratch.lanes is not None:
        return scratch.lanes.make_output(clock, run, scratch, states)
    return Output(scratch.rows, scratch.commands, scratch.times[:0], scratch.rows[:0])


@entry_point
def run_cranes_with_metrics(cranes, clock, runs, scratch, first, last):
    """Run cranes `first` to `last` (excluded): columns of `Driven`; fill `RunColumns`, and the states of each run."""
    for i in range(first, last):
        method, p, source = take_entry(cranes, i)
        run, states = take_entry(runs, i), scratch.states[i - first]
        integration, _, _ = begin(p, run.q, run.v)
        run.balance.start[0] = read_meters(p, integration.x)[0]
        out = output_of(clock, run, scratch, states)
        integration, done = roll_out(source, method, p, integration, clock.period, out)
        run.counts[0], run.counts[1], run.counts[2] = integration.status, done, integration.evaluations
        run.counts[3] = integration.terminal_guard
        runs.reached[i] = integration.t
        if scratch.lanes is None:
            watch_run(p, clock, run, scratch, states)
        else:
            out.watch_rest(p)
        energy, supplied = read_meters(p, integration.x)
        audit = balance_errors(run.balance, clock.metered, run.driven_end, energy, supplied)
        run.audit[0], run.audit[1] = audit


@routine
def watch_run(p, clock, run, scratch, states):
    """Gather the metrics of one run from its rows; copy its states."""
    k, nq, nu = run.counts[1], len(run.q), len(run.target)
    rows, t = scratch.rows[: k + 1], scratch.times[: k + 1]
    q, v, u = rows[:, :nq], rows[:, nq : 2 * nq], rows[:, 2 * nq : 2 * nq + nu]
    fill_watched(p, t, q, v, scratch.energies, scratch.ends)
    for i in range(k + 1):
        states[i, 0] = t[i]
        states[i, 1:] = rows[i, : 2 * nq]
        for j in range(nu):
            scratch.driven_q[i, j] = q[i, scratch.driven[j]]
    driven_q, energies = scratch.driven_q[:k], scratch.energies
    supplied, tensions = rows[:k, 2 * nq + nu], rows[:k, 2 * nq + nu + 1 :]
    balance_instants(run.balance, clock.metered, driven_q, u[:k], supplied, energies[:k, 0], energies[:k, 1])
    watch_instants(run.peaks, t[:k], clock.late, u[:k], tensions, scratch.ends)
    note_range(q, run.ranges[0], run.ranges[1])
    note_outside(run.target, run.near, t[:k], driven_q, run.outside)
    run.counts[4] = count_limited(scratch.commands[:k], u[:k])
    run.ends[:] = scratch.ends[k]
    run.driven_end[:] = scratch.driven_q[k]


def count_limited(commands, efforts):
    """Return in how many periods a command was limited: `commands` (n, nu) and the efforts applied (n, nu) differ."""
    limited = 0
    for k in range(len(commands)):
        differs = False
        for j in range(commands.shape[1]):
            differs = differs or commands[k, j] != efforts[k, j]
        limited += differs
    return limited
