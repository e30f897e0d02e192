"""Base class of schemas of cranes whose driven joints move a tip, from which rope, falls or links hang."""

from abc import abstractmethod
from collections.abc import Mapping
from math import cos, sin
from typing import Any, ClassVar, NamedTuple, Self

import numpy as np
from pydantic import ValidationInfo, field_validator

from crane_sim.files.errors import SceneError
from crane_sim.models.supports.flexible import FlexibleSupport
from crane_sim.models.supports.friction import Friction
from crane_sim.models.supports.lugre import LuGre
from crane_sim.models.supports.tower_crane import LockedSlew
from crane_sim.scenes.schema.actuated import with_friction_and_motors
from crane_sim.scenes.schema.backlash import (
    JointDrives,
    SupportJoints,
    add_backlash,
    check_joint_names,
    initial_drive_state,
)
from crane_sim.scenes.schema.flexibility import Bending, deflections, inner_inertias, modes_of
from crane_sim.scenes.schema.friction_checks import friction_rate
from crane_sim.scenes.schema.limits import TravelLimits
from crane_sim.scenes.schema.scene_file import SceneFile


class Tip(NamedTuple):
    """Pose of the support's frame relative to the base, in the base's axes."""

    position: tuple[float, float, float]  # m, of the tip
    yaw: float = 0.0  # rad, of the frame's axes about the vertical


class JointMobility(NamedTuple):
    """What the mobility of a support's tip is made of: Jacobian J and mass matrix M of its n joints.

    A mobility is an inverse inertia, here J M⁻¹ Jᵀ (Hogan, J. Dyn. Syst. Meas. Control 107, 1985), in the axes of the
    support's frame.
    """

    jacobian_t: Any  # (n, 4) m or -, Jᵀ: rates of the tip's x, y, z and the frame's yaw for unit rates of the joints
    inverse_inertia: Any  # (n, n) 1/kg or 1/(kg m²), M⁻¹; 0 for a joint that no effort moves


class SupportedFile(SceneFile):
    """Scene file of a crane whose tip a support carries: the groups that all of them have.

    A subclass says what the load hangs on: `SuspendedFile` (one rope and links) or `HoistedFile` (falls). The schema of
    a crane adds its support, initial state, reference and inputs.
    """

    support_joints: ClassVar[SupportJoints]  # each (name, unit of its position, unit of its effort)
    friction_joints: ClassVar[tuple[str, ...]] = ()  # joints that can have friction; empty: all of the support's
    friction: dict[str, Friction] = {}  # by joint of the support: its dry friction; the winch of a `rope` has
    # `rope.friction`
    lugre: dict[str, LuGre] = {}  # by joint of the support: dry friction by bristles; a joint has this or `friction`
    backlash: dict[str, JointDrives] = {}  # by joint of the support: its drives, one or several side by side, which
    # have play; joints that are left out have none

    @property
    def driven_joints(self) -> SupportJoints:
        """The joints of the support that take commands: all of them, unless a schema says otherwise."""
        return self.support_joints

    @abstractmethod
    def support(self) -> Any:
        """Return the parameters of the support.

        Raises:
            SceneError: its groups contradict each other.
        """

    @abstractmethod
    def joint_mobility(self) -> JointMobility:
        """Return the mobility of the support's joints at t = 0, without motors and deflections of the structure."""

    @property
    @abstractmethod
    def support_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the support's joints that have some."""

    @abstractmethod
    def _tip_radius_and_height(self, q: Any, bend: float) -> tuple[float, float]:
        """Return (radius, height) [m] of the tip at joint positions q, the structure bent upwards by `bend` [rad]."""

    def _elevation_and_length(self, q: Any) -> tuple[float, float]:
        """Return (elevation [rad], length [m]) of the structure at joint positions q, for a structure that can bend."""
        raise NotImplementedError

    @property
    @abstractmethod
    def _suspended_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""

    @field_validator("friction", "lugre", "backlash", mode="before")
    @classmethod
    def _check_names(cls, group: Any, info: ValidationInfo) -> Any:
        """Reject groups of joints that the support lacks, before their values are read."""
        names = tuple(name for name, _, _ in cls.support_joints)
        return check_joint_names(group, names if info.field_name == "backlash" else cls.friction_joints or names)

    @property
    def _initial(self) -> Any:
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
        gravity, structure = getattr(self, "gravity", 0.0), self._elevation_and_length(q)
        return deflections(self.support(), group, structure, gravity, self._suspended_mass)

    def _left_to_rest(self) -> Self:
        """Return the file without deflections given for t = 0: its structure bends as it does at rest."""
        group = getattr(self, "flexibility", None)
        return self if group is None else self.model_copy(update={"flexibility": group.left_to_rest()})

    def tip(self, q: Any) -> Tip:
        """Return the pose of the support's frame at joint positions q, the structure bent by the first payload."""
        angles = dict(zip(self._bending, self._deflections(q), strict=True))
        radius, height = self._tip_radius_and_height(q, angles.get("vertical_deflection", 0.0))
        yaw = q[0] + angles.get("lateral_deflection", 0.0) if self._slews else 0.0
        return Tip((radius * cos(yaw), radius * sin(yaw), height), yaw)

    def tip_mobility(self) -> Any:
        """Return the tip's mobility (4, 4) at t = 0: x, y, z [1/kg] and yaw [1/(kg m²)], in the axes of the base."""
        (jacobian_t, inverse), yaw = self.joint_mobility(), self.tip(self._initial.q).yaw
        s, c = sin(yaw), cos(yaw)
        rotation = np.eye(4)
        rotation[:2, :2] = [[c, -s], [s, c]]
        return rotation @ jacobian_t.T @ inverse @ jacobian_t @ rotation.T

    def _friction_rate(self) -> float:
        """Return an upper bound [1/s] of the eigenvalues that friction gives the joints of the support; 0 without.

        Of joints that move each other it is the sum: no eigenvalue of M⁻¹ D exceeds the trace.
        """
        matrix, support = self.joint_mobility().inverse_inertia, self.support()
        inverse, coupled = matrix.diagonal().copy(), np.count_nonzero(matrix, axis=1) > 1
        if isinstance(support, FlexibleSupport):  # friction is on the side of the drives
            inner = inner_inertias(support, self._elevation_and_length(self._initial.q))
            for i, mode in enumerate((support.lateral, support.vertical)):
                inverse[i] = 1.0 / inner[i] if mode is not None and np.isfinite(inner[i]) else inverse[i]
        rates = np.zeros(len(inverse))
        for i, ((name, _, _), mobility) in enumerate(zip(self.support_joints, inverse, strict=False)):
            friction_models = (group.get(name) for group in (self.friction, self.lugre))
            if mobility > 0.0:
                rates[i] = max(friction_rate(part, 1.0 / mobility) for part in friction_models)
        return float(max(rates.max(), rates[coupled].sum()))

    def _check_inputs(self, inputs: Any) -> None:
        """Raise SceneError for an input of a joint that no command moves: it would have no effect."""
        driven = [name for name, _, _ in self.driven_joints]
        for name, _, _ in self.support_joints:
            if name in inputs.model_fields_set and name not in driven:
                raise SceneError(
                    f"inputs.{name}: drives nothing, {name}.drive = {getattr(self, name).drive!r}; leave it out"
                )
        if "slew" in inputs.model_fields_set and isinstance(getattr(self, "slew", None), LockedSlew):
            raise SceneError("inputs.slew: drives nothing, slew.drive = 'locked'; leave it out")

    @property
    def _initial_drive_state(self) -> tuple[Any, Any]:
        """Initial (positions, velocities) of the drives that have play."""
        return initial_drive_state(self.backlash, self.support_joints, self._initial.q, self._initial.v)

    def _driven_support(self) -> Any:
        """Return the support with friction, motors and play of its joints."""
        joints = self.support_joints
        return add_backlash(with_friction_and_motors(self.support(), self, joints), self.backlash, joints)
