"""Compiled loops between given instants, under held commands, for comparison with measured runs."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim import system
from crane_sim.hardware.drives import (
    Drives,
    accept_command,
    effort_at,
    latch_efforts,
    next_breakpoint,
)
from crane_sim.integrators import OK, apply_pending_events, integrate_to, make_event_log, start
from crane_sim.numerics.derivatives import directional_derivatives
from crane_sim.numerics.jit import entry_point, routine

# from instant to instant, above which an integration is given up: it is near a singularity
MEAN_STEPS = 1000


class Excitation(NamedTuple):
    """Instants at which a command changes or the state is wanted, and the part to integrate."""

    times: Any  # (n,) s, increasing
    commands: Any  # (n, nu), each held from its instant to the next
    first: int  # instant of the initial state
    last: int  # at which the integration ends
    low: Any  # (nq,) least joint positions: beyond them it ends before
    high: Any  # (nq,)


@routine
def start_at(p, excitation, q, v):
    """Return the integration from the first instant on, with joint states q, v (nq,)."""
    t = excitation.times[excitation.first]
    return start(
        p, t, system.project(p, system.state(p, t, q, v)), make_event_log(system.switching(p))
    )


def write_positions(excitation, p, integration, out, i):
    """Write the joint positions (nq,) into out[i]; return whether the integration may go on."""
    if integration.t < excitation.times[i] or integration.steps > MEAN_STEPS * (
        i - excitation.first + 1
    ):
        return False
    q, _ = system.joints(p, integration.x)
    inside = True
    for j in range(len(q)):
        out[i, j] = q[j]
        inside = inside and excitation.low[j] <= q[j] <= excitation.high[j]
    return inside and integration.status == OK


@entry_point
def integrate_held(method, p, excitation, q, v, out):
    """Integrate with efforts that are the commands after limits.

    Args:
        method, p: settings of the integrator, parameters.
        excitation: `Excitation`.
        q, v: joint positions and velocities (nq,) at its first instant.
        out: (n, nq) to fill with the joint positions at its instants, `first` to `last`.

    Returns:
        the last instant that was reached
    """
    times = excitation.times
    integration = start_at(p, excitation, q, v)
    write_positions(excitation, p, integration, out, excitation.first)
    for i in range(excitation.first, excitation.last):
        u = system.saturate(p, system.efforts_from_row(p, excitation.commands[i]))
        integration = apply_pending_events(system.switching(p), p, u, integration)
        integration = integrate_to(method, p, u, integration, times[i + 1], times[i + 1])
        if not write_positions(excitation, p, integration, out, i + 1):
            return i
    return excitation.last


@entry_point
def differentiate_held(method, p, excitation, q, v, out, directions):
    """Integrate as `integrate_held` does, and fill derivatives of what it fills.

    Args:
        method, p, excitation, q, v, out: of `integrate_held`.
        directions: of p, q and v, see `directional_derivatives`, and (n, nq, DIRECTIONS) to fill.

    Returns:
        the last instant that was reached
    """
    of_model, of_q, of_v, slopes = directions
    given, seeds = (method, p, excitation, q, v, out), (None, of_model, None, of_q, of_v, slopes)
    return directional_derivatives(integrate_held, given, seeds)[0]


@entry_point
def integrate_with_drives(method, p, drives, servos, excitation, q, v, out):
    """Integrate with drives that follow the commands; otherwise as `integrate_held`.

    Before the first instant only the drives move: what they apply is a function of the commands
    alone.

    Args:
        drives: records of `DRIVE` (nu,) without delay, which are changed.
        servos: `servos.Servos`, None where all drives are commanded efforts; with them `first` must
            be 0.
    """
    times, queue = excitation.times, np.zeros((1, len(drives)))
    integration = start_at(p, excitation, q, v)
    write_positions(excitation, p, integration, out, excitation.first)
    for i in range(excitation.last):
        u = Drives(times[i], drives, servos, None)
        accept_command(
            p, u, integration.x, queue, i, system.efforts_from_row(p, excitation.commands[i])
        )
        if i < excitation.first:
            for j in range(len(drives)):
                drives[j].start_effort = effort_at(drives[j], times[i + 1] - times[i])
            continue
        integration = apply_pending_events(system.switching(p), p, u, integration)
        while integration.status == OK and integration.t < times[i + 1]:
            break_time = next_breakpoint(u, integration.t, times[i + 1])
            integration = integrate_to(method, p, u, integration, break_time, break_time)
        latch_efforts(p, u, integration.t, integration.x)
        if not write_positions(excitation, p, integration, out, i + 1):
            return i
    return excitation.last
