"""Integrators know no crane: they ask `crane_sim.system.rhs` for derivatives and never see a field name.

A method is a NamedTuple of its settings; its type chooses the kernels. A method answers `step` (one step of a given
size) and, when it controls its error, `advance` (one accepted step of a size it chooses).
"""

from crane_sim.integrators.events import CHATTER, STOPPED, Seen, apply_pending_events, handle_events, make_event_log
from crane_sim.integrators.integration import (
    ENDLESS,
    NOT_FINITE,
    OK,
    STALLED,
    Integration,
    advance,
    dense_output,
    max_steps,
    scratch,
    stages,
    start,
    step,
    step_bound,
    with_status,
)
from crane_sim.numerics.jit import kernel
from crane_sim.system import switching

__all__ = [
    "CHATTER",
    "ENDLESS",
    "NOT_FINITE",
    "OK",
    "STALLED",
    "STOPPED",
    "Integration",
    "Seen",
    "advance",
    "step_bound",
    "handle_events",
    "reach",
    "make_event_log",
    "scratch",
    "apply_pending_events",
    "stages",
    "start",
    "dense_output",
    "step",
]


@kernel
def reach(method, p, u, flow, t, end):
    """Return the flow advanced until it covers time t, by steps that do not pass `end`."""
    most = flow.steps + max_steps(method)
    while flow.t < t and flow.status == OK:
        flow = handle_events(switching(p), method, p, u, advance(method, p, u, flow, end))
        if flow.steps >= most and flow.t < t:
            flow = with_status(flow, ENDLESS)
    return flow
