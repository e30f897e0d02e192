"""Many cranes, each somewhere in its own run, advanced by one control period in one call.

The steps of each crane are those of `simulation.plant.Plant`, bit for bit.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.integrators import OK
from crane_sim.numerics.jit import entry_point
from crane_sim.numerics.lanes import put_entry, take_entry
from crane_sim.stepping.hardware_periods import hardware_period, laden, read_measurements
from crane_sim.stepping.periods import Output, hold_period


class Cranes(NamedTuple):
    """A crane under way; for many of them, each number and each array is a column."""

    method: Any
    model: Any
    hardware: Any  # `HardwareState`, None where all is ideal
    integration: Any


class CraneArrays(NamedTuple):
    """What n cranes show of their states, at the end of the last period that they finished."""

    periods: Any  # (n,) periods passed
    left_out: Any  # (n,) bool, cranes that are not advanced
    failed: Any  # (n,) whether the integration ended before the end of the period
    measured: Any  # (n, 2 nq), positions and velocities by the sensors, the true ones without
    tip: Any  # (n, 3) m, in the world
    payload: Any  # (n, 3) m
    rows: Any  # (n, width), of the last period's start, see `stepping.rows`


def advance_crane(crane, command, k, period, rows, i):
    """Return (integration, (q, v), measured (q, v)) after period k; write the row of its start."""
    method, model, hardware, integration = crane
    if hardware is None:
        integration, q, v, _ = hold_period(
            method, model, command, integration, (k + 1) * period, rows, i
        )
        return integration, (q, v), (q, v)
    out = Output(k + 1, rows, None, None, rows[0, :0], rows[:0])
    args = (None, command, integration, k, period, out, i, 0)
    integration, _, x, _ = hardware_period(method, model, hardware, *args)
    return (
        integration,
        system.joints(laden(model, hardware), x),
        read_measurements(model, hardware, x),
    )


@entry_point
def advance_cranes(cranes, commands, period, out, first, last):
    """Advance cranes `first` to `last` (excluded) by one period.

    Args:
        cranes: columns of `Cranes`, whose integrations and hardware change.
        commands: (n, nu), held over the period.
        period: s.
        out: `CraneArrays` to fill; of a crane that fails only `failed` and `rows` change.
        first, last: which cranes.
    """
    nq = out.measured.shape[1] // 2
    for i in range(first, last):
        if out.left_out[i]:
            continue
        crane, k = take_entry(cranes, i), out.periods[i]
        p, end = crane.model, (k + 1) * period
        command = system.efforts_from_row(p, commands[i])
        integration, joints, measured = advance_crane(crane, command, k, period, out.rows, i)
        put_entry(cranes.integration, i, integration)
        out.failed[i] = integration.status != OK and integration.t < end
        if not out.failed[i]:
            out.periods[i] = k + 1
            out.measured[i, :nq], out.measured[i, nq:] = measured
            points = np.empty((system.point_count(p), 3))
            system.points(p, end, system.state(p, end, joints[0], joints[1]), points)
            out.tip[i], out.payload[i] = points[system.tip_index(p)], points[-1]
