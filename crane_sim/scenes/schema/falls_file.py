"""Base class of scene files of cranes whose load hangs on elastic falls, below any support."""

from abc import abstractmethod
from functools import cached_property
from math import cos, inf, sin
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.stops import LOOKAHEAD_TIME, MIN_LENGTH, Stops
from crane_sim.models.supports.hoist import ForceHoist, MotionHoist
from crane_sim.models.supports.reeved_hoist import ReevedHoist
from crane_sim.models.supports.support import Support
from crane_sim.models.wind_load import AnyWindage
from crane_sim.scenes.schema.contact import ContactGroup
from crane_sim.scenes.schema.exchange import exchange_of, windages_of
from crane_sim.scenes.schema.falls import FallsGroup, FallsStart, check_ends, stiffest_frequency
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.integrator import MethodRequirements
from crane_sim.scenes.schema.load_at_rest import load_at_rest, product, quaternion
from crane_sim.scenes.schema.load_file import LoadFile
from crane_sim.scenes.schema.rigging import (
    Payload,
    Quaternion,
    Vector,
    attitude_of,
    attitude_rate,
    check_equipment,
)
from crane_sim.scenes.schema.spreader import SpreaderEvent, contact_of, ground_velocity
from crane_sim.scenes.schema.supported import Tip

PLACE = ("payload_x", "payload_y", "payload_z")
"""The joints of a load's place: the coordinates of its centre of mass."""


class LoadStart(Group):
    """The load at t = 0; one whose position is left out hangs at rest below the tip."""

    skew: Angle | None = None  # rad, angle about the vertical, from the support's axes, at which the load is held until
    # t = 0
    position: Vector | None = None  # m, of the load's centre of mass, with `orientation`
    orientation: Quaternion | None = None  # -, unit quaternion (w, x, y, z) from the load's axes to the base's
    velocity: Vector = (0.0, 0.0, 0.0)  # m/s, of the load's centre of mass
    angular_velocity: Vector = (0.0, 0.0, 0.0)  # rad/s, of the load, in its own axes


class FallsFile(LoadFile):
    """The groups of all such cranes; a schema adds its support, its winch, its initial state, reference and inputs."""

    falls: FallsGroup  # the ropes
    payload: Payload  # spreader or sling and what it carries, one rigid body; its attachment is the spreader's origin
    contact: ContactGroup | None = None  # what the load can be set down on; left out: nothing is below it
    events: tuple[SpreaderEvent, ...] = ()  # exchanges of the payload at given times

    @abstractmethod
    def tip(self, q: Any) -> Tip:
        """Return where the support's frame is at positions q of the joints above the falls."""

    @abstractmethod
    def tip_mobility(self) -> Any:
        """Return the tip's mobility (4, 4) at t = 0: x, y, z [1/kg] and yaw [1/(kg m²)], in the axes of the base."""

    @property
    @abstractmethod
    def _driven_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of support and winch at t = 0."""

    @property
    @abstractmethod
    def _length(self) -> float:
        """Unstretched length [m] of the falls at t = 0."""

    @property
    @abstractmethod
    def _load_start(self) -> LoadStart:
        """The load at t = 0."""

    @property
    def windages(self) -> dict[str, AnyWindage | None]:
        """Windages of the bodies by key, None where a body has none."""
        return windages_of(self.payload, self.events)

    def _load(self) -> RigidLoad:
        load = self.payload.load()
        if not isinstance(load, RigidLoad):
            raise SceneError("payload.inertia: is missing; a load on falls is a rigid body")
        return load

    @cached_property
    def _load_q(self) -> tuple[float, ...]:
        """Position [m] and attitude (7,) of the load at t = 0, solved for once where it is at rest."""
        start = self._load_start
        if start.position is not None:
            if start.skew is not None:
                raise SceneError("initial.skew: not with initial.position; give initial.orientation instead")
            return (*start.position, *attitude_of(start.orientation))
        if start.orientation is not None:
            raise SceneError("initial.orientation: needs initial.position; initial.skew turns a load at rest")
        return self._rest_pose(self._driven_start[0], self._length, start.skew)

    def _rest_pose(self, q: Any, length: float, skew: float | None) -> tuple[float, ...]:
        """Return position [m] and attitude (7,) of the load at rest on falls of this length below joints at q."""
        load, ((x, y, z), yaw) = self._load(), self.tip(q)
        near = self._given_posture(length) if self._load_start.position is not None else None
        place, (w, a, b, c) = load_at_rest(self.falls.falls(length, load), load, self.gravity, skew, near)
        (dx, dy, dz), (s, k) = place.tolist(), (sin(yaw), cos(yaw))
        half_s, half_c = sin(0.5 * yaw), cos(0.5 * yaw)
        turned = half_c * w - half_s * c, half_c * a - half_s * b, half_c * b + half_s * a, half_c * c + half_s * w
        return x + k * dx - s * dy, y + s * dx + k * dy, z + dz, *map(float, turned)

    def _given_posture(self, length: float) -> Any:
        """Return the load's place [m] and attitude (7,) at t = 0, from the tip, lowered to falls of this length."""
        tip, yaw = self.tip(self._driven_start[0])
        s, c = sin(yaw), cos(yaw)
        x, y, z = np.array(self._load_q[:3]) - tip
        lowered = z - (length - self._length)
        return *(c * x + s * y, c * y - s * x, lowered), *product(quaternion([0.0, 0.0, -yaw]), self._load_q[3:])

    @property
    def _load_v(self) -> tuple[float, ...]:
        """Rates (7,) of position and attitude of the load at t = 0."""
        start = self._load_start
        return (*start.velocity, *attitude_rate(self._load_q[3:], start.angular_velocity))

    @property
    def rope_length(self) -> float:
        """Distance [m] of the load's centre of mass from the tip at t = 0."""
        (x, y, z), _ = self.tip(self._driven_start[0])
        return float(np.linalg.norm(np.array(self._load_q[:3]) - (x, y, z)))

    @property
    def payload_height(self) -> float:
        """Height of the payload above the base's origin at t = 0 [m]."""
        return self._load_q[2]

    def _requirements(self, winch: float | None, rate: float) -> MethodRequirements:
        """Return the scene's requirements on its method.

        Args:
            winch: kg, that the falls' length moves, None where nothing that they pull does.
            rate: rad/s or 1/s, the largest one of the support's own equations.
        """
        first = self._load()
        contact, loads = self._contact(first), [first, *(event.payload.load() for event in self.events)]
        mobility, start = (self.tip_mobility(), winch), self._falls_start
        frequency = max(
            stiffest_frequency(self.falls.falls(self._length, load), load, mobility, start, contact)
            for load in loads
            if isinstance(load, RigidLoad)
        )
        if contact is not None:  # slip decays at this rate where it is slower than the slip velocity
            frequency = max(frequency, self.gravity * contact.surface.friction / contact.surface.slip_velocity)
        return MethodRequirements(max(frequency, rate), 0.0, elastic=True, smooth=False, duration=self.duration)

    @property
    def _falls_start(self) -> FallsStart:
        """Where the ends of the falls are at t = 0."""
        position, yaw = self.tip(self._driven_start[0])
        return FallsStart(np.array(position), yaw, np.array(self._load_q))

    def _contact(self, load: RigidLoad) -> Any:
        return contact_of(self.contact, self.events, load, self._load_q)

    def falls_crane(
        self, support: Support, hoist: ForceHoist | MotionHoist | ReevedHoist | None, limits: Any, joints: Any
    ) -> FallsCrane:
        """Return the parameters of the crane.

        Args:
            support: with its drives.
            hoist: the winch; None: the falls keep their length.
            limits: of that length (low, high) [m], None without.
            joints: those whose motors add their inertia.

        Raises:
            SceneError: groups contradict each other.
        """
        falls = self.falls.falls(self._length, self._load())
        load, exchange = exchange_of(self.payload, self.events, ground_velocity(self.contact))
        assert isinstance(load, RigidLoad)
        check_equipment(self, self.payload, joints)
        check_ends(falls, self._falls_start)
        return FallsCrane(
            support,
            falls,
            load,
            hoist,
            self.gravity,
            self.payload_drag,
            base=self.base(),
            force=self.force(),
            stops=self._stops(limits),
            wind=self.airflow(),
            contact=self._contact(load),
            exchange=exchange,
        )

    def _stops(self, limits: tuple[float, float] | None) -> Stops:
        low, high = limits or (0.0, inf)
        least = MIN_LENGTH - min(self.falls.offsets or (0.0,))  # of the common length: no fall may lose its own
        return Stops(max(low, least), high, LOOKAHEAD_TIME if low <= least else 0.0)
