"""Timelines of states: what of a run is in one of a few states at any time, such as brakes, ropes and faults.

The states of a track follow from the steps of a run, from its figures, or from its events; messages of a plant add to
them. A track begins calm and is recorded only if it ever leaves that state.
"""

from __future__ import annotations

import re
from collections import defaultdict
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import NDArray

    Numbers = NDArray[np.float64]

Changes = list[tuple[float, str]]  # (s, state from then on), in the order of time

BRAKES, EFFORTS, CONTACT = "brakes", "efforts", "contact"
CONTROLLER, COMMANDS, STOP, SIMULATION = "controller", "commands", "emergency stop", "simulation"
ZERO = 1e-6  # N: tensions and forces below it are rounding of nothing

CALM, STOPPING, FAILING, LOOSE, TOUCHING, OTHER = "#c3cad1", "#c8332b", "#9450b3", "#d9730d", "#2a9d5c", "#1f6fb4"
COLORS = {
    "released": CALM,
    "acting": STOPPING,
    "off": CALM,
    "on": FAILING,
    "pressed": STOPPING,
    "taut": CALM,
    "slack": LOOSE,
    "pushes": STOPPING,
    "free": CALM,
    "limited": LOOSE,
    "apart": CALM,
    "touches": TOUCHING,
    "clear": CALM,
    "tripped": STOPPING,
    "answers": CALM,
    "silent": STOPPING,
    "accepted": CALM,
    "refused": LOOSE,
    "playing": CALM,
    "paused": LOOSE,
    "stopped": CALM,
    "quitting": CALM,
    "moves": CALM,
    "sticks": OTHER,
    "slips forwards": CALM,
    "slips backwards": CALM,
    "meshes": CALM,
    "pushes forwards": CALM,
    "pushes backwards": CALM,
    "is in its play": LOOSE,
    "does not push any more": CALM,
}
"""Colours of states, on white paper; of others, such as masses of a payload, `OTHER`."""

EVENTS = (
    (re.compile(r"the (?P<name>.+) (?P<state>sticks|slips forwards|slips backwards)"), "friction of the {}", "moves"),
    (re.compile(r"(?P<name>drive \d+ of the \S+) (?P<state>is in .*|pushes .*|does not .*)"), "{}", "meshes"),
    (
        re.compile(r"payload of .* (?P<name>)(?:let go|taken up), (?P<state>.* kg) hang now"),
        "payload",
        "as at the start",
    ),
)
"""Events that change a state: pattern, name of the track, and its state before the first one."""


class Switches(NamedTuple):
    """Limit switches of the actuated joints."""

    low: Numbers  # (nu,) m or rad, infinite without one
    high: Numbers


class Rules(NamedTuple):
    """What states follow from, beside a run's steps."""

    switches: Switches | None  # None without any
    limited: bool  # efforts differ from commands only where they are limited


def rules_of(hardware: Any) -> Rules:
    """Return the rules for a scene's `HardwareConfig`, None for ideal drives."""
    if hardware is None:
        return Rules(None, True)
    drives = hardware.drives
    switches = Switches(np.array(drives.switch_low), np.array(drives.switch_high))
    fitted = bool(np.isfinite([switches.low, switches.high]).any())
    return Rules(switches if fitted else None, bool(hardware.ideal))


def states_of_faults(summary: Mapping[str, Any]) -> dict[str, Changes]:
    """Return the tracks of faults, by the figures of a run."""
    tracks: dict[str, Changes] = defaultdict(list)
    for each in summary.get("faults", ()):
        track = tracks[f"fault {each['name']}"] or [(0.0, "off")]
        track.append((float(each["t"]), "on" if each["on"] else "off"))
        tracks[f"fault {each['name']}"] = track
    return dict(tracks)


def states_of_events(events: Sequence[tuple[float, str]]) -> dict[str, Changes]:
    """Return the tracks of what switches by events: friction that sticks, drives in their play, the payload's mass."""
    tracks: dict[str, Changes] = {}
    for t, what in events:
        for pattern, name, calm in EVENTS:
            if found := pattern.fullmatch(what):
                changes = tracks.setdefault(name.format(found["name"]), [(0.0, calm)])
                changes.append((t, found["state"]))
    return tracks


def color_of(state: str) -> str:
    """Return the colour of a state, as #rrggbb."""
    return COLORS.get(state, OTHER)


class Span(NamedTuple):
    """A stretch of time in which a track keeps its state."""

    begin: float  # s
    end: float
    state: str


def spans_of(changes: Changes, begin: float, end: float, least: float) -> list[Span]:
    """Return the stretches of a track between two times [s], neighbours of different states.

    One shorter than `least` [s] joins the one before it, but where that is calm: so no short excitement is lost.
    """
    times = [min(max(t, begin), end) for t, _ in changes] + [end]
    spans: list[Span] = []
    for (_, state), first, last in zip(changes, times[:-1], times[1:], strict=True):
        if last <= first:
            continue
        joins = spans and last - first < least and color_of(spans[-1].state) != CALM
        if spans and (joins or spans[-1].state == state):
            spans[-1] = spans[-1]._replace(end=last)
        else:
            spans.append(Span(first, last, state))
    return spans
