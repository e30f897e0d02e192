"""Validation of a joint's friction, and how fast its equations are."""

from typing import TypeVar

from crane_sim.files.errors import SceneError
from crane_sim.models.supports.friction import Friction, steepest_slope
from crane_sim.models.supports.lugre import LuGre

MAX_FRICTION = 1e12  # N, N s/m; N m, N m s/rad
Kind = TypeVar("Kind", Friction, LuGre)


def check_friction(name: str, friction: Kind | None) -> Kind | None:
    """Return the friction of the key `name`, None where static and viscous friction are zero.

    Raises:
        SceneError: a value is too large, or the static friction is less than the Coulomb one.
    """
    if friction is None:
        return None
    for key in ("coulomb", "static", "viscous"):
        if getattr(friction, key) > MAX_FRICTION:
            raise SceneError(
                f"{name}.{key} = {getattr(friction, key)}: must be at most {MAX_FRICTION:g}"
            )
    if friction.static < friction.coulomb:
        raise SceneError(
            f"{name}.static = {friction.static}: must be at least coulomb = {friction.coulomb}"
        )
    return friction if friction.static > 0.0 or friction.viscous > 0.0 else None


def friction_rate(friction: Friction | LuGre | None, inertia: float) -> float:
    """Return the largest frequency [rad/s] or rate [1/s] of a joint's friction, 0 without.

    The joint has this inertia.
    """
    if friction is None or not inertia > 0.0:
        return 0.0
    if isinstance(friction, Friction):
        return steepest_slope(friction) / inertia
    return max(
        (friction.stiffness / inertia) ** 0.5,
        (friction.damping + steepest_slope(friction)) / inertia,
    )
