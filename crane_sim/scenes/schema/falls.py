"""The group `falls` of a scene file: elastic ropes between support and spreader."""

from math import cos, sin
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative, Positive, Real, reject_bool
from crane_sim.models.contact.surface import CompliantContact
from crane_sim.models.falls.crane import Falls
from crane_sim.models.loads import RigidLoad
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.load_at_rest import rotation_matrix
from crane_sim.scenes.schema.rigging import Vector

Ends = Annotated[tuple[Vector, ...], Field(min_length=1, max_length=100)]
CLOSE = 1e-12  # m, between ends at the same place


class FallsGroup(Group):
    """Elastic falls, each from a point of the support's tip to one of the spreader; they only pull.

    The upper ends are those of a trolley, or of a head that stays level below a boom: they slew,
    but do not luff.
    """

    top: Ends  # m, upper ends, from the tip, in axes that slew with the support: x outwards along
    # jib or boom, z up; of trolley and suspension point those of the base
    bottom: Ends  # m, lower ends, from the spreader's origin, in its axes
    offsets: tuple[Real, ...] | None = None  # m, added to the length of each fall: what skews,
    # trims or lists the load
    axial_stiffness: Positive  # N, E A of one rope
    parts: Annotated[int, BeforeValidator(reject_bool), Field(ge=1, le=100)] = (
        1  # -, of the rope in one fall, which share its tension
    )
    relaxation: NonNegative = 0.0  # s, damping: T = (E A / L) (e + relaxation × rate of e)

    def falls(self, length: float, load: RigidLoad) -> Falls:
        """Return the falls of an unstretched length [m], lower ends from the load's centre.

        Raises:
            SceneError: numbers of falls disagree, or offsets leave a fall no length.
        """
        n = len(self.top)
        offsets = self.offsets if self.offsets is not None else (0.0,) * n
        for key, rows in (("bottom", self.bottom), ("offsets", offsets)):
            if len(rows) != n:
                raise SceneError(f"falls.{key}: has {len(rows)} entries, falls.top has {n}")
        if not length + min(offsets) > 0.0:
            raise SceneError(f"falls.offsets = {list(offsets)}: leave no length of {length:g} m")
        bottom = np.array(self.bottom, dtype=float) + np.array(load.attachment)
        stiffness, relaxation = (
            np.full(n, self.axial_stiffness * self.parts),
            np.full(n, self.relaxation),
        )
        return Falls(
            np.array(self.top, dtype=float),
            bottom,
            length,
            np.array(offsets),
            stiffness,
            relaxation,
        )


class FallsStart(NamedTuple):
    """Where the ends of falls are at t = 0, in the axes of the base."""

    tip: Any  # (3,) m
    yaw: float  # rad, of the support's axes
    load: Any  # (7,) m and -, position of the load's centre of mass, and its attitude (w, x, y, z)


def _spread(falls: Falls, start: FallsStart) -> tuple[Any, Any, Any]:
    """Return (upper ends, lower ends, vectors from lower to upper ends), each (n, 3).

    Upper ends are from the tip, lower ones from the load's centre.
    """
    s, c = sin(start.yaw), cos(start.yaw)
    over = falls.top @ np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    arms = falls.bottom @ rotation_matrix(start.load[3:]).T
    return over, arms, over + start.tip - (start.load[:3] + arms)


def check_ends(falls: Falls, start: FallsStart) -> None:
    """Raise SceneError for a fall whose ends are at the same place: it would have no direction."""
    distances = np.linalg.norm(_spread(falls, start)[2], axis=1)
    i = int(distances.argmin())
    if distances[i] < CLOSE:
        raise SceneError(
            f"falls.top[{i}] = {falls.top[i].tolist()}: at t = 0 both ends of this fall are at the "
            "same place; lower "
            "the load, or take another end"
        )


def stiffest_frequency(
    falls: Falls,
    load: RigidLoad,
    mobility: tuple[Any, float | None],
    start: FallsStart,
    contact: Any,
) -> float:
    """Return the largest frequency or decay rate [rad/s] of the load on its falls and contact.

    Args:
        falls, load: parameters; the falls' length is that at t = 0.
        mobility: (of the tip (4, 4), x, y, z [1/kg] and yaw [1/(kg m²)]; mass [kg] that moves with
            the length, None where what the falls pull does not move it).
        start: where their ends are.
        contact: of the load, None without.
    """
    over, arms, apart = _spread(falls, start)
    n = apart / np.maximum(np.linalg.norm(apart, axis=1), CLOSE)[:, None]
    rotation = rotation_matrix(start.load[3:])
    yawing = np.cross(over, n)[:, 2:]
    rows = [np.hstack([n, np.cross(arms, n) @ rotation, n, yawing, np.ones((len(n), 1))])]
    springs = [falls.axial_stiffness / (falls.length + falls.offset)]
    relaxations = [falls.relaxation]
    if isinstance(contact, CompliantContact):
        levers = contact.points @ rotation.T
        up = np.tile([0.0, 0.0, 1.0], (len(levers), 1))
        rows.append(np.hstack([up, np.cross(levers, up) @ rotation, np.zeros((len(levers), 5))]))
        springs.append(np.full(len(levers), contact.stiffness))
        relaxations.append(np.zeros(len(levers)))
    weighted = np.vstack(rows) * np.sqrt(np.concatenate(springs))[:, None]
    inverse = _inverse_mass_matrix(load, *mobility)
    damped = weighted * np.sqrt(np.concatenate(relaxations))[:, None]
    return max(_largest_eigenvalue(weighted, inverse) ** 0.5, _largest_eigenvalue(damped, inverse))


def _inverse_mass_matrix(load: RigidLoad, tip_mobility: Any, moved: float | None) -> Any:
    """Return M⁻¹ (11, 11) of load, tip and length; the mass moved with it is None for no motion."""
    inverse = np.zeros((11, 11))
    inverse[:3, :3] = np.eye(3) / load.mass
    inverse[3:6, 3:6] = np.array(load.inverse_inertia)
    inverse[6:10, 6:10] = tip_mobility
    inverse[10, 10] = 1.0 / moved if moved is not None else 0.0
    return inverse


def _largest_eigenvalue(rows: Any, inverse: Any) -> float:
    """Return the largest eigenvalue of R M⁻¹ Rᵀ, infinite where numbers overflow."""
    with np.errstate(all="ignore"):
        matrix = rows @ inverse @ rows.T
    return float(np.linalg.eigvalsh(matrix).max()) if np.isfinite(matrix).all() else float("inf")
