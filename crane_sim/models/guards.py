"""Guards: which of them has failed, as one number, and which event that makes.

A guard is a pair (value, number): the discrete modes of the model stay as they are while the value
is not negative. The number encodes the guard's kind and an index, of an axis, a link or an end;
that of an event also its outcome.
"""

from enum import IntEnum


class Guard(IntEnum):
    """Kinds of guards."""

    FRICTION = 0  # of an axis that sticks or slips; outcomes: STICKS, FORWARDS, BACKWARDS
    TRAVEL = 1  # travel limits of an axis, or of a support's coordinate
    LENGTH = 2  # of a rope or first link; indices: LOWER, UPPER
    PAYLOAD = 3  # the next change of the payload
    LINK = 4  # the tension of a link from the top, or of the rope; outcomes: SLACK, TAUT
    # of a load's point, or after the last one of the load that sticks; outcomes: LEAVES, TOUCHES,
    # BOUNCES
    CONTACT = 5
    TWIST = 6  # of a rope with torsion: it ends a run
    # contact of a drive with its joint; outcomes: FORWARDS, BACKWARDS, and those of `backlash`
    BACKLASH = 7


LOWER, UPPER = 0, 1
STICKS, FORWARDS, BACKWARDS = 0, 1, 2
SLACK, TAUT = 0, 1
LEAVES, TOUCHES, BOUNCES = 0, 1, 2  # and of a load: slips, sticks
_KINDS, _INDICES = 8, 10_000  # room for kinds, and for indices


def encode(kind, index, outcome=0):
    """Return the number of a guard, or of an event with an outcome."""
    return (outcome * _KINDS + kind) * _INDICES + index


def decode(number):
    """Return (kind, index, outcome) of a number."""
    return number // _INDICES % _KINDS, number % _INDICES, number // (_INDICES * _KINDS)


def friction_event(joint, mode):
    """Return the number of the event that a joint's friction has come to a mode."""
    way = FORWARDS if mode > 0.0 else BACKWARDS
    return encode(Guard.FRICTION, joint, STICKS if mode == 0.0 else way)


def describe_friction(name: str, outcome: int) -> str:
    """Return the text of an event of a joint's friction."""
    return f"the {name} {('sticks', 'slips forwards', 'slips backwards')[outcome]}"


def smaller_guard(best, value, number):
    """Return the smaller one of two guards."""
    return (value, number) if value < best[0] else best


def travel_guard(limits, best, q, number):
    """Return the smaller one of `best` and the guard of limits (low, high) at q.

    None stands for no limits.
    """
    return (
        best if limits is None else smaller_guard(best, min(q - limits[0], limits[1] - q), number)
    )
