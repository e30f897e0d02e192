"""Integrators know no crane: they ask `crane_sim.system.rhs` for derivatives and never see a field name.

A method is a NamedTuple of its settings; its type chooses the kernels. A method answers `step` (one step of a given
size) and, when it controls its error, `advance` (one accepted step of a size it chooses).
"""

from crane_sim.integrators.events import CHATTER, STOPPED, Seen, located, record, settled
from crane_sim.integrators.integration import (
    ENDLESS,
    NOT_FINITE,
    OK,
    STALLED,
    Flow,
    advance,
    horizon,
    patience,
    scratch,
    stages,
    start,
    state_at,
    step,
    stopped,
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
    "Flow",
    "Seen",
    "advance",
    "horizon",
    "located",
    "reach",
    "record",
    "scratch",
    "settled",
    "stages",
    "start",
    "state_at",
    "step",
]


@kernel
def reach(method, p, u, flow, t, end):
    """Return the flow advanced until it covers time t, by steps that do not pass `end`."""
    most = flow.steps + patience(method)
    while flow.t < t and flow.status == OK:
        flow = located(switching(p), method, p, u, advance(method, p, u, flow, end))
        if flow.steps >= most and flow.t < t:
            flow = stopped(flow, ENDLESS)
    return flow
