"""Travel limits of a scene: where it starts and where its joints should go lie within them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from crane_sim.explain import SceneError

if TYPE_CHECKING:
    from crane_sim.forms.knuckle import KnuckleFile
    from crane_sim.forms.overhead import OverheadFile
    from crane_sim.forms.pendulum import PendulumFile


class Limit(NamedTuple):
    """The travel limits of a joint."""

    joint: str
    key: str  # of the scene's file
    low: float  # m or rad
    high: float


def check_limits(file: "KnuckleFile | OverheadFile | PendulumFile", target: Sequence[float] | None) -> None:
    """Raise SceneError when a scene starts, or should end, outside its travel limits.

    Args:
        file: the scene's file.
        target: where the actuated joints should end (nu,), None where nothing says so.
    """
    for limit in file.limits:
        i, told = file.joint_names.index(limit.joint), f"{limit.key} = {[limit.low, limit.high]}"
        start, unit = file.initial_q[i], file.joint_units[i]
        if not limit.low < limit.high:
            raise SceneError(f"{told}: must increase")
        if not limit.low <= start <= limit.high:
            raise SceneError(f"{told}: the {limit.joint} starts outside of them, at {start:g} {unit}")
        if target is None or limit.joint not in file.actuated:
            continue
        k = file.actuated.index(limit.joint)
        if not limit.low <= target[k] <= limit.high:
            raise SceneError(f"reference: the {limit.joint} should end at {target[k]:g} {unit}, outside of {told}")


def limits_of(*joints: tuple[str, str, tuple[float, float] | None]) -> tuple[Limit, ...]:
    """Return the limits of those joints, given as (joint, key, limits or None), that have some."""
    return tuple(Limit(joint, key, *limits) for joint, key, limits in joints if limits is not None)
