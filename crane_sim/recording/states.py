"""Timelines of discrete states during a run, such as those of brakes, ropes and faults.

A timeline is a list of changes of state. It follows from the steps of a run, from its metrics, or
from its events; messages of a plant add to it. It begins in its normal state ("released", "taut"
…), and is recorded only if that changes.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

Changes = list[tuple[float, str]]  # (s, state from then on), in the order of time

BRAKES, EFFORTS, CONTACT = "brakes", "efforts", "contact"
CONTROLLER, COMMANDS, STOP, SIMULATION = "controller", "commands", "emergency stop", "simulation"
"""Names of timelines; those in the line above from messages of a plant."""
MIN_FORCE = 1e-6  # N: smaller tensions and forces are rounding errors of 0

NORMAL_COLOR, STOPPING_COLOR, FAULT_COLOR = "#c3cad1", "#c8332b", "#9450b3"
WARNING_COLOR, CONTACT_COLOR, OTHER_COLOR = "#d9730d", "#2a9d5c", "#1f6fb4"
_STATES = {
    NORMAL_COLOR: "released, off, taut, free, apart, clear, answers, accepted, playing, stopped, "
    "quitting, moves, "
    "slips forwards, slips backwards, meshes, pushes forwards, pushes backwards, does not push any "
    "more",
    WARNING_COLOR: "slack, limited, refused, paused, is in its play",
    STOPPING_COLOR: "acting, pressed, pushes, tripped, silent",
    FAULT_COLOR: "on",
    CONTACT_COLOR: "touches",
}
COLORS = {state: color for color, states in _STATES.items() for state in states.split(", ")}
"""Colours of states, on white paper; others, such as masses of a payload, have `OTHER_COLOR`."""

EVENTS = (
    (re.compile(r"the (?P<name>.+) (?P<state>sticks)"), "friction of the {}", "moves"),
    (
        re.compile(r"the (?P<name>.+) (?P<state>slips forwards|slips backwards)"),
        "friction of the {}",
        "sticks",
    ),
    (
        re.compile(r"(?P<name>drive \d+ of the \S+) (?P<state>is in .*|pushes .*|does not .*)"),
        "{}",
        "meshes",
    ),
    (
        re.compile(r"payload of .* (?P<name>)(?:let go|taken up), (?P<state>.* kg) hang now"),
        "payload",
        "as at the start",
    ),
)
"""Events that change a state: pattern, name of the timeline, and its state before, where it is the
first one."""


class LimitSwitches(NamedTuple):
    """Positions of the limit switches of the actuated joints."""

    low: Array  # (nu,) m or rad, infinite without one
    high: Array


class TimelineInputs(NamedTuple):
    """Inputs of timelines other than the steps of a run."""

    limit_switches: LimitSwitches | None  # None without any
    only_limits_change_efforts: bool  # an applied effort differs from its command only where a
    # limit acts


def make_timeline_inputs(hardware: Any) -> TimelineInputs:
    """Return the inputs of timelines from a scene's `HardwareConfig`, None for ideal drives."""
    if hardware is None:
        return TimelineInputs(None, True)
    drives = hardware.drives
    switches = LimitSwitches(np.array(drives.switch_low), np.array(drives.switch_high))
    has_switches = bool(np.isfinite([switches.low, switches.high]).any())
    return TimelineInputs(switches if has_switches else None, bool(hardware.ideal))


def make_fault_timelines(summary: Mapping[str, Any]) -> dict[str, Changes]:
    """Return the timelines of faults by name, from the metrics of a run."""
    timelines: dict[str, Changes] = defaultdict(lambda: [(0.0, "off")])
    for each in summary.get("faults", ()):
        timelines[f"fault {each['name']}"].append((float(each["t"]), "on" if each["on"] else "off"))
    return dict(timelines)


def make_event_timelines(events: Sequence[tuple[float, str]]) -> dict[str, Changes]:
    """Return the timelines by name from events [s, text]: friction, play in drives, payload."""
    timelines: dict[str, Changes] = {}
    for t, text in events:
        for pattern, name, first_state in EVENTS:
            if found := pattern.fullmatch(text):
                changes = timelines.setdefault(name.format(found["name"]), [(0.0, first_state)])
                changes.append((t, found["state"]))
    return timelines


def get_color(state: str) -> str:
    """Return the colour of a state, as #rrggbb."""
    return COLORS.get(state, OTHER_COLOR)


def is_normal(state: str) -> bool:
    """Return whether a state is one of normal operation, which pictures draw in grey."""
    return get_color(state) == NORMAL_COLOR


class Span(NamedTuple):
    """An interval of time in which a timeline keeps its state."""

    begin: float  # s
    end: float
    state: str


def make_spans(changes: Changes, begin: float, end: float, min_duration: float) -> list[Span]:
    """Return a timeline's spans between two times [s]; successive ones have different states.

    A span shorter than `min_duration` [s] is merged into the one before it, unless that one's state
    is normal: a short departure from the normal state stays visible.
    """
    times = [min(max(t, begin), end) for t, _ in changes] + [end]
    spans: list[Span] = []
    for (_, state), first, last in zip(changes, times[:-1], times[1:], strict=True):
        if last <= first:
            continue
        is_merged = spans and last - first < min_duration and not is_normal(spans[-1].state)
        if spans and (is_merged or spans[-1].state == state):
            spans[-1] = spans[-1]._replace(end=last)
        else:
            spans.append(Span(first, last, state))
    return spans
