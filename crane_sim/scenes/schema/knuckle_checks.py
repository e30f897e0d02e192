"""Validation of boom and jib of a knuckle-boom crane: inertias that no body has, and singular inertia matrices."""

from crane_sim.files.errors import SceneError
from crane_sim.models.supports.knuckle_boom import Rod

ROUNDING = 1e-9
"""Relative: inertias that were computed elsewhere may miss a bound by it."""


def check_rods(boom: Rod, jib: Rod) -> None:
    """Raise SceneError for an inertia that no rigid body has, or for rods too light to be moved by an effort."""
    for name, rod in (("boom", boom), ("jib", jib)):
        most = 2.0 * rod.inertia  # of a body, each principal moment of inertia is at most the sum of the two others
        if rod.axial_inertia is not None and rod.axial_inertia > most * (1.0 + ROUNDING):
            raise SceneError(
                f"{name}.axial_inertia = {rod.axial_inertia:g}: no rigid body has more than twice its inertia "
                f"across, here {most:g} kg m²"
            )
    _check_mass(boom, jib)


def _check_mass(boom: Rod, jib: Rod) -> None:
    """Reject rods whose inertia matrix is singular: always, or with boom and jib in line."""
    if jib.mass == 0.0 and jib.inertia == 0.0:
        raise SceneError("jib.mass = 0: nothing resists the jib's effort; give it a mass or an inertia")
    if boom.mass == 0.0 and boom.inertia == 0.0 and 0.0 in (jib.mass, jib.inertia):
        raise SceneError(
            "boom.mass = 0: with boom and jib in line nothing resists their efforts; give the boom a mass or an "
            "inertia, or the jib both"
        )
