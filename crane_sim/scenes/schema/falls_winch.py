"""The group `hoist` of a scene file with falls: the winch that drives their length."""

from math import inf
from typing import Annotated, Literal, NamedTuple

from crane_sim.files.errors import SceneError
from crane_sim.files.types import LengthRange, Positive
from crane_sim.models.stops import MIN_LENGTH
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.hoist import ForceHoist, MotionHoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist, Torque
from crane_sim.models.supports.reeving import Drum, Reeving
from crane_sim.scenes.schema.friction_checks import check_friction, friction_rate
from crane_sim.scenes.schema.groups import BY_RATE, Group
from crane_sim.scenes.schema.reeving import ReevingGroup


class Ropes(NamedTuple):
    """The ropes of a load on falls."""

    number: int  # falls of the load, each a rope of its own
    parts: int  # of the rope in each


WinchDrive = Annotated[Literal["force", "torque", "rate"], BY_RATE]


class Hoist(Group):
    """The winch, which drives the length of all falls."""

    drive: WinchDrive = "rate"  # what its input is: an effort on the falls' common length [N],
    # positive pays out; the torque of the drum of `reeving` [N m], positive pays out; or by `rate`
    # the length's acceleration [m/s²], with `time_constant` its velocity [m/s]
    mass: Positive | None = None  # kg, of a `force` drive: inertia of drum and motor over the
    # square of the drum's radius, times the square of rope paid out per length of the falls; left
    # out with `reeving`, which has it
    time_constant: Positive | None = None  # s, of a `rate` drive: its input is then the velocity
    # [m/s], followed with this lag; left out: the acceleration
    limits: LengthRange | None = None  # m, of the falls' unstretched length; a run ends where one
    # is reached
    reeving: ReevingGroup | None = None  # sheaves of each fall and the drum of all; left out: the
    # winch has its `mass`
    friction: Friction | None = None  # N, of a winch driven by force or torque, in terms of the
    # length

    @property
    def effort_unit(self) -> str:
        """Unit of the winch's command."""
        if self.drive != "rate":
            return "N" if self.drive == "force" else "N m"
        return "m/s²" if self.time_constant is None else "m/s"

    @property
    def range(self) -> tuple[float, float] | None:
        """Shortest and longest length [m], also by the rope that there is; None: any."""
        if self.reeving is None or self.reeving.longest == inf:
            return self.limits
        low, high = self.limits or (0.0, inf)
        return low, min(high, self.reeving.longest)

    def inertia(self, ropes: Ropes, length: float) -> tuple[float | None, float]:
        """Return (mass [kg] that moves with the length, largest rate [1/s] of friction).

        The mass is None where the length is imposed.

        Args:
            ropes: of the falls.
            length: of the falls at t = 0 [m].

        Raises:
            SceneError: as of `model`.
        """
        if isinstance(self.model(ropes, length), MotionHoist):
            return None, 0.0
        mass = self.mass if self.reeving is None else self.reeving.least_mass(ropes.number)
        return mass, friction_rate(check_friction("hoist.friction", self.friction), mass or 0.0)

    def model(self, ropes: Ropes, length: float) -> ForceHoist | MotionHoist | ReevedHoist:
        """Return the winch; arguments of `inertia`.

        Raises:
            SceneError: a key belongs to the other drive, is missing, or does not fit the falls.
        """
        self._check_drive()
        if self.reeving is not None:
            self._check_reeving(self.reeving, ropes, length)
        reeving = (
            self.reeving.model(0.0, "hoist", ropes.number) if self.reeving is not None else None
        )
        if self.drive == "rate":
            return MotionHoist(self.time_constant, reeving)
        friction = check_friction("hoist.friction", self.friction)
        if self.mass is not None and friction is None:
            return ForceHoist(self.mass)
        if self.mass is not None:
            reeving = Reeving(1, 0, drum=Drum(1.0, self.mass))
        assert reeving is not None, "a winch without a mass has a reeving"
        return ReevedHoist(reeving, friction, Torque() if self.drive == "torque" else None)

    def _check_drive(self) -> None:
        """Raise SceneError for keys that belong to another drive, or are missing."""
        if self.drive == "rate":
            self._check_rate_drive()
        else:
            self._check_effort_drive()

    def _check_rate_drive(self) -> None:
        if self.mass is not None:
            raise SceneError("hoist.mass: only a force drive has one, this drive is 'rate'")
        if self.friction is not None:
            raise SceneError(
                "hoist.friction: belongs to a winch driven by force or torque, this drive is 'rate'"
            )

    def _check_effort_drive(self) -> None:
        if self.time_constant is not None:
            raise SceneError(
                f"hoist.time_constant: only a rate drive has one, this drive is {self.drive!r}"
            )
        if self.drive == "torque" and (self.reeving is None or self.reeving.drum is None):
            raise SceneError(
                "hoist.drive = 'torque': is that of a drum; give hoist.reeving.drum, or take "
                "'force'"
            )
        if self.mass is None and self.reeving is None:
            raise SceneError(
                "hoist.mass: is missing; a force drive needs it, or a hoist.reeving with a drum"
            )
        if self.mass is not None and self.reeving is not None:
            raise SceneError(
                "hoist.mass: is what hoist.reeving says of sheaves and drum; leave out one of the "
                "two"
            )

    def _check_reeving(self, reeving: ReevingGroup, ropes: Ropes, length: float) -> None:
        """Raise SceneError for a reeving that does not fit the falls or lacks inertia."""
        if reeving.falls != ropes.parts:
            raise SceneError(
                f"hoist.reeving.falls = {reeving.falls}: each fall has falls.parts = {ropes.parts} "
                "parts of rope; "
                "make them equal"
            )
        if reeving.mass_per_length is not None:
            raise SceneError(
                "hoist.reeving.mass_per_length: the rope of elastic falls weighs nothing; leave it "
                "out"
            )
        low, high = self.limits or (MIN_LENGTH, length)
        reeving.check(low, high, "hoist")
        if self.drive != "rate" and not reeving.least_mass(ropes.number) > 0.0:
            raise SceneError(
                "hoist.reeving.drum.inertia: is missing; elastic falls would turn a winch driven "
                f"by {self.drive!r} "
                "without inertia at once"
            )
