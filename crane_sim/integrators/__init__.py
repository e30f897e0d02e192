"""Integrators: independent of crane models, whose derivatives they get from `crane_sim.system.rhs`.

A method is a NamedTuple of its settings (`integration.Method`).
"""

from crane_sim.integrators.array_steps import integrate_to
from crane_sim.integrators.events import (
    EventLog,
    apply_pending_events,
    handle_events,
    make_event_log,
    restart,
)
from crane_sim.integrators.integration import Integration, dense_output, scratch, start, step
from crane_sim.integrators.status import OK, Status
from crane_sim.integrators.step_control import advance, latest_step_end

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
    "start",
    "step",
    "latest_step_end",
]
