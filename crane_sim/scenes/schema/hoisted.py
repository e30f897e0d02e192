"""Base class of scene files of cranes with driven joints whose load hangs on elastic falls, wound up by one winch."""

from typing import Any

from crane_sim.models.falls.crane import FallsCrane
from crane_sim.scenes.schema.backlash import drive_names, drive_units, shaft_frequency
from crane_sim.scenes.schema.falls_file import PLACE, FallsFile, LoadStart
from crane_sim.scenes.schema.falls_winch import Hoist, Ropes
from crane_sim.scenes.schema.flexibility import structure_frequency
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.rigging import ATTITUDE
from crane_sim.scenes.schema.supported import SupportedFile
from crane_sim.trajectories.inputs import Constant, Inputs


class HoistedFile(SupportedFile, FallsFile):
    """The groups of all such cranes; a schema adds its support, its initial state, reference and inputs."""

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
        return (*(unit for _, _, unit in self.driven_joints), self.hoist.effort_unit)

    @property
    def actuated(self) -> tuple[str, ...]:
        """Joints that take commands: those of the support, and the winch."""
        return (*(name for name, _, _ in self.driven_joints), "hoist")

    @property
    def _suspended_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""
        return self.payload.mass

    @property
    def _driven_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of support and winch at t = 0."""
        return self._initial.q, self._initial.v

    @property
    def _length(self) -> float:
        """Unstretched length [m] of the falls at t = 0."""
        return self._initial.q[-1]

    @property
    def _load_start(self) -> LoadStart:
        """The load at t = 0."""
        return self._initial

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0."""
        return (*self._initial.q, *self._load_q, *self._deflections(self._initial.q), *self._initial_drive_state[0])

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0."""
        return (*self._initial.v, *self._load_v, *(0.0,) * len(self._bending), *self._initial_drive_state[1])

    def rest_positions(self, target: tuple[float, ...]) -> tuple[float, ...]:
        """Return the joint positions (nq,) of the crane at rest at a target of the actuated joints (nu,)."""
        names = (*(name for name, _, _ in self.support_joints), "hoist")
        at = dict(zip(names, self._initial.q, strict=True)) | dict(zip(self.actuated, target, strict=True))
        starts = [at[name.split("_drive_")[0]] for name in drive_names(self.backlash, self.support_joints)]
        q, file = tuple(at[name] for name in names), self._left_to_rest()
        return (*q, *file._rest_pose(q, q[-1], None), *file._deflections(q), *starts)

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
        winch, rubs = self.hoist.inertia(self._ropes, self._length)
        rates = [shaft_frequency(self.backlash), self._friction_rate(), rubs]
        if self._bending:
            rates.append(structure_frequency(self.support(), self._elevation_and_length(self._initial.q)))
        return self._requirements(winch, max(rates))

    def model(self) -> FallsCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        names = tuple(name for name, _, _ in self.support_joints)
        hoist = self.hoist.model(self._ropes, self._length)
        return self.falls_crane(self._driven_support(), hoist, self.hoist.range, names)

    @property
    def _ropes(self) -> Ropes:
        return Ropes(len(self.falls.top), self.falls.parts)

    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the open-loop inputs, zero where one is left out; constant zero efforts without `inputs`.

        Raises:
            SceneError: there is an input of a slew that no drive moves.
        """
        inputs: Any = getattr(self, "inputs", None)
        if inputs is None:
            return (0.0,) * len(self.actuated)
        self._check_inputs(inputs)
        return Inputs(tuple(getattr(inputs, name, Constant(0.0)) for name in self.actuated))
