"""How a run ended, and what happened on the way."""

from typing import Any

from crane_sim import system
from crane_sim.integrators import Status

SHOWN = 20
"""Events in the summary."""


class SimulationError(RuntimeError):
    """The simulation cannot go on; the message is one line with the time and the cause.

    Attributes:
        run: the Rollout up to there, where `simulate` raised it.
    """

    run: Any = None


def check_status(flow: Any, model: Any) -> None:
    """Raise SimulationError when the integration under way has failed, or the model is no longer valid."""
    if flow.status == Status.OK:
        return
    cause, remedy = Status(flow.status).cause, "check the scene's parameters and steps"
    if flow.status == Status.TERMINATED:
        cause, remedy = system.describe_event(model, flow.terminal_guard)
    raise SimulationError(f"stopped at t = {flow.t:.6g} s: {cause}; {remedy}")


def events_of(flow: Any, model: Any, end: float) -> list[tuple[float, str]]:
    """Return (time [s], what happened) of every event that was kept, in the order of time.

    Steps that follow the solution may reach beyond `end` [s]: what happens there is not part of the run, unless it is
    what ended it.
    """
    if flow.event_log is None:
        return []
    rows = flow.event_log.rows[: min(flow.event_log.total, len(flow.event_log.rows))]
    last = end if flow.status == Status.OK else flow.t
    return [(float(t), system.describe_event(model, int(which))[0]) for t, which in rows if t <= last]


def noted_events(flow: Any, model: Any, end: float) -> dict[str, Any]:
    """Return the first events and their number for the summary; nothing for a model that does not switch."""
    if flow.event_log is None:
        return {}
    events = events_of(flow, model, end)
    unkept = max(0, flow.event_log.total - len(flow.event_log.rows))
    return {"events": [{"t": t, "what": what} for t, what in events[:SHOWN]], "event_count": len(events) + unkept}
