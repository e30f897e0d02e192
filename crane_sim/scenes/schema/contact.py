"""The group `contact` of a scene file: ground or deck below a load on falls, and its points."""

from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Fraction, NonNegative, Real
from crane_sim.models.contact.impacts import NEAR
from crane_sim.models.contact.surface import CompliantContact, RigidContact, Surface
from crane_sim.models.loads import RigidLoad
from crane_sim.scenes.schema.base_motion import BaseMotion, Sways
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.rigging import Vector
from crane_sim.trajectories.base_motion import Base, base_positions

OWN_KEYS = {"rigid": ("restitution", "rest_velocity"), "compliant": ("stiffness", "damping")}
"""Keys of each kind of contact."""
APART = 1e-6  # of the points' span: how far three of them have to be from a line
Speed = Annotated[Real, Field(ge=1e-6)]
"""A speed above rounding [m/s]."""


class DeckMotion(Group):
    """Motion of the surface relative to the base: for each axis one sinusoid or a list of them."""

    surge: Sways = ()  # m, along x
    sway: Sways = ()  # m, along y
    heave: Sways = ()  # m, along z

    def motion(self) -> Base:
        """Return the motion of the surface."""
        base = BaseMotion(surge=self.surge, sway=self.sway, heave=self.heave).base(0, 0.0)
        assert isinstance(base, Base)
        return base


Points = Annotated[tuple[Vector, ...], Field(min_length=1, max_length=100)]


class ContactGroup(Group):
    """Contact of the load with the ground or a deck, a plane horizontal in the base's axes."""

    kind: Literal["rigid", "compliant"] = "rigid"  # points that do not enter the surface, or on
    # springs and dampers
    points: Points  # m, points of the load that may touch,
    # from the spreader's origin, in its axes; no three of them in a line
    height: Real  # m, of the surface above the base's origin
    motion: DeckMotion | None = None  # of the surface; left out: it rests on the base, and moves
    # with it
    friction: NonNegative = 0.0  # -, coefficient of Coulomb friction
    slip_velocity: Speed = 1e-3  # m/s, below which friction falls off with the slip; a load on
    # three or more rigid points sticks there if friction can hold it
    restitution: Fraction | None = None  # -, of impacts of `rigid`, ratio of the impulses of
    # expansion and compression; left out: 0
    rest_velocity: Speed | None = None  # m/s, of `rigid`: an approach that is no faster has no
    # restitution; left out: 0.01
    stiffness: NonNegative | None = None  # N/m, of each point of `compliant`; 0 is no contact
    damping: NonNegative | None = None  # s/m, of `compliant`: N = stiffness × depth × (1 + damping
    # × rate of depth); left out: 0

    def model(self, load: RigidLoad, q: Any) -> RigidContact | CompliantContact | None:
        """Return the contact of a load that begins at q (7,), None without strength.

        q is its position and attitude.

        Raises:
            SceneError: a key belongs to the other kind, points are in a line, or one begins below a
                rigid surface.
        """
        self._check_kind()
        points = np.array(self.points, dtype=float) + np.array(load.attachment)
        check_points("contact.points", points)
        motion = self.motion.motion() if self.motion is not None else None
        surface = Surface(self.height, self.friction, self.slip_velocity, motion)
        if self.kind == "compliant":
            strength = CompliantContact(points, surface, self.stiffness or 0.0, self.damping or 0.0)
            return strength if self.stiffness else None
        self._check_start(points, q, motion)
        rest = self.rest_velocity if self.rest_velocity is not None else 0.01
        return RigidContact(points, surface, self.restitution or 0.0, rest)

    def _check_kind(self) -> None:
        other = "compliant" if self.kind == "rigid" else "rigid"
        for key in OWN_KEYS[other]:
            if getattr(self, key) is not None:
                raise SceneError(
                    f"contact.{key}: belongs to contact.kind: {other}, here it is {self.kind}"
                )
        if self.kind == "compliant" and self.stiffness is None:
            raise SceneError("contact.stiffness: is missing; a compliant contact needs it")

    def _check_start(self, points: Any, q: Any, motion: Base | None) -> None:
        (_, _, z), (w, a, b, c) = q[:3], q[3:7]
        row = np.array([2.0 * (a * c - w * b), 2.0 * (b * c + w * a), 1.0 - 2.0 * (a * a + b * b)])
        raised = float(base_positions(motion, np.zeros(1))[0, 2]) if motion is not None else 0.0
        gaps = z + points @ row - self.height - raised
        if gaps.min() < -NEAR:
            raise SceneError(
                f"contact.height = {self.height:g}: at t = 0 point {int(gaps.argmin()) + 1} is "
                f"{-gaps.min():.4g} m "
                "below the surface; lower it, or raise the load"
            )


@np.errstate(all="ignore")  # points as far as numbers reach
def check_points(key: str, points: Any) -> None:
    """Raise SceneError for points (n, 3) of a key, two of which are the same or three in a line."""
    near = APART * float(np.ptp(points, axis=0).max())
    for i in range(len(points)):
        for k in range(i):
            along = points[i] - points[k]
            if np.linalg.norm(along) <= near:
                raise SceneError(f"{key}: {k + 1} and {i + 1} are the same; each may stand once")
            away = np.linalg.norm(np.cross(points[:k] - points[k], along), axis=1) / np.linalg.norm(
                along
            )
            if len(away) and away.min() <= near:
                three = f"{int(away.argmin()) + 1}, {k + 1} and {i + 1}"
                raise SceneError(f"{key}: {three} are in a line; leave out the middle one")
