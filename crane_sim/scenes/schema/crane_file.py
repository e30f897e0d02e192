"""A crane's scene file: a support, what hangs below its tip, and groups of all such cranes."""

from abc import abstractmethod
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import NonNegative
from crane_sim.models.effects import PayloadDrag, PayloadForce
from crane_sim.models.supports.support import Support
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.backlash import (
    drive_names,
    drive_units,
    drives_at_start,
    shaft_frequency,
)
from crane_sim.scenes.schema.exchange import ExchangeEvent, windages_of
from crane_sim.scenes.schema.friction_checks import friction_rate
from crane_sim.scenes.schema.groups import PayloadForceGroup
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.limits import TravelLimits
from crane_sim.scenes.schema.reference import target_of
from crane_sim.scenes.schema.rigging import Payload
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.schema.small_motions import SmallMotions, Tip, small_motions, tip_of
from crane_sim.scenes.schema.supports import SupportGroups
from crane_sim.trajectories.inputs import Inputs


class CraneFile(SupportGroups, SceneFile):
    """The groups of all such cranes; `registry.file_of` joins them to those of support and load.

    Joints are the support's, those of what hangs, what bends, and drives that have play, in this
    order.
    """

    gravity: NonNegative = 9.81  # m/s², acceleration of free fall
    payload: Payload  # at the end of rope or links
    payload_drag: PayloadDrag | None = None  # drag of still air on the payload
    payload_force: PayloadForceGroup | None = None  # a given force on the payload

    winch: ClassVar[tuple[str, ...]] = ()  # joint of the winch, for which a target has a length

    @property
    def winch_units(self) -> dict[str, str]:
        """Unit of the winch's command by its joint, empty where none moves."""
        return {}

    @property
    @abstractmethod
    def hanging_joints(self) -> dict[str, str]:
        """Units of the joints of what hangs, by name; that of the winch is the first."""

    @property
    @abstractmethod
    def hanging_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of these joints at t = 0."""

    @property
    @abstractmethod
    def hung_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""

    @property
    def hanging_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the winch."""
        return ()

    @abstractmethod
    def stiffest(self) -> float:
        """Return the largest frequency or decay rate [rad/s] of the crane's small motions."""

    @property
    def _start(self) -> Any:
        return getattr(self, "initial")  # noqa: B009  (declared with the kind of crane)

    @property
    def schedule(self) -> tuple[ExchangeEvent, ...]:
        """The exchanges of the payload."""
        return getattr(self, "events")  # noqa: B009  (declared with what hangs)

    @cached_property
    def _structure(self) -> Any:
        """The structure, checked; parameters of the model."""
        start, goal = self._start, getattr(self, "reference", None)
        self.check_start(start, goal.q if goal is not None else None)
        return self.structure(start.q)

    @cached_property
    def own_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of the support's joints at t = 0, bending left out."""
        start, n = self._start, len(self.joints)
        return start.q[:n], self.velocities_at_start(start)[:n]

    @cached_property
    def _bent(self) -> tuple[float, ...]:
        return self.deflections(self._structure, self.own_start[0], self.gravity, self.hung_mass)

    def tip(self, q: Any = None) -> Tip:
        """Return the tip's pose at positions q of the support, bent by the first payload."""
        if q is None:
            return tip_of(self._structure, (*self.own_start[0], *self._bent))
        return tip_of(
            self._structure,
            (*q, *self.deflections(self._structure, q, self.gravity, self.hung_mass)),
        )

    @cached_property
    def small_motions(self) -> SmallMotions:
        """Small motions of the support about its posture at t = 0."""
        return small_motions(self._structure, (*self.own_start[0], *self._bent))

    def support(self) -> Support:
        """Return the support with its drives."""
        return self.carrier(self._structure, self)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints (nq,)."""
        return (
            *self.support_joints,
            *self.hanging_joints,
            *self.modes,
            *drive_names(self.play, self.joints),
        )

    @property
    def joint_units(self) -> tuple[str, ...]:
        """Units of the joints' positions (nq,)."""
        own, bending = (joint.unit for joint in self.joints), ("rad" for _ in self.modes)
        return (*own, *self.hanging_joints.values(), *bending, *drive_units(self.play, self.joints))

    @property
    def actuated(self) -> tuple[str, ...]:
        """Joints that take commands (nu,): those of the support that are driven, and the winch."""
        return (*(joint.name for joint in self.driven_joints), *self.winch_units)

    @property
    def effort_units(self) -> tuple[str, ...]:
        """Units of the commands (nu,)."""
        return (*(joint.effort_unit for joint in self.driven_joints), *self.winch_units.values())

    @property
    def initial_q(self) -> tuple[float, ...]:
        """Joint positions at t = 0 (nq,)."""
        drives = drives_at_start(self.play, self.joints, *self.own_start)
        return (*self.own_start[0], *self.hanging_start[0], *self._bent, *drives[0])

    @property
    def initial_v(self) -> tuple[float, ...]:
        """Joint velocities at t = 0 (nq,)."""
        drives = drives_at_start(self.play, self.joints, *self.own_start)
        return (*self.own_start[1], *self.hanging_start[1], *(0.0,) * len(self.modes), *drives[1])

    @property
    def limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the joints that have some."""
        rows = []
        for i, limits in enumerate(self._structure.mechanism().limits[: len(self.joints)]):
            if limits is not None:
                key = self._structure.coordinate(i)[1]
                rows.append(TravelLimits(self.joints[i].name, key, *limits))
        return (*rows, *self.hanging_limits)

    @property
    def target(self) -> tuple[float, ...] | None:
        """Target of the actuated joints (nu,), in the file also of a rope of constant length.

        Raises:
            SceneError: it has another number of values, or the length of rope or falls is not
                greater than 0.
        """
        names = (*(joint.name for joint in self.driven_joints), *self.winch)
        target = target_of(getattr(self, "reference", None), names)
        if target is not None and self.winch and not target[-1] > 0.0:
            i = len(target) - 1
            raise SceneError(
                f"reference.q[{i}] = {target[i]:g}: is a length, must be greater than 0"
            )
        return None if target is None else target[: len(self.actuated)]

    @property
    def payload_mass(self) -> float:
        """Mass of the payload at t = 0 [kg]."""
        return self.payload.mass

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key."""
        return windages_of(self.payload, self.schedule) | self.support_windages

    def force(self) -> PayloadForce | None:
        """Return the given force on the payload, None without one."""
        return self.payload_force.force() if self.payload_force is not None else None

    def requirements(self) -> MethodRequirements:
        """Return the scene's requirements on its method."""
        smooth = self.is_smooth and not self.is_sampled
        return MethodRequirements(
            self.stiffest() or None, 0.0, self.is_elastic, smooth, self.duration
        )

    is_elastic: ClassVar = False  # whether springs carry the load

    @property
    @abstractmethod
    def is_smooth(self) -> bool:
        """Whether nothing switches and nothing has a kink."""

    def support_rate(self) -> float:
        """Return a bound [rad/s] of the frequencies and decay rates of the support."""
        friction = [self.friction_rate()] if self.play or hasattr(self, "friction") else []
        return max(shaft_frequency(self.play), self.small_motions.bending_rate, *friction, 0.0)

    def friction_rate(self) -> float:
        """Return an upper bound [1/s] of the eigenvalues of friction in the support; 0 without.

        Of joints that move each other it is the sum: no eigenvalue of M⁻¹ D exceeds the trace.
        """
        matrix, rates = self.small_motions.mobility, np.zeros(len(self.joints))
        for i, joint in enumerate(self.joints):
            for group in (getattr(self, key, {}).get(joint.name) for key in ("friction", "lugre")):
                if matrix[i, i] > 0.0:
                    rates[i] = max(rates[i], friction_rate(group, 1.0 / matrix[i, i]))
        own = matrix[: len(rates), : len(rates)]
        coupled = np.count_nonzero(own, axis=1) > 1
        return float(max(rates.max(), rates[coupled].sum()))

    def open_loop(self) -> Inputs | tuple[float, ...]:
        """Return the open-loop inputs, 0 where left out; none: efforts that move nothing.

        Raises:
            SceneError: there is an input of a joint that no drive moves.
        """
        inputs = getattr(self, "inputs", None)
        if inputs is None:
            return tuple(
                q if unit == joint.unit else 0.0
                for joint, q, unit in zip(
                    self.joints, self.own_start[0], self.effort_units, strict=False
                )
            ) + (0.0,) * len(self.winch_units)
        for name in inputs.model_fields_set:
            if name not in self.actuated or self.is_locked(name):
                raise SceneError(
                    f"inputs.{name}: drives nothing, {self.why_still(name)}; leave it out"
                )
        return Inputs(tuple(getattr(inputs, name) for name in self.actuated))

    def rest_at(self, target: tuple[float, ...]) -> tuple[float, ...]:
        """Return positions of support and winch at a target (nu,), other joints as they start."""
        names = (*self.support_joints, *self.winch_units)
        start = (*self.own_start[0], *self.hanging_start[0][: len(self.winch_units)])
        at = dict(zip(names, start, strict=True)) | dict(zip(self.actuated, target, strict=True))
        return tuple(at[name] for name in names)
