"""Sensors: measured joint positions and velocities, for laws and topics.

At a period whose number is a multiple of `every` a sensor takes a sample: the truth plus bias and
noise, rounded to its step; some samples are lost, and the last one is held. The output is `delay`
periods old. Random numbers are functions of the period's number (`random`).
"""

from math import floor

from crane_sim.hardware.random import normal, uniform
from crane_sim.numerics.jit import routine

STREAMS = 3  # of random numbers, for each sensor


def take_sample(seed, sensor, j, k):
    """Return a sample of sensor number j at period k."""
    value = sensor.truth + sensor.bias
    if sensor.noise > 0.0:
        value += sensor.noise * normal(seed, STREAMS * j, k)
    step = sensor.quantum
    return step * floor(value / step + 0.5) if step > 0.0 else value


@routine
def sense(seed, sensors, ring, k, q, v):
    """Sample the joints at period k and update sensors; return the number of lost samples.

    Args:
        seed: uint64.
        sensors: records of the positions' sensors, then of the velocities' (2 nq,).
        ring: the last samples (depth, 2 nq), as many as the longest delay needs.
        k: number of the period that begins.
        q, v: joint positions and velocities (nq,).
    """
    nq, depth, losses = len(q), len(ring), 0
    for j in range(nq):
        sensors[j].truth, sensors[j + nq].truth = q[j], v[j]
    for j in range(2 * nq):
        sensor = sensors[j]
        due = k % sensor.every == 0
        lost = due and k > 0 and uniform(seed, STREAMS * j + 2, k) < sensor.dropout
        losses += 1 if lost else 0
        if due and not lost:
            sensor.sample = take_sample(seed, sensor, j, k)
        ring[k % depth, j] = sensor.sample
        if k == 0:  # before the start the output was the first sample
            ring[:, j] = sensor.sample
        if not sensor.stuck:
            sensor.reading = ring[(k - sensor.delay) % depth, j]
        if sensor.lost:
            sensor.reading = 0.0
    return losses
