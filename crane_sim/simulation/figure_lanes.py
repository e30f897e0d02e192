"""Figures of whole runs in lanes: instants side by side, of cranes with one link that have `system.observe`.

LANES instants are watched at a time, in vectors of the processor; sums go one instant after the other.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.numerics.jit import lean_kernel, lean_routine
from crane_sim.numerics.lanes import LANES, lane, put_lane, use_wide_vectors
from crane_sim.numerics.states import scale, smaller
from crane_sim.simulation.energy_balance import balance_instant, work_instant
from crane_sim.simulation.extremes import note_range_at
from crane_sim.simulation.figure_loops import output_of, watch_run
from crane_sim.simulation.peaks import PUSHED, watch_efforts, watch_swing, watch_tension
from crane_sim.simulation.settling import is_outside
from crane_sim.stepping.periods import BriefOutput


class LaneBuffers(NamedTuple):
    """Instants side by side."""

    joints: Any  # (2 nq + nu, LANES), positions, velocities and efforts
    observed: Any  # (9, LANES), see `system.observe`
    supplied: Any  # (1, LANES) J
    swung: Any  # (2, LANES), by how much ropes swing further than before: in the run, and in its last part
    least: Any  # (2 nq + nu + 6, LANES), the least values of instants in these lanes, see `values_of`
    pushed: Any  # (1, LANES), instants at which the link pushed


def lane_buffers(nq: int, nu: int) -> LaneBuffers:
    """Return the buffers of cranes with nq joints, nu of them actuated."""
    joints = 2 * nq + nu
    return LaneBuffers(*(np.empty((n, LANES)) for n in (joints, 9, 1, 2, joints + 6, 1)))


@output_of.register(LaneBuffers)
def _(lanes, scratch):
    return BriefOutput(scratch.rows, scratch.commands, np.empty(0), np.empty((0, scratch.rows.shape[1])))


@watch_run.register(LaneBuffers)
def _(lanes, p, clock, run, scratch, states):
    k, nq = run.counts[1], len(run.q)
    q, v = system.joints(p, system.state(p, 0.0, run.q, run.v))
    u = system.efforts_from_row(p, scratch.rows[0, 2 * nq :])
    whole, like = k - k % LANES, (q, v, u)
    for j in range(LANES):
        lanes.pushed[0, j] = 0.0
        for c in range(len(lanes.least)):
            lanes.least[c, j] = np.inf
    for first in range(0, whole, LANES):
        load_block(clock, run, scratch, first, states)
        watch_block(p, like, clock, run, scratch, first)
        watch_swings(run.peaks, clock, scratch, first)
    join_lanes(run, lanes)
    observe_instants(p, like, scratch, whole, k)
    for i in range(whole, k + 1):
        watch_instant(clock, run, scratch, i, i - whole, states[i])
    note_last_outside(run, scratch)
    for j in range(6):
        scratch.ends[k, j] = lanes.observed[3 + j, k % LANES]


@lean_routine
def load_block(clock, run, scratch, first, states):
    """Put the instants from number `first` on into the lanes, and copy their states; add up the work up to each."""
    nq, nu, lanes = len(run.q), len(run.target), scratch.lanes
    for j in range(LANES):
        i = first + j
        row, driven_q = scratch.rows[i], scratch.driven_q[i]
        states[i, 0] = scratch.times[i]
        for c in range(2 * nq):
            states[i, 1 + c] = lanes.joints[c, j] = row[c]
        for c in range(2 * nq, 2 * nq + nu):
            lanes.joints[c, j] = row[c]
        for c in range(nu):
            driven_q[c] = row[scratch.driven[c]]
        u, supplied = row[2 * nq : 2 * nq + nu], row[2 * nq + nu]
        lanes.supplied[0, j] = work_instant(run.balance, clock.metered, driven_q, u, supplied)


@lean_routine
def watch_block(p, like, clock, run, scratch, first):
    """Gather the figures of LANES instants side by side; `like`: joints and efforts of one."""
    use_wide_vectors()
    lanes, start = scratch.lanes, (run.balance.start[0], run.balance.start[1])
    largest = run.peaks.swing
    sizes = (
        np.sqrt(largest[0, 0] * largest[0, 0] + largest[0, 1] * largest[0, 1]),
        np.sqrt(largest[1, 0] * largest[1, 0] + largest[1, 1] * largest[1, 1]),
    )
    heights = largest[0, 2], largest[1, 2]
    for j in range(LANES):
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


@lean_kernel
def values_of(q, u, observed, start, supplied):
    """Return what is watched of an instant as values whose least ones count."""
    (kinetic, potential), tension, _, _ = observed
    error = kinetic + potential - start[0] - (start[1] + supplied)
    energies = -abs(error), -kinetic, potential, -potential
    return q, scale(-1.0, q), smaller(u, scale(-1.0, u)), energies, tension, -tension


@lean_routine
def watch_swings(peaks, clock, scratch, first):
    """Take the ropes of a block into the peaks, where one of them swings further than before it."""
    seen, swung, last = scratch.lanes.observed, scratch.lanes.swung, scratch.times[first + LANES - 1]
    further = False
    for j in range(LANES):
        further = further or swung[0, j] > 0.0 or (last >= clock.late and swung[1, j] > 0.0)
    for j in range(LANES if further else 0):
        rope = seen[6, j] - seen[3, j], seen[7, j] - seen[4, j], seen[8, j] - seen[5, j]
        watch_swing(peaks, scratch.times[first + j], clock.late, rope)


@lean_routine
def note_last_outside(run, scratch):
    """Note when joints were last not near their targets: from the end on, which most have reached long before."""
    for c in range(len(run.target)):
        for i in range(run.counts[1] - 1, -1, -1):
            if is_outside(run.target[c], run.near[c], scratch.driven_q[i, c]):
                run.outside[c] = scratch.times[i]
                break


@lean_routine
def join_lanes(run, lanes):
    """Take the least values of all lanes into the figures of the run."""
    nq, nu, least, extremes = len(run.q), len(run.target), lanes.least, run.balance.extremes
    after = 2 * nq + nu
    for j in range(LANES):
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


@lean_routine
def observe_instants(p, like, scratch, first, last):
    """Observe the instants from number `first` on, none beyond `last`, in lanes; `like`: joints and efforts of one."""
    use_wide_vectors()
    joints, observed = scratch.lanes.joints, scratch.lanes.observed
    for j in range(LANES):
        row = scratch.rows[min(first + j, last)]
        for c in range(len(joints)):
            joints[c, j] = row[c]
    for j in range(LANES):
        q, v, u = lane(like, joints, j)
        put_lane(observed, j, system.observe(p, scratch.times[min(first + j, last)], q, v, u))


@lean_kernel
def watch_instant(clock, run, scratch, i, j, state):
    """Gather the figures of instant i, which is in lane j, and copy its state."""
    row, driven_q, seen = scratch.rows[i], scratch.driven_q[i], scratch.lanes.observed
    t, nq, nu = scratch.times[i], len(run.q), len(run.target)
    state[0] = t
    for c in range(2 * nq):
        state[1 + c] = row[c]
    for c in range(nu):
        driven_q[c] = row[scratch.driven[c]]
    note_range_at(row[:nq], run.ranges[0], run.ranges[1])
    if i < run.counts[1]:
        u, supplied = row[2 * nq : 2 * nq + nu], row[2 * nq + nu]
        balance_instant(run.balance, clock.metered, driven_q, u, supplied, seen[0, j], seen[1, j])
        watch_tension(run.peaks, seen[2, j], seen[2, j])
        rope = seen[6, j] - seen[3, j], seen[7, j] - seen[4, j], seen[8, j] - seen[5, j]
        watch_swing(run.peaks, t, clock.late, rope)
        watch_efforts(run.peaks, u)
