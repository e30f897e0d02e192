"""Terminal guards of a crane: travel limits, a rope at its shortest or longest, a slack one."""

from math import inf
from typing import Any, NamedTuple

from crane_sim.models.guards import (
    LOWER,
    UPPER,
    Guard,
    decode,
    describe_friction,
    encode,
    smaller_guard,
)
from crane_sim.system import Switching

# m, of a rope that a winch has reeled in: below it the swing's rate grows without bound
MIN_LENGTH = 1e-3
# s: the length is extrapolated by its rate over it, as a length that passes zero would grow again
LOOKAHEAD_TIME = 0.01
WINCH = 3  # index of the winch among the joints that friction can hold


class Stops(NamedTuple):
    """Terminal guards of a crane with one rope, beside the limits of its support."""

    shortest: float = 0.0  # m, of the rope
    longest: float = inf
    lookahead: float = 0.0  # s, time over which the length is extrapolated by its rate
    taut: float = 0.0  # 1: a run ends when the rope goes slack, 0: the rope is a rod that can push


def make_switching(stops, positions):
    """Return `system.switching` of a crane with these stops, None for a crane without.

    Args:
        stops: the stops.
        positions: number of positions that the guards depend on where no rope has to stay taut, see
            `Switching`.
    """
    if stops is None:
        return None
    return Switching(1, 0 if stops.taut > 0.0 else positions, None)


def length_guard(stops, best, length, rate):
    """Return the smallest one of `best` and the guards of a rope's shortest and longest length."""
    shortest = length + stops.lookahead * min(rate, 0.0) - stops.shortest
    best = smaller_guard(best, shortest, encode(Guard.LENGTH, LOWER))
    return smaller_guard(best, stops.longest - length, encode(Guard.LENGTH, UPPER))


def describe_length_event(rope: str, key: str, end: int, shortest: float) -> tuple[str, str]:
    """Return (what happened, what a user can change) where a rope came to an end of its lengths.

    Args:
        rope: its name in longer words.
        key: the group of the scene that has its limits.
        end: LOWER or UPPER.
        shortest: its shortest length [m].
    """
    if end == LOWER and shortest <= MIN_LENGTH:
        return (
            f"the {rope} is reeled in to zero length",
            f"give {key}.limits, or change what drives the {key}",
        )
    name = {LOWER: "shortest", UPPER: "longest"}[end]
    return f"the {rope} reached its {name} length", f"change {key}.limits, or what drives the {key}"


def describe_cable_event(number: int, shortest: float) -> tuple[str, str]:
    """Return texts (what an event was, what a user can change) of an overhead crane's cable."""
    kind, index, outcome = decode(number)
    if kind == Guard.FRICTION:
        return describe_friction("hoist", outcome), ""
    if kind == Guard.LENGTH:
        return describe_length_event("hoisted link", "hoist", index, shortest)
    return (
        f"link {index + 1} went slack, and a rigid link must be taut",
        "take cable.model: elastic with tension_only, or cable.slack: allow if the links are rods",
    )


def describe_stop(support: Any, stops: Stops, number: int) -> tuple[str, str]:
    """Return texts (meaning of a guard, what a user can change).

    `support` names its coordinates.
    """
    kind, index, outcome = decode(number)
    if kind == Guard.FRICTION:
        return describe_friction(
            "winch" if index == WINCH else support.coordinate(index)[0], outcome
        ), ""
    if kind == Guard.LINK:
        return (
            "the rope went slack, and a rigid one cannot be",
            "take rope.slack: allow if the rope is a rod",
        )
    if kind == Guard.LENGTH:
        return describe_length_event("rope", "rope", index, stops.shortest)
    name, key = support.coordinate(index)
    return f"the {name} reached its travel limit", f"change {key}, or what drives the {name}"
