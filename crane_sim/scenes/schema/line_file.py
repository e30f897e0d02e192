"""What hangs on a rope of fixed length below a driven point: links, and a point mass or a body."""

from functools import cached_property
from math import sqrt
from typing import Any, Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Positive
from crane_sim.models.cables.rope import LockedRope
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.stops import Stops
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.models.suspended.torsion import Torsion
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.rigging import (
    ATTITUDE,
    UNIT_TOLERANCE,
    RiggingStart,
    Vector,
    link_names,
)
from crane_sim.scenes.schema.rope_file import RiggedFile
from crane_sim.scenes.schema.suspension import TipStart


class FixedRope(Group):
    """The rope, which stays as long as it is."""

    length: Positive  # m, from the suspension point to the payload
    slack: Literal["allow", "stop"] = "allow"  # stop: a run ends where the rope, or a further link,
    # would push
    torsion: Torsion | None = None  # what resists a twist between point and payload; left out: the
    # payload turns freely


class LineStart(TipStart):
    """The suspension point and the direction of the rope at t = 0, relative to the base."""

    direction: Vector = (0.0, 0.0, -1.0)  # -, unit vector from the point to the payload
    direction_rate: Vector = (0.0, 0.0, 0.0)  # 1/s, across the direction
    rigging: RiggingStart | None = None  # further links, and the payload's attitude


class LineFile(RiggedFile):
    """A payload on a rope of fixed length and links; coordinates of each are a unit vector."""

    rope: FixedRope  # the rope, of fixed length
    initial: LineStart = LineStart()  # the state at t = 0

    @property
    def hanging_joints(self) -> dict[str, str]:
        """Units of the joints: unit vectors down rope and links, the payload's attitude."""
        body = ATTITUDE if self.payload.inertia is not None else ()
        return dict.fromkeys((*link_names(len(self.links) + 1, 1), *body), "1")

    @property
    def hanging_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of what hangs at t = 0; SceneError: a direction changes along itself."""
        n, u = self._direction
        along = sum(x * v for x, v in zip(self.initial.direction, u, strict=True))
        if abs(along) > UNIT_TOLERANCE * (1.0 + max(map(abs, u))):
            raise SceneError(f"initial.direction_rate = {list(u)}: must be across the direction")
        return (*n, *self._rigging[0]), (*u, *self._rigging[1])

    @property
    def _rope_start(self) -> float:
        return self.rope.length

    @property
    def _longest_rope(self) -> float:
        return self.rope.length

    @cached_property
    def _direction(self) -> tuple[Any, Any]:
        start = self.initial
        length = sqrt(sum(x * x for x in start.direction))
        if not abs(length - 1.0) < UNIT_TOLERANCE:
            raise SceneError(f"initial.direction = {list(start.direction)}: must be a unit vector")
        return tuple(x / length for x in start.direction), start.direction_rate

    @property
    def _tip_rises(self) -> bool:
        return self.driven_joints == self.joints

    def stiffest(self) -> float:
        """Return the largest frequency or decay rate [rad/s] of rope and payloads."""
        return self._hanging_rate(self.rope.length)

    @cached_property
    def _stops(self) -> Stops | None:
        taut = self.rope.slack == "stop"
        switches = self.limits or self.events or self.rope.torsion or self.is_in_kinked_wind
        return Stops(taut=float(taut)) if taut or switches else None

    def model(self) -> Crane | SuspendedCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        if self.beyond_one_rope:
            return self._suspended_crane(None, ())
        return self._crane_with_one_rope(self._structure, LockedRope(self.rope.length))
