"""Integrators: independent of crane models, whose derivatives they get from `crane_sim.system.rhs`.

A method is a NamedTuple of its settings; its type chooses the functions. A method registers `step` (one step of a given
size) and, when it controls its error, `advance` (one accepted step of a size it chooses).
"""

from crane_sim.integrators.array_steps import take_smooth_steps, take_switching_steps
from crane_sim.integrators.events import EventLog, apply_pending_events, handle_events, make_event_log, restart
from crane_sim.integrators.integration import (
    Integration,
    advance,
    dense_output,
    latest_step_end,
    scratch,
    stages,
    start,
    step,
)
from crane_sim.integrators.status import OK, Status
from crane_sim.numerics.jit import generic
from crane_sim.system import switching

__all__ = [
    "OK",
    "EventLog",
    "Integration",
    "Status",
    "advance",
    "apply_pending_events",
    "dense_output",
    "handle_events",
    "make_event_log",
    "integrate_to",
    "restart",
    "scratch",
    "stages",
    "start",
    "step",
    "latest_step_end",
]


def integrate_to(method, p, u, integration, t, end):
    """Return the integration advanced until it covers time t [s], by steps that do not pass the instant `end` [s]."""
    return take_steps(switching(p), method, p, u, integration, t, end)


@generic
def take_steps(switches, method, p, u, integration, t, end):
    """Return the result of `integrate_to`; a step of a model that switches ends at its first event."""
    return take_switching_steps(integration.x, switches, method, p, u, integration, t, end)


@take_steps.register(type(None))
def _(switches, method, p, u, integration, t, end):
    return take_smooth_steps(integration.x, method, p, u, integration, t, end)
