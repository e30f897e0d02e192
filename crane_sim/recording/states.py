"""Timelines of discrete states during a run, such as those of brakes, ropes and faults.

A timeline is a list of changes of state. It follows from the steps of a run, from its metrics, or from its events;
messages of a plant add to it. It begins in its normal state ("released", "taut" …), and is recorded only if that
changes.
"""

from __future__ import annotations

import re
from collections import defaultdict
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Block, Layout

    Array = NDArray[np.float64]
    StepChanges = tuple[str, NDArray[np.int64], list[str]]  # timeline, steps at which it changes, states from then on

Changes = list[tuple[float, str]]  # (s, state from then on), in the order of time

BRAKES, EFFORTS, CONTACT = "brakes", "efforts", "contact"
CONTROLLER, COMMANDS, STOP, SIMULATION = "controller", "commands", "emergency stop", "simulation"
"""Names of timelines; those in the line above from messages of a plant."""
MIN_FORCE = 1e-6  # N: smaller tensions and forces are rounding errors of 0

NORMAL_COLOR, STOPPING_COLOR, FAULT_COLOR = "#c3cad1", "#c8332b", "#9450b3"
WARNING_COLOR, CONTACT_COLOR, OTHER_COLOR = "#d9730d", "#2a9d5c", "#1f6fb4"
_STATES = {
    NORMAL_COLOR: "released, off, taut, free, apart, clear, answers, accepted, playing, stopped, quitting, moves, "
    "slips forwards, slips backwards, meshes, pushes forwards, pushes backwards, does not push any more",
    WARNING_COLOR: "slack, limited, refused, paused, is in its play",
    STOPPING_COLOR: "acting, pressed, pushes, tripped, silent",
    FAULT_COLOR: "on",
    CONTACT_COLOR: "touches",
}
COLORS = {state: color for color, states in _STATES.items() for state in states.split(", ")}
"""Colours of states, on white paper; others, such as masses of a payload, have `OTHER_COLOR`."""

EVENTS = (
    (re.compile(r"the (?P<name>.+) (?P<state>sticks)"), "friction of the {}", "moves"),
    (re.compile(r"the (?P<name>.+) (?P<state>slips forwards|slips backwards)"), "friction of the {}", "sticks"),
    (re.compile(r"(?P<name>drive \d+ of the \S+) (?P<state>is in .*|pushes .*|does not .*)"), "{}", "meshes"),
    (
        re.compile(r"payload of .* (?P<name>)(?:let go|taken up), (?P<state>.* kg) hang now"),
        "payload",
        "as at the start",
    ),
)
"""Events that change a state: pattern, name of the timeline, and its state before, where it is the first one."""


class LimitSwitches(NamedTuple):
    """Positions of the limit switches of the actuated joints."""

    low: Array  # (nu,) m or rad, infinite without one
    high: Array


class TimelineInputs(NamedTuple):
    """Inputs of timelines other than the steps of a run."""

    limit_switches: LimitSwitches | None  # None without any
    only_limits_change_efforts: bool  # an applied effort differs from its command only where a limit acts


def make_timeline_inputs(hardware: Any) -> TimelineInputs:
    """Return the inputs of timelines from a scene's `HardwareConfig`, None for ideal drives."""
    if hardware is None:
        return TimelineInputs(None, True)
    drives = hardware.drives
    switches = LimitSwitches(np.array(drives.switch_low), np.array(drives.switch_high))
    has_switches = bool(np.isfinite([switches.low, switches.high]).any())
    return TimelineInputs(switches if has_switches else None, bool(hardware.ideal))


class StateTimelines:
    """The last states of a run's timelines, from which their changes follow."""

    def __init__(self, layout: Layout) -> None:
        """Begin before the first step, all in their normal states."""
        self._layout, self._inputs = layout, layout.timeline_inputs
        self._last: dict[str, str] = {}
        self._tripped = np.zeros(len(layout.actuated), dtype=bool)

    def find_changes(self, block: Block) -> Iterator[StepChanges]:
        """Yield (timeline, steps at which its state changes, the states from then on) of the next block."""
        for timeline, normal, other, where in self._evaluate(block):
            yield from self._compare(timeline, normal, block.step, np.where(where, other, normal))

    def find_change(self, timeline: str, normal: str, step: int, state: str) -> Iterator[StepChanges]:
        """Yield the change of a timeline, which begins in the state `normal`, at one step, as `find_changes` does."""
        yield from self._compare(timeline, normal, np.array([step]), np.array([state]))

    def _compare(self, timeline: str, normal: str, step: NDArray[np.int64], values: Any) -> Iterator[StepChanges]:
        known = timeline in self._last
        before = np.concatenate([[self._last.get(timeline, normal)], values[:-1]])
        rows = np.flatnonzero(values != before)
        if not rows.size:
            return
        self._last[timeline] = str(values[-1])
        steps, states = step[rows], [str(state) for state in values[rows]]
        if not known and steps[0] > 1:
            steps, states = np.concatenate([[1], steps]), [normal, *states]
        yield timeline, steps, states

    def _evaluate(self, block: Block) -> Iterator[tuple[str, str, Any, Any]]:
        """Yield (timeline, normal state, the other one, whether it is in that one (K,)) for the steps of a block."""
        layout = self._layout
        if layout.actuated and layout.commanded:
            yield BRAKES, "released", "acting", block.braked
        if layout.actuated and self._inputs.only_limits_change_efforts and layout.effort_units == layout.command_units:
            differs = np.isfinite(block.demanded) & (block.demanded != block.effort)
            yield EFFORTS, "free", "limited", differs.any(axis=1)
        for name, tension in zip(layout.ropes.tensions, block.tensions.T, strict=True):
            pushing = tension < -MIN_FORCE
            yield _short(name), "taut", np.where(pushing, "pushes", "slack"), tension <= MIN_FORCE
        if block.contact is not None:
            yield CONTACT, "apart", "touches", block.contact > MIN_FORCE
        yield from self._limit_switches(block)

    def _limit_switches(self, block: Block) -> Iterator[tuple[str, str, str, Any]]:
        """Yield the timelines of limit switches; a switch that has tripped stays so."""
        if self._inputs.limit_switches is None:
            return
        q, (low, high) = block.q[:, self._layout.driven], self._inputs.limit_switches
        tripped = np.logical_or.accumulate((q > high) | (q < low), axis=0) | self._tripped
        self._tripped = tripped[-1]
        for name, each in zip(self._layout.actuated, tripped.T, strict=True):
            yield f"limit switch of the {name}", "clear", "tripped", each


def _short(name: str) -> str:
    """Return the name of a link, a fall or the only rope, from that of its tension."""
    return {"rope tension": "rope", "tension of the top link": "link 1", "tension of fall 1": "fall 1"}.get(name, name)


def make_fault_timelines(summary: Mapping[str, Any]) -> dict[str, Changes]:
    """Return the timelines of faults by name, from the metrics of a run."""
    timelines: dict[str, Changes] = defaultdict(lambda: [(0.0, "off")])
    for each in summary.get("faults", ()):
        timelines[f"fault {each['name']}"].append((float(each["t"]), "on" if each["on"] else "off"))
    return dict(timelines)


def make_event_timelines(events: Sequence[tuple[float, str]]) -> dict[str, Changes]:
    """Return the timelines by name that follow from events [s, text]: of friction, drives with play, the payload."""
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
    """Return the spans of a timeline between two times [s]; those that follow each other have different states.

    A span shorter than `min_duration` [s] is merged into the one before it, unless that one's state is normal: a short
    departure from the normal state stays visible.
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
