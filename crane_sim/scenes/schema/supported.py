"""Base class of scene files of cranes with driven joints between base and tip, whatever hangs below."""

from abc import abstractmethod
from collections.abc import Mapping
from math import cos, sin
from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydantic import ValidationInfo, field_validator

from crane_sim.models.supports.flexible import FlexibleSupport
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.lugre import LuGre
from crane_sim.scenes.schema.actuated import actuated
from crane_sim.scenes.schema.backlash import JointDrives, SupportJoints, drive_start, geared, known_joints
from crane_sim.scenes.schema.flexibility import Bending, deflections, inner_inertias, modes_of
from crane_sim.scenes.schema.friction_checks import friction_rate
from crane_sim.scenes.schema.limits import TravelLimits
from crane_sim.scenes.schema.scene_file import SceneFile


class Tip(NamedTuple):
    """Where the support's frame is, relative to the base and in its axes."""

    position: tuple[float, float, float]  # m, of the tip
    yaw: float = 0.0  # rad, of the frame's axes about the vertical


class JointMobility(NamedTuple):
    """How a support's n joints move its tip, in the axes of its frame."""

    levers: Any  # (n, 4) m or -, rates of the tip's x, y, z and of the frame's yaw for a unit rate of each joint
    inverse: Any  # (n, n) the inverse of the joints' mass matrix, 0 for a joint that no effort moves


class SupportedFile(SceneFile):
    """The groups of all such cranes; a schema adds its support, its initial state, reference and inputs.

    What the load hangs on is that of a subclass: `SuspendedFile` (one rope and links) or `HoistedFile` (falls).
    """

    support_joints: ClassVar[SupportJoints]  # each (name, unit of its position, unit of its effort)
    friction_joints: ClassVar[tuple[str, ...]] = ()  # joints that can have friction; empty: all of the support's
    friction: dict[str, Friction] = {}  # by joint of the support: its dry friction; the winch of a `rope` has
    # `rope.friction`
    lugre: dict[str, LuGre] = {}  # the same by bristles, of joints without `friction`
    backlash: dict[str, JointDrives] = {}  # by joint of the support: its drives, one or several side by side, which
    # have play; a joint that is left out has none

    @abstractmethod
    def support(self) -> Any:
        """Return the parameters of the support.

        Raises:
            SceneError: its groups contradict each other.
        """

    @abstractmethod
    def joint_mobility(self) -> JointMobility:
        """Return the mobility of the support's joints at t = 0, motors and what bends it left out."""

    @property
    @abstractmethod
    def support_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the support's joints that have some."""

    @abstractmethod
    def _reach(self, q: Any, bend: float) -> tuple[float, float]:
        """Return (radius, height) [m] of the tip at joint positions q, the structure bent upwards by `bend` [rad]."""

    def _place(self, q: Any) -> tuple[float, float]:
        """Return (elevation [rad], length [m]) of the structure at joint positions q; of those that can bend."""
        raise NotImplementedError

    @property
    @abstractmethod
    def _hung_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""

    @field_validator("friction", "lugre", "backlash", mode="before")
    @classmethod
    def _check_names(cls, group: Any, info: ValidationInfo) -> Any:
        """Reject groups of joints that the support does not have, before their values are read."""
        names = tuple(name for name, _, _ in cls.support_joints)
        return known_joints(group, names if info.field_name == "backlash" else cls.friction_joints or names)

    @property
    def _start(self) -> Any:
        return getattr(self, "initial")  # noqa: B009  (every schema declares its own)

    @property
    def _slews(self) -> bool:
        return self.support_joints[0][0] == "slew"

    @property
    def _bending(self) -> Mapping[str, Bending]:
        """Modes of the structure by the name of their joint."""
        return modes_of(getattr(self, "flexibility", None))

    def _deflections(self, q: Any) -> tuple[float, ...]:
        """Return the angles [rad] of the structure's modes with the first payload hanging at joint positions q."""
        if not self._bending:
            return ()
        group = getattr(self, "flexibility", None)
        return deflections(self.support(), group, self._place(q), getattr(self, "gravity", 0.0), self._hung_mass)

    def tip(self, q: Any) -> Tip:
        """Return where the support's frame is at joint positions q, the structure bent by the first payload."""
        angles = dict(zip(self._bending, self._deflections(q), strict=True))
        radius, height = self._reach(q, angles.get("vertical_deflection", 0.0))
        yaw = q[0] + angles.get("lateral_deflection", 0.0) if self._slews else 0.0
        return Tip((radius * cos(yaw), radius * sin(yaw), height), yaw)

    def tip_mobility(self) -> Any:
        """Return the tip's mobility (4, 4) at t = 0: x, y, z [1/kg] and yaw [1/(kg m²)], in the axes of the base."""
        (levers, inverse), (s, c) = self.joint_mobility(), (sin(yaw := self.tip(self._start.q).yaw), cos(yaw))
        turn = np.eye(4)
        turn[:2, :2] = [[c, -s], [s, c]]
        return turn @ levers.T @ inverse @ levers @ turn.T

    def _friction_rate(self) -> float:
        """Return a bound [1/s] of frequencies and rates of the support's joints on their friction, 0 without."""
        inverse, support = self.joint_mobility().inverse.diagonal().copy(), self.support()
        if isinstance(support, FlexibleSupport):  # friction is on the side of the drives
            inner = inner_inertias(support, self._place(self._start.q))
            for i, mode in enumerate((support.lateral, support.vertical)):
                inverse[i] = 1.0 / inner[i] if mode is not None and np.isfinite(inner[i]) else inverse[i]
        rates = [0.0]
        for (name, _, _), mobility in zip(self.support_joints, inverse, strict=False):
            rubbing = (group.get(name) for group in (self.friction, self.lugre))
            rates += [friction_rate(part, 1.0 / mobility) for part in rubbing if mobility > 0.0]
        return max(rates)

    @property
    def _drives(self) -> tuple[Any, Any]:
        """(q, v) of drives with play."""
        return drive_start(self.backlash, self.support_joints, self._start.q, self._start.v)

    def _driven_support(self) -> Any:
        """Return the support with its drives."""
        joints = self.support_joints
        return geared(actuated(self.support(), self, joints), self.backlash, joints)
