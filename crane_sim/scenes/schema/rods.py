"""Checks of a knuckle-boom crane's boom and jib: inertias, singular matrices, friction."""

from collections.abc import Mapping

from crane_sim.files.errors import SceneError
from crane_sim.models.single_rope.joint_friction import JointFriction
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.knuckle_boom import Rod
from crane_sim.models.supports.lugre import LuGre
from crane_sim.scenes.schema.friction_checks import check_friction

ROUNDING = 1e-9
"""Relative: inertias that were computed elsewhere may miss a bound by it."""


def check_rods(boom: Rod, jib: Rod) -> None:
    """Raise SceneError for an inertia that no body has, or for rods too light for any effort."""
    for name, rod in (("boom", boom), ("jib", jib)):
        # of a body, each principal moment of inertia is at most the sum of the two others
        most = 2.0 * rod.inertia
        if rod.axial_inertia is not None and rod.axial_inertia > most * (1.0 + ROUNDING):
            raise SceneError(
                f"{name}.axial_inertia = {rod.axial_inertia:g}: no rigid body has more than twice "
                "its inertia "
                f"across, here {most:g} kg m²"
            )
    _check_mass(boom, jib)


def _check_mass(boom: Rod, jib: Rod) -> None:
    """Reject rods whose inertia matrix is singular: always, or with boom and jib in line."""
    if jib.mass == 0.0 and jib.inertia == 0.0:
        raise SceneError(
            "jib.mass = 0: nothing resists the jib's effort; give it a mass or an inertia"
        )
    if boom.mass == 0.0 and boom.inertia == 0.0 and 0.0 in (jib.mass, jib.inertia):
        raise SceneError(
            "boom.mass = 0: with boom and jib in line nothing resists their efforts; give the boom "
            "a mass or an "
            "inertia, or the jib both"
        )


def joint_friction(
    friction: Mapping[str, Friction], lugre: Mapping[str, LuGre], drive: str
) -> JointFriction | None:
    """Return the friction of the joints of a crane with one rope, None where no joint has any.

    Args:
        friction, lugre: by joint: by events, by bristles.
        drive: of the rope.

    Raises:
        SceneError: a joint has both, a value is out of range, or no force drives the winch.
    """
    parts, names = {}, JointFriction._fields
    for name in names:
        groups = {"friction": friction.get(name), "lugre": lugre.get(name)}
        given = [(key, part) for key, part in groups.items() if part is not None]
        if len(given) == 2:
            raise SceneError(
                f"lugre.{name}: stands beside friction.{name}; a joint has one of the two"
            )
        if name == "rope" and given and drive != "force":
            raise SceneError(
                f"{given[0][0]}.rope: belongs to rope.drive: force, here it is {drive!r}"
            )
        parts[name] = check_friction(f"{given[0][0]}.{name}", given[0][1]) if given else None
    return JointFriction(**parts) if any(parts.values()) else None
