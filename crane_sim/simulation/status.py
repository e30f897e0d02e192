"""How a run ended, and what happened on the way."""

from typing import Any

from crane_sim import system
from crane_sim.integrators import CHATTER, ENDLESS, NOT_FINITE, OK, STALLED, STOPPED

SHOWN = 20
"""Events in the summary."""


class SimulationError(RuntimeError):
    """The simulation cannot go on; the message is one line with the time and the cause.

    Attributes:
        run: the Rollout up to there, where `simulate` raised it.
    """

    run: Any = None


_CAUSES = {
    NOT_FINITE: "the state is not finite",
    ENDLESS: "the motion has become too fast to follow",
    STALLED: "the step size shrank to nothing",
    CHATTER: "the equations switch back and forth without end",
}


def check_status(flow: Any, model: Any) -> None:
    """Raise SimulationError when the integration under way has failed, or the model is no longer valid."""
    if flow.status == OK:
        return
    cause, remedy = _CAUSES.get(flow.status, ""), "check the scene's parameters and steps"
    if flow.status >= STOPPED:
        cause, remedy = system.describe_event(model, flow.status - STOPPED)
    raise SimulationError(f"stopped at t = {flow.t:.6g} s: {cause}; {remedy}")


def events_of(flow: Any, model: Any, end: float) -> list[tuple[float, str]]:
    """Return (time [s], what happened) of every event that was kept, in the order of time.

    Steps that follow the solution may reach beyond `end` [s]: what happens there is not part of the run, unless it is
    what ended it.
    """
    if flow.seen is None:
        return []
    rows = flow.seen.rows[: min(flow.seen.total, len(flow.seen.rows))]
    last = end if flow.status == OK else flow.t
    return [(float(t), system.describe_event(model, int(which))[0]) for t, which in rows if t <= last]


def noted_events(flow: Any, model: Any, end: float) -> dict[str, Any]:
    """Return the first events and their number for the summary; nothing for a model that does not switch."""
    if flow.seen is None:
        return {}
    events = events_of(flow, model, end)
    unkept = max(0, flow.seen.total - len(flow.seen.rows))
    return {"events": [{"t": t, "what": what} for t, what in events[:SHOWN]], "event_count": len(events) + unkept}
