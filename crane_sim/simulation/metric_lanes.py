"""Metrics of whole runs in lanes: instants side by side, of cranes with one link that have `system.observe`.

LANES instants are watched at a time, as soon as they have passed, in vectors of the processor; sums go one instant
after the other.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.numerics.jit import routine, simd_range, use_wide_vectors
from crane_sim.numerics.lanes import LANES, lane, put_lane
from crane_sim.numerics.states import scale, smaller
from crane_sim.simulation.energy_balance import add_compensated, balance_instant
from crane_sim.simulation.extremes import note_range_at
from crane_sim.simulation.metric_loops import Clock, RunColumns, RunScratch, count_limited
from crane_sim.simulation.peaks import PUSHED, watch_efforts, watch_swing, watch_tension
from crane_sim.simulation.settling import is_outside
from crane_sim.stepping.periods import write_instant


class LaneBuffers(NamedTuple):
    """Instants side by side."""

    joints: Any  # (2 nq + nu, LANES), positions, velocities and efforts
    observed: Any  # (9, LANES), see `system.observe`
    supplied: Any  # (1, LANES) J
    swung: Any  # (2, LANES), by how much ropes swing further than before: in the run, and in its last part
    least: Any  # (2 nq + nu + 6, LANES), the least values of instants in these lanes, see `values_of`
    pushed: Any  # (1, LANES), instants at which the link pushed

    def make_output(self, clock, run, scratch, states):
        """Return the output of the rollout of one run, whose states are to be kept in `states`."""
        for j in simd_range(LANES):
            self.pushed[0, j] = 0.0
            for c in range(len(self.least)):
                self.least[c, j] = np.inf
        run.counts[4] = 0
        return LaneOutput(states, scratch.commands, scratch.times[:0], scratch.rows[:0], clock, run, scratch)


def lane_buffers(nq: int, nu: int) -> LaneBuffers:
    """Return the buffers of cranes with nq joints, nu of them actuated."""
    joints = 2 * nq + nu
    return LaneBuffers(*(np.empty((n, LANES)) for n in (joints, 9, 1, 2, joints + 6, 1)))


class LaneOutput(NamedTuple):
    """An `Output` that keeps states in place of rows; instants go into lanes, and from there into metrics."""

    rows: Any  # (steps + 1, 1 + 2 nq), time and joints
    commands: Any  # (steps, nu)
    times: Any  # none
    samples: Any  # none
    clock: Clock
    run: RunColumns  # of one run
    scratch: RunScratch

    @routine
    def watch_rest(self, p):
        """Gather the metrics of the instants that have not been watched as they came."""
        run, scratch = self.run, self.scratch
        k, lanes = run.counts[1], scratch.lanes
        q, v = system.joints(p, system.state(p, 0.0, run.q, run.v))
        whole, like = k - k % LANES, (q, v, system.efforts_from_row(p, scratch.commands[0]))
        join_lanes(run, lanes)
        observe_lanes(p, like, scratch, whole)
        for i in range(whole, k + 1):
            watch_instant(self, i, i - whole)
        note_last_outside(run, scratch, whole, k - whole)
        count_limited_lanes(run, scratch, whole, k - whole)
        for j in range(6):
            run.ends[j] = lanes.observed[3 + j, k % LANES]


@write_instant.register(LaneOutput)
def put_instant(out, i, p, t, x, u):
    """Put instant i into its lane, after the block before it has been watched."""
    (q, v), tau, lanes, j = system.joints(p, x), system.effort(u, p, t, x), out.scratch.lanes, i % LANES
    if j == 0 and i > 0:
        watch_block(out, p, (q, v, tau), i - LANES)
    put_lane(lanes.joints, j, (q, v, tau))
    lanes.supplied[0, j] = system.energy_supplied(p, x)
    out.rows[i, 0] = out.scratch.times[i]
    out.rows[i, 1 : 1 + len(q)], out.rows[i, 1 + len(q) :] = q, v


@routine
def watch_block(out, p, like, first):
    """Take the LANES instants from number `first` on, which are in the lanes, into the metrics of a run."""
    run, clock, scratch = out.run, out.clock, out.scratch
    add_work(run.balance, clock.metered, scratch)
    watch_lanes(p, like, run, scratch, first)
    watch_swings(run.peaks, clock, scratch, first)
    note_last_outside(run, scratch, first, LANES)
    count_limited_lanes(run, scratch, first, LANES)


@routine
def add_work(balance, metered, scratch):
    """Put what was supplied up to each instant into the lanes, where no meter tells: the work of held efforts.

    Efforts held before the first instant are zero, and so is their work.
    """
    joints, driven, last = scratch.lanes.joints, scratch.driven, balance.last
    total, lost, efforts = balance.work[0], balance.work[1], len(joints) - len(driven)
    for j in range(0 if metered else LANES):
        done = 0.0
        for c in range(len(driven)):
            q = joints[driven[c], j]
            done += last[1, c] * (q - last[0, c])
            last[0, c], last[1, c] = q, joints[efforts + c, j]
        total, lost = add_compensated(total, lost, done)
        scratch.lanes.supplied[0, j] = total + lost
    balance.work[0], balance.work[1] = total, lost
    balance.count[0] += LANES


def note_last_outside(run, scratch, first, count):
    """Note when joints were last not near their targets, of `count` instants from number `first` on in the lanes."""
    for c in range(len(run.target)):
        positions, j = scratch.lanes.joints[scratch.driven[c]], count - 1
        while j >= 0 and not is_outside(run.target[c], run.near[c], positions[j]):
            j -= 1
        if j >= 0:
            run.outside[c] = scratch.times[first + j]


def count_limited_lanes(run, scratch, first, count):
    """Count the commands that were limited, of `count` instants from number `first` on in the lanes."""
    efforts = scratch.lanes.joints[2 * len(run.q) :, :count].T
    run.counts[4] += count_limited(scratch.commands[first : first + count], efforts)


@routine
def watch_lanes(p, like, run, scratch, first):
    """Gather the metrics of LANES instants side by side; `like`: joints and efforts of one."""
    use_wide_vectors()
    lanes, start = scratch.lanes, (run.balance.start[0], run.balance.start[1])
    largest = run.peaks.swing
    sizes = (
        np.sqrt(largest[0, 0] * largest[0, 0] + largest[0, 1] * largest[0, 1]),
        np.sqrt(largest[1, 0] * largest[1, 0] + largest[1, 1] * largest[1, 1]),
    )
    heights = largest[0, 2], largest[1, 2]
    for j in simd_range(LANES):
        q, v, u = lane(like, lanes.joints, j)
        observed = system.observe(p, scratch.times[first + j], q, v, u)
        values = values_of(q, u, observed, start, lanes.supplied[0, j])
        put_lane(lanes.least, j, smaller(lane(values, lanes.least, j), values))
        _, tension, tip, payload = observed
        (count,) = lane((0.0,), lanes.pushed, j)
        put_lane(lanes.pushed, j, (count + 1.0 if tension < PUSHED else count,))
        x, y, z = payload[0] - tip[0], payload[1] - tip[1], payload[2] - tip[2]
        h = np.sqrt(x * x + y * y)
        put_lane(lanes.swung, j, (sizes[0] * z - h * heights[0], sizes[1] * z - h * heights[1]))
        put_lane(lanes.observed, j, observed)


def values_of(q, u, observed, start, supplied):
    """Return what is watched of an instant as values whose least ones count."""
    (kinetic, potential), tension, _, _ = observed
    error = kinetic + potential - start[0] - (start[1] + supplied)
    energies = -abs(error), -kinetic, potential, -potential
    return q, scale(-1.0, q), smaller(u, scale(-1.0, u)), energies, tension, -tension


@routine
def watch_swings(peaks, clock, scratch, first):
    """Take the ropes of a block into the peaks, where one of them swings further than before it."""
    seen, swung, last = scratch.lanes.observed, scratch.lanes.swung, scratch.times[first + LANES - 1]
    further = False
    for j in simd_range(LANES):
        further = further or swung[0, j] > 0.0 or (last >= clock.late and swung[1, j] > 0.0)
    for j in range(LANES if further else 0):
        rope = seen[6, j] - seen[3, j], seen[7, j] - seen[4, j], seen[8, j] - seen[5, j]
        watch_swing(peaks, scratch.times[first + j], clock.late, rope)


@routine
def join_lanes(run, lanes):
    """Take the least values of all lanes into the metrics of the run."""
    nq, nu, least, extremes = len(run.q), len(run.target), lanes.least, run.balance.extremes
    after = 2 * nq + nu
    for j in range(least.shape[1]):
        for c in range(nq):
            run.ranges[0, c] = min(run.ranges[0, c], least[c, j])
            run.ranges[1, c] = max(run.ranges[1, c], -least[nq + c, j])
        for c in range(nu):
            run.peaks.effort[c] = max(run.peaks.effort[c], -least[2 * nq + c, j])
        extremes[0], extremes[1] = max(extremes[0], -least[after, j]), max(extremes[1], -least[after + 1, j])
        extremes[2], extremes[3] = min(extremes[2], least[after + 2, j]), max(extremes[3], -least[after + 3, j])
        run.peaks.tension[0] = min(run.peaks.tension[0], least[after + 4, j])
        run.peaks.tension[1] = max(run.peaks.tension[1], -least[after + 5, j])
        run.peaks.pushed[0] += int(lanes.pushed[0, j])


@routine
def observe_lanes(p, like, scratch, first):
    """Observe the instants from number `first` on, which are in the lanes; `like`: joints and efforts of one."""
    use_wide_vectors()
    lanes, last = scratch.lanes, len(scratch.times) - 1
    for j in simd_range(LANES):
        q, v, u = lane(like, lanes.joints, j)
        put_lane(lanes.observed, j, system.observe(p, scratch.times[min(first + j, last)], q, v, u))


def watch_instant(out, i, j):
    """Take instant i, which is in lane j, into the metrics of a run; of the last one, positions only."""
    run, clock, scratch = out.run, out.clock, out.scratch
    nq, nu, joints, seen = len(run.q), len(run.target), scratch.lanes.joints, scratch.lanes.observed
    note_range_at(joints[:nq, j], run.ranges[0], run.ranges[1])
    for c in range(nu):
        run.driven_end[c] = joints[scratch.driven[c], j]
    if i < run.counts[1]:
        u, supplied = joints[2 * nq : 2 * nq + nu, j], scratch.lanes.supplied[0, j]
        balance_instant(run.balance, clock.metered, run.driven_end, u, supplied, seen[0, j], seen[1, j])
        watch_tension(run.peaks, seen[2, j], seen[2, j])
        rope = seen[6, j] - seen[3, j], seen[7, j] - seen[4, j], seen[8, j] - seen[5, j]
        watch_swing(run.peaks, scratch.times[i], clock.late, rope)
        watch_efforts(run.peaks, u)
