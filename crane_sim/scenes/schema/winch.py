"""The group `rope` of a scene file: a rope below a boom or jib, and the winch that drives it."""

from math import inf
from typing import Annotated, Any, Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import LengthRange, Positive
from crane_sim.models.stops import LOOKAHEAD_TIME, MIN_LENGTH, Stops
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import MasslessHoist, MotionHoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist, Torque
from crane_sim.models.supports.reeving import Reeving
from crane_sim.models.suspended.torsion import Torsion
from crane_sim.scenes.schema.friction_checks import check_friction
from crane_sim.scenes.schema.groups import BY_RATE, Group
from crane_sim.scenes.schema.motors import motor_of, reflected_inertia
from crane_sim.scenes.schema.reeving import ReevingGroup


class Winch(Group):
    """Keys of every winch: an effort drives it, or `drive: rate` imposes the length's motion."""

    drive: Any = "force"  # what the input of the winch is, see the subclasses
    time_constant: Positive | None = None  # s, of a `rate` drive: its input is then the velocity
    # [m/s], followed with this lag; left out: the acceleration
    limits: LengthRange | None = None  # m, of the length; a run ends where one is reached
    slack: Literal["allow", "stop"] = "allow"  # stop: a run ends where the rope would push

    @property
    def effort_unit(self) -> str:
        """Unit of the winch's command, empty for a locked one."""
        imposed = "m/s²" if self.time_constant is None else "m/s"
        return {"force": "N", "torque": "N m", "locked": "", "rate": imposed}[self.drive]

    def check(self, start: float, rate: float, joint: int) -> None:
        """Raise SceneError for keys of another drive and for an impossible start.

        Args:
            start, rate: length [m] and its rate [m/s] at t = 0.
            joint: number of the rope among the joints.
        """
        if self.time_constant is not None and self.drive != "rate":
            raise SceneError(
                f"rope.time_constant: only a rate drive has one, this drive is {self.drive!r}"
            )
        if self.limits is not None and self.drive == "locked":
            raise SceneError(
                "rope.limits: belong to a rope that a winch moves, this drive is 'locked'"
            )
        if self.drive == "locked" and rate != 0.0:
            raise SceneError(f"initial.v[{joint}] = {rate}: a locked rope starts at rest")
        if self.drive == "rate" and not start >= MIN_LENGTH:
            raise SceneError(
                f"initial.q[{joint}] = {start}: a rope of drive: rate is at least {MIN_LENGTH:g} m "
                "long"
            )

    def stops(self, limited: bool) -> Stops | None:
        """Return what ends a run, None for nothing; `limited`: some joint has travel limits."""
        # an imposed length can reach 0 under any load
        imposed, stop = self.drive == "rate", self.slack == "stop"
        if not (limited or imposed or stop):
            return None
        low, high = self.limits or (0.0, inf)
        if low > MIN_LENGTH or not (imposed or self.limits is not None):
            return Stops(low, high, taut=float(stop))
        return Stops(MIN_LENGTH, high, LOOKAHEAD_TIME, float(stop))

    def hoist(self) -> MasslessHoist | MotionHoist | None:
        """Return the drive of a first link; None: its length stays."""
        if self.drive == "rate":
            return MotionHoist(self.time_constant)
        return MasslessHoist() if self.drive == "force" else None


RopeDrive = Annotated[Literal["force", "torque", "rate", "locked"], BY_RATE]


class ReevedRope(Winch):
    """Drive of the rope by the winch, and what the winch turns."""

    drive: RopeDrive = "force"  # what the input of the winch is: an effort [N] on
    # the length, positive pays out, n times the pull on the lead line of n falls; the drum's torque
    # [N m], positive pays out; by `rate` the length's acceleration [m/s²], with `time_constant` its
    # velocity [m/s]; or nothing, the length stays
    reeving: ReevingGroup | None = None  # falls, sheaves and drum; left out: the rope is one,
    # without inertia and loss
    friction: Friction | None = None  # N, of a winch driven by force or torque, in terms of the
    # length
    torsion: Torsion | None = None  # what resists a twist between tip and payload; left out: the
    # payload turns freely

    @property
    def takes_motor(self) -> bool:
        """Whether a motor's inertia adds to what the winch turns."""
        return self.reeving is not None and self.drive == "force"

    def check(self, start: float, rate: float, joint: int) -> None:
        """Raise SceneError as `Winch.check`, and for falls, drum and friction that do not fit."""
        super().check(start, rate, joint)
        drive, reeving, by_effort = self.drive, self.reeving, self.drive in ("force", "torque")
        if self.friction is not None and not by_effort:
            raise SceneError(
                "rope.friction: belongs to a winch driven by force or torque, this drive is "
                f"{drive!r}"
            )
        if drive == "torque" and (reeving is None or reeving.drum is None):
            raise SceneError(
                "rope.drive = 'torque': is that of a drum; give rope.reeving.drum, or take 'force'"
            )
        if reeving is None:
            return
        if drive == "locked":
            raise SceneError(
                "rope.reeving: belongs to a winch that moves the rope, this drive is 'locked'"
            )
        if self.slack != "stop":
            raise SceneError(
                f"rope.slack = {self.slack!r}: falls of a reeving cannot push; take 'stop'"
            )
        low, high = self.limits or (MIN_LENGTH, start)
        reeving.check(low, high, "rope")

    def check_surroundings(self, file: Any) -> None:
        """Raise SceneError for motors, base motions and events that do not fit drive and rope."""
        extras = [key for key in ("reeving", "friction") if getattr(self, key) is not None]
        if extras and self.drive in ("force", "torque") and getattr(file, "events", ()):
            raise SceneError(
                f"events: an impact on a winch with rope.{extras[0]} is not modelled; take "
                "rope.drive: rate"
            )
        if self.torsion is not None and file.payload.inertia is None:
            raise SceneError(
                "rope.torsion: belongs to a payload that is a body; give payload.inertia, or leave "
                "it out"
            )
        if self.drive == "torque" and motor_of(file, "rope") is not None:
            raise SceneError(
                "actuators.rope.motor: belongs to rope.drive: force; give rope.reeving.drum its "
                "inertia"
            )
        has_weight = self.reeving is not None and self.reeving.mass_per_length is not None
        if has_weight and file.base_motion is not None:
            raise SceneError(
                "rope.reeving.mass_per_length: belongs to a base that rests, here is base_motion"
            )

    def stops(self, limited: bool) -> Stops | None:
        """Return what ends a run, None for nothing; `limited`: some joint has travel limits."""
        stops = super().stops(limited or self.friction is not None)
        if stops is None or self.reeving is None:
            return stops
        return stops._replace(longest=min(stops.longest, self.reeving.longest))

    def drive_of(self, file: Any) -> MasslessHoist | MotionHoist | ReevedHoist | None:
        """Return the drive of the first link of a crane's file; None: its length stays.

        Raises:
            SceneError: motor or friction do not fit it.
        """
        friction = check_friction("rope.friction", self.friction)
        motor = reflected_inertia(file, "rope") if self.takes_motor else 0.0
        reeving = self.reeving.model(motor, "rope") if self.reeving is not None else None
        if self.drive == "rate":
            return MotionHoist(self.time_constant, reeving)
        if self.drive == "locked" or (reeving is None and friction is None):
            return self.hoist()
        by_torque = Torque() if self.drive == "torque" else None
        return ReevedHoist(reeving or Reeving(1, 0), friction, by_torque)
