"""The group `rope` of a scene file: a rope below a boom or jib, and the winch that drives it."""

from math import inf
from typing import Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import LengthRange, Positive
from crane_sim.models.stops import LEAD_TIME, MIN_LENGTH, Stops
from crane_sim.models.supports.hoist import MasslessHoist, RateHoist
from crane_sim.scenes.schema.groups import Group


class Rope(Group):
    """Drive of the rope by the winch."""

    drive: Literal["force", "rate", "locked"] = "force"  # what the input of the winch is: an effort [N], positive pays
    # out; the rope's acceleration [m/s²]; or nothing, the length stays
    time_constant: Positive | None = None  # s, of a `rate` drive, whose input is then a rate [m/s], followed with this
    # lag; left out: the input is an acceleration
    limits: LengthRange | None = None  # m, of the length; a run ends where one is reached
    slack: Literal["allow", "stop"] = "allow"  # stop: a run ends where the rope would push

    @property
    def effort_unit(self) -> tuple[str, ...]:
        """Unit of the winch's command, a tuple, empty for a locked one."""
        if self.drive == "locked":
            return ()
        imposed = "m/s²" if self.time_constant is None else "m/s"
        return (imposed if self.drive == "rate" else "N",)

    def check(self, start: float, rate: float, joint: int) -> None:
        """Raise SceneError for keys that belong to another drive, and for a start that the drive cannot have.

        Args:
            start, rate: length [m] and its rate [m/s] at t = 0.
            joint: number of the rope among the joints.
        """
        if self.time_constant is not None and self.drive != "rate":
            raise SceneError(f"rope.time_constant: only a rate drive has one, this drive is {self.drive!r}")
        if self.limits is not None and self.drive == "locked":
            raise SceneError("rope.limits: belong to a rope that a winch moves, this drive is 'locked'")
        if self.drive == "locked" and rate != 0.0:
            raise SceneError(f"initial.v[{joint}] = {rate}: a locked rope starts at rest")
        if self.drive == "rate" and not start >= MIN_LENGTH:
            raise SceneError(f"initial.q[{joint}] = {start}: a rope by rate is at least {MIN_LENGTH:g} m long")

    def stops(self, limited: bool) -> Stops | None:
        """Return what ends a run, None for nothing; `limited`: some joint has travel limits."""
        by_rate, stop = self.drive == "rate", self.slack == "stop"  # by rate, it can reach zero under any load
        if not (limited or by_rate or stop):
            return None
        low, high = self.limits or (0.0, inf)
        if low > MIN_LENGTH or not (by_rate or self.limits is not None):
            return Stops(low, high, taut=float(stop))
        return Stops(MIN_LENGTH, high, LEAD_TIME, float(stop))

    def hoist(self) -> MasslessHoist | RateHoist | None:
        """Return the drive of a first link; None: its length stays."""
        if self.drive == "rate":
            return RateHoist(self.time_constant)
        return MasslessHoist() if self.drive == "force" else None
