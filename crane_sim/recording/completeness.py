"""Whether a recording has all of its run: complete, cut or damaged, with what is good of it."""

from __future__ import annotations

from typing import NamedTuple

COMPLETE, CUT, DAMAGED = "complete", "cut", "damaged"


class Completeness(NamedTuple):
    """State of a recording, and one phrase on what there is of it, empty for a complete one."""

    state: str = COMPLETE
    extent: str = ""


class Steps(NamedTuple):
    """Number of steps of a recording."""

    good: int  # that are as they were written
    end: float  # s, start of the last one
    planned: int  # of the scene
    recorded: int | None  # that were written, None without the end of the recording
    lost: int  # whose messages its recorder did not get


def assess(steps: Steps, damage: str) -> Completeness:
    """Return the completeness of a recording.

    Args:
        steps: their number.
        damage: what beside steps is not as it was written, empty for nothing.
    """
    if damage or (steps.recorded is not None and steps.good != steps.recorded):
        of = steps.planned if steps.recorded is None else steps.recorded
        phrase = f"is damaged: {steps.good} of {of} steps are as they were written"
        return Completeness(DAMAGED, f"{phrase}; {damage}" if damage else phrase)
    if steps.recorded is None:
        return Completeness(
            CUT, f"is cut off: it has {steps.good} of {steps.planned} steps, up to {steps.end:g} s"
        )
    if steps.lost:
        of = steps.recorded + steps.lost
        return Completeness(
            CUT, f"lacks {steps.lost} of {of} steps, whose messages its recorder did not get"
        )
    return Completeness()
