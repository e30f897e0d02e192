"""What ends the run of a crane: travel limits, a rope that is reeled in to nothing or runs out, one that would push.

A guard is a pair (value, number): the run goes on while the value is not negative, the number tells what ended it.
"""

from math import inf
from typing import Any, NamedTuple

from crane_sim.numerics.jit import generic, lean_generic, lean_kernel
from crane_sim.system import Switching

LIMIT, ROPE, SLACK = 10, 20, 1000
"""Numbers of guards: limits + coordinate of the support, rope + 0 (too short) or 1 (too long), a rope that pushes."""
SHORTEST = 1e-3  # m, of a rope that a winch has reeled in: below it the swing's rate grows without bound
LEAD = 0.01  # s: a rope that would be that short so soon is so now; its length, never negative, soon grows again
_POSITIONS = 6  # of support and payload


class Stops(NamedTuple):
    """What ends the run of a crane with one rope, beside the limits of its support."""

    shortest: float = 0.0  # m, of the rope
    longest: float = inf
    lead: float = 0.0  # s, how far ahead the rope's rate tells of its shortest length
    taut: float = 0.0  # 1: a run ends when the rope goes slack, 0: the rope is a rod that can push


@generic
def switching_of(stops):
    """Return what `system.switching` does for a crane with these stops, None for a crane without."""
    return None


@switching_of.register(Stops)
def _(stops):
    return Switching(1, 0 if stops.taut > 0.0 else _POSITIONS)


@lean_kernel
def smaller_guard(best, value, which):
    """Return the smaller one of two (guard, number)."""
    return (value, which) if value < best[0] else best


@lean_generic
def travel_guard(limits, best, q, which):
    """Return the smallest (guard, number), limits (low, high) of a coordinate at q counted in; None are no limits."""
    return best


@travel_guard.register(tuple)
def _(limits, best, q, which):
    return smaller_guard(best, min(q - limits[0], limits[1] - q), which)


def describe_length_event(rope: str, key: str, end: int, shortest: float) -> tuple[str, str]:
    """Return (what happened, what a user can change) where a rope came to its shortest (end 0) or longest (1) length.

    Args:
        rope: its name in longer words.
        key: the group of the scene that has its limits.
        end: which one.
        shortest: its shortest length [m].
    """
    if end == 0 and shortest <= SHORTEST:
        return "the rope is reeled in to nothing", f"give {key}.limits, or change what drives the {key}"
    which = ("shortest", "longest")[end]
    return f"the {rope} reached its {which} length", f"change {key}.limits, or what drives the {key}"


def describe_event(support: Any, stops: Stops, which: int) -> tuple[str, str]:
    """Return (what guard number `which` tells, what a user can change) in words; `support` names its coordinates."""
    if which >= SLACK:
        return "the rope went slack, and a rigid one cannot be", "take rope.slack: allow if the rope is a rod"
    if which >= ROPE:
        return describe_length_event("rope", "rope", which - ROPE, stops.shortest)
    name, key = support.coordinate(which - LIMIT)
    return f"the {name} reached its travel limit", f"change {key}, or what drives the {name}"
