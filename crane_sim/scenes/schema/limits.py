"""Travel limits of a scene: initial positions and targets lie within them."""

from typing import NamedTuple


class Limit(NamedTuple):
    """The travel limits of a joint."""

    joint: str
    key: str  # of the scene's file
    low: float  # m or rad
    high: float


def limits_of(*joints: tuple[str, str, tuple[float, float] | None]) -> tuple[Limit, ...]:
    """Return the limits of those joints, given as (joint, key, limits or None), that have some."""
    return tuple(Limit(joint, key, *limits) for joint, key, limits in joints if limits is not None)
