"""Travel limits of a scene's joints."""

from typing import NamedTuple


class TravelLimits(NamedTuple):
    """The travel limits of a joint, within which its initial position and target must lie."""

    joint: str
    key: str  # of the scene's file
    low: float  # m or rad
    high: float


def limits_of(*joints: tuple[str, str, tuple[float, float] | None]) -> tuple[TravelLimits, ...]:
    """Return the limits of those joints, given as (joint, key, limits or None), that have some."""
    return tuple(
        TravelLimits(joint, key, *limits) for joint, key, limits in joints if limits is not None
    )
