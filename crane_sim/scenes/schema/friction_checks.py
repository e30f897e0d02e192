"""Validation of a joint's friction."""

from typing import TypeVar

from crane_sim.files.errors import SceneError
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.lugre import LuGre

MAX_FRICTION = 1e12  # N, N s/m; N m, N m s/rad


Kind = TypeVar("Kind", Friction, LuGre)


def checked(name: str, friction: Kind | None) -> Kind | None:
    """Return the friction of the key `name`, None where it has no strength.

    Raises:
        SceneError: a value is too large, or the static friction is less than the Coulomb one.
    """
    if friction is None:
        return None
    for key in ("coulomb", "static", "viscous"):
        if getattr(friction, key) > MAX_FRICTION:
            raise SceneError(f"{name}.{key} = {getattr(friction, key)}: must be at most {MAX_FRICTION:g}")
    if friction.static < friction.coulomb:
        raise SceneError(f"{name}.static = {friction.static}: must be at least coulomb = {friction.coulomb}")
    return friction if friction.static > 0.0 or friction.viscous > 0.0 else None
