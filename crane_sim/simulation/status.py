"""Status of a run, and its events."""

from collections.abc import Sequence
from typing import Any

from crane_sim import system
from crane_sim.integrators import Status

MAX_EVENTS_IN_SUMMARY = 20
"""Events in the summary."""


class SimulationError(RuntimeError):
    """The simulation cannot go on; the message is one line with the time and the cause.

    Attributes:
        run: the Rollout up to there, where `simulate` raised it.
    """

    run: Any = None


def check_status(integration: Any, model: Any) -> None:
    """Raise SimulationError when the integration has failed, or the model is no longer valid."""
    line = describe_failure(model, integration.status, integration.terminal_guard, integration.t)
    if line is not None:
        raise SimulationError(line)


def describe_failure(model: Any, status: int, terminal_guard: int, t: float) -> str | None:
    """Return why an integration ended with this status at t [s]; None for one that goes on.

    `terminal_guard` is the guard that ended it.
    """
    if status == Status.OK:
        return None
    cause, remedy = Status(status).cause, "check the scene's parameters and steps"
    if status == Status.TERMINATED:
        cause, remedy = system.describe_event(model, terminal_guard)
    return f"stopped at t = {t:.6g} s: {cause}; {remedy}"


def events_of(
    integration: Any, model: Any, end: float, failed: bool = False
) -> list[tuple[float, str]]:
    """Return (time [s], what happened) of every event that was kept, in the order of time.

    Steps that follow the solution may reach beyond `end` [s], the end of the last whole period:
    what happens there is part of a run that `failed` in the period after it, and of no other.
    """
    if integration.event_log is None:
        return []
    rows = integration.event_log.rows[
        : min(integration.event_log.total, len(integration.event_log.rows))
    ]
    last = integration.t if failed else end
    return [
        (float(t), system.describe_event(model, int(which))[0]) for t, which in rows if t <= last
    ]


def noted_events(integration: Any, model: Any, end: float, failed: bool = False) -> dict[str, Any]:
    """Return the events for the summary: the first ones, their number, kinds if there are more.

    Nothing of a model without events.
    """
    if integration.event_log is None:
        return {}
    events = events_of(integration, model, end, failed)
    unkept = max(0, integration.event_log.total - len(integration.event_log.rows))
    kinds = {"event_kinds": list_kinds(events)} if len(events) > MAX_EVENTS_IN_SUMMARY else {}
    return {
        "events": [{"t": t, "what": what} for t, what in events[:MAX_EVENTS_IN_SUMMARY]],
        "event_count": len(events) + unkept,
    } | kinds


def list_kinds(events: Sequence[tuple[float, str]]) -> list[dict[str, Any]]:
    """Return what happened, how often, and when first and last [s], ordered by first time."""
    kinds: dict[str, dict[str, Any]] = {}
    for t, what in events:
        kind = kinds.setdefault(what, {"what": what, "count": 0, "first": t, "last": t})
        kind["count"], kind["last"] = kind["count"] + 1, t
    return list(kinds.values())
