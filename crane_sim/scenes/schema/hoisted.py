"""Base class of scene files of cranes with driven joints whose load hangs on elastic falls, wound up by one winch."""

from typing import Any, Literal

from crane_sim.files.errors import SceneError
from crane_sim.files.types import LengthRange, Positive
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.supports.hoist import ForceHoist, RateHoist
from crane_sim.scenes.schema.backlash import drive_names, drive_units, shaft_frequency
from crane_sim.scenes.schema.falls_file import PLACE, FallsFile, LoadStart
from crane_sim.scenes.schema.flexibility import structure_frequency
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.scenes.schema.supported import SupportedFile
from crane_sim.trajectories.inputs import Constant, Inputs


class Hoist(Group):
    """The winch, which drives the length of all falls."""

    drive: Literal["force", "rate"] = "rate"  # what its input is: an effort on the falls' common length [N], positive
    # pays out; or the length's acceleration [m/s²]
    mass: Positive | None = None  # kg, of a `force` drive: inertia of drum and motor over the square of the drum's
    # radius, times the square of rope paid out per length of the falls
    time_constant: Positive | None = None  # s, of a `rate` drive, whose input is then a rate [m/s], followed with this
    # lag; left out: the input is an acceleration
    limits: LengthRange | None = None  # m, of the falls' unstretched length; a run ends where one is reached

    @property
    def effort_unit(self) -> str:
        """Unit of the winch's command."""
        if self.drive == "force":
            return "N"
        return "m/s²" if self.time_constant is None else "m/s"

    def model(self) -> ForceHoist | RateHoist:
        """Return the winch.

        Raises:
            SceneError: a key belongs to the other drive, or is missing.
        """
        if self.drive == "rate":
            if self.mass is not None:
                raise SceneError("hoist.mass: only a force drive has one, this drive is 'rate'")
            return RateHoist(self.time_constant)
        if self.time_constant is not None:
            raise SceneError("hoist.time_constant: only a rate drive has one, this drive is 'force'")
        if self.mass is None:
            raise SceneError("hoist.mass: is missing; a force drive needs it")
        return ForceHoist(self.mass)


class HoistedFile(SupportedFile, FallsFile):
    """The groups of all such cranes; a form adds its support, its initial state, reference and inputs."""

    hoist: Hoist = Hoist()  # the winch

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Joints: the support's, the falls' length, the load's position and attitude, bending, drives with play."""
        own, drives = (name for name, _, _ in self.support_joints), drive_names(self.backlash, self.support_joints)
        return (*own, "hoist", *PLACE, *ATTITUDE, *self._bending, *drives)

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions."""
        own, bends = (unit for _, unit, _ in self.support_joints), ("rad",) * len(self._bending)
        return (*own, *("m",) * 4, *("1",) * 4, *bends, *drive_units(self.backlash, self.support_joints))

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands."""
        return (*(unit for _, _, unit in self.support_joints), self.hoist.effort_unit)

    @property
    def _hung_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""
        return self.payload.mass

    @property
    def _driven_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of support and winch at t = 0."""
        return self._start.q, self._start.v

    @property
    def _length(self) -> float:
        """Unstretched length [m] of the falls at t = 0."""
        return self._start.q[-1]

    @property
    def _load_start(self) -> LoadStart:
        """The load at t = 0."""
        return self._start

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return (*self._start.q, *self._load_q, *self._deflections(self._start.q), *self._drives[0])

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return (*self._start.v, *self._load_v, *(0.0,) * len(self._bending), *self._drives[1])

    def rest_positions(self, target: tuple[float, ...]) -> tuple[float, ...]:
        """Return the joint positions (nq,) of the crane at rest at a target of the actuated joints (nu,)."""
        drives = drive_names(self.backlash, self.support_joints)
        starts = [
            target[[name for name, _, _ in self.support_joints].index(name.split("_drive_")[0])] for name in drives
        ]
        return (*target, *self._rest_pose(target, target[-1], None), *self._deflections(target), *starts)

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints."""
        reference = self._reference
        return reference.q if reference is not None else None

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        return (*self.support_limits, *limits_of(("hoist", "hoist.limits", self.hoist.limits)))

    def method_requirements(self, sampled: bool) -> MethodRequirements:
        """Return the scene's requirements on its method."""
        rates = [shaft_frequency(self.backlash), self._friction_rate()]
        if self._bending:
            rates.append(structure_frequency(self.support(), self._place(self._start.q)))
        return self._requirements(self.hoist.mass, max(rates))

    def model(self) -> FallsCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        names = tuple(name for name, _, _ in self.support_joints)
        return self.falls_crane(self._driven_support(), self.hoist.model(), self.hoist.limits, names)

    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the open-loop inputs, zero where one is left out; constant zero efforts without `inputs`."""
        inputs: Any = getattr(self, "inputs", None)
        if inputs is None:
            return (0.0,) * len(self.actuated)
        chain = Inputs(inputs.hoist, None)
        for name, _, _ in reversed(self.support_joints):
            chain = Inputs(getattr(inputs, name, Constant(0.0)), chain)
        return chain
