"""The compiled loop over many cranes in the lanes of vectors, for methods whose steps are all of one size.

The steps are those of `simulate`, lane for lane, in all bits.
"""

from math import isfinite

import numpy as np

from crane_sim.batch_loops import Sampled, demanded, note, started
from crane_sim.integrators import NOT_FINITE, OK, Flow, stages, start, state_at, step
from crane_sim.integrators.flow import even_step
from crane_sim.jit import entry, generic, kernel, routine
from crane_sim.lane_algebra import LANES, lane, picked, put_lane, use_wide_vectors
from crane_sim.state_algebra import dimension, weighted_square
from crane_sim.stepping import finish, write


@entry
def pass_lanes(method, cranes, clock, places, first, last):
    """Pass the whole time of cranes `first` to `last` (not included), whole blocks of LANES.

    A crane whose state does not stay finite is noted as such, without when: pass it alone.

    Args:
        method: of a fixed step, the same for all cranes.
        cranes: columns of `Driven` whose models do not switch.
        clock, places, first, last: as of `batch_loops.pass_cranes`.
    """
    use_wide_vectors()
    for block in range(first, last, LANES):
        like = first_lane(cranes, places, block)
        xs, us = np.empty((dimension(like[0]), LANES)), np.empty((len(like[1]), LANES))
        for j in range(LANES):
            put_lane(xs, j, started(picked(cranes, block + j).model, places, block + j))
        t, taken, i = 0.0, 0, 0
        for k in range(clock.steps):
            for j in range(LANES):
                crane = picked(cranes, block + j)
                put_lane(us, j, held(crane.source, crane.model, k * clock.period, lane(like[0], xs, j)))
            end = (k + 1) * clock.period
            while t < end:
                h, after = even_step(method.step, t, end)
                while i < len(clock.times) and clock.times[i] < after:
                    for j in range(LANES):
                        crane, x, u = picked(cranes, block + j), lane(like[0], xs, j), lane(like[1], us, j)
                        sample(method, crane, x, u, t, clock.times[i], places.rows[block + j], i)
                    i += 1
                for j in range(LANES):  # the loop that becomes vector instructions
                    crane, x = picked(cranes, block + j), lane(like[0], xs, j)
                    x = step(method, crane.model, t, x, driving(crane.source, lane(like[1], us, j)), h, None)
                    put_lane(xs, j, x)
                t, taken = after, taken + 1
        for j in range(LANES):
            crane, x, u = picked(cranes, block + j), lane(like[0], xs, j), lane(like[1], us, j)
            end_lane(method, crane, x, u, clock, places, block + j, taken, i)


@kernel
def first_lane(cranes, places, block):
    """Return (state, held efforts) of the first crane of a block: what the lanes look like."""
    crane = picked(cranes, block)
    x = started(crane.model, places, block)
    return x, held(crane.source, crane.model, 0.0, x)


@generic
def held(source, p, t, x):
    """Return the efforts that are held from time t on as a tuple; empty where the equations evaluate the source."""
    return ()


@held.register(Sampled)
def _(source, p, t, x):
    return demanded(source, p, t, x)


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
    write(rows, i, crane.model, time, state_at(method, crane.model, u, flow, time), u)


@routine
def end_lane(method, crane, x, efforts, clock, places, i, taken, sampled):
    """Write the rows of crane i from number `sampled` on, in state x at the end, and note how its run went."""
    end, rows, u = clock.steps * clock.period, places.rows[i], driving(crane.source, efforts)
    status = OK if isfinite(weighted_square(x, x, x, 0.0, 1.0)) else NOT_FINITE
    flow = Flow(end, x, end, x, 0.0, taken * stages(method), taken, 0, status, None, None)
    finish(method, crane.model, u, flow, end, rows, clock.times, rows[: len(clock.times)], sampled)
    note(crane.model, clock, places, i, flow, clock.steps)
