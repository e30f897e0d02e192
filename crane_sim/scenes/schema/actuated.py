"""The groups `friction` and `lugre` of a crane with a support, and the motors of its joints."""

from collections.abc import Mapping, Sequence
from typing import Any

from crane_sim.files.errors import SceneError
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.supports.support import Support, own_count
from crane_sim.models.supports.swaying_tower import SwayingTower
from crane_sim.scenes.schema.friction_checks import check_friction
from crane_sim.scenes.schema.motors import reflected_inertia


def has_strength(friction: Mapping[str, Friction], lugre: Mapping[str, LuGre]) -> bool:
    """Return whether any friction has some strength; errors are those of `check_friction`."""
    groups = {"friction": friction, "lugre": lugre}
    return any(
        check_friction(f"{key}.{name}", part)
        for key, group in groups.items()
        for name, part in group.items()
    )


def with_friction_and_motors(structure: Any, file: Any, joints: Sequence[str]) -> Support:
    """Return the support with friction and motors of its joints.

    Args:
        structure: of the crane's support.
        file: the scene's, with `friction`, `lugre` and `backlash` by joint.
        joints: of the support.

    Raises:
        SceneError: a joint is locked, its motor stands on a mast that bends, or its friction or
            motor is given twice.
    """
    for name in (name for name in joints if file.is_locked(name)):
        _check_locked(name, file)
    frictions = tuple(_friction_of(name, file) for name in joints)
    motors = tuple(_motor_of(name, file) for name in joints)
    if isinstance(structure, SwayingTower) and any(motors):
        name = joints[next(i for i, inertia in enumerate(motors) if inertia)]
        raise SceneError(
            f"flexibility.mast: stands beside actuators.{name}.motor.inertia, which would turn "
            "with the mast, too; "
            "leave out one of both"
        )
    support = Support(structure)
    bending = own_count(support) - len(joints)
    return support._replace(
        motors=(*motors, *(0.0,) * bending) if any(motors) else None,
        frictions=(*frictions, *(None,) * bending)
        if any(part is not None for part in frictions)
        else None,
    )


def _check_locked(name: str, file: Any) -> None:
    """Reject friction, play and motors of a joint that is locked."""
    for key in ("friction", "lugre", "backlash"):
        if name in getattr(file, key):
            raise SceneError(
                f"{key}.{name}: belongs to a joint that a drive moves, {name}.drive is 'locked'"
            )
    if reflected_inertia(file, name) > 0.0:
        raise SceneError(
            f"actuators.{name}.motor.inertia: belongs to a joint that it moves, {name}.drive is "
            "'locked'"
        )


def _friction_of(name: str, file: Any) -> Friction | LuGre | None:
    """Return the friction of a joint, None where it has none or it has no strength."""
    by_events, by_bristles = file.friction.get(name), file.lugre.get(name)
    if by_events is not None and by_bristles is not None:
        raise SceneError(f"lugre.{name}: stands beside friction.{name}; a joint has one of the two")
    return check_friction(f"friction.{name}", by_events) or check_friction(
        f"lugre.{name}", by_bristles
    )


def _motor_of(name: str, file: Any) -> float:
    """Return the inertia [kg or kg m²] that a joint's motor reflects to it."""
    inertia = reflected_inertia(file, name)
    if inertia > 0.0 and name in file.backlash:
        raise SceneError(
            f"actuators.{name}.motor.inertia: stands beside backlash.{name}; give its drives the "
            "inertia"
        )
    return inertia
