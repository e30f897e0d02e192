"""What hangs on elastic falls, below any support: a rigid load, with or without a winch."""

from functools import cached_property
from math import cos, inf, sin
from typing import Any, ClassVar

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.files.types import Angle, Positive, Real
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.loads import RigidLoad
from crane_sim.models.stops import LOOKAHEAD_TIME, MIN_LENGTH, Stops
from crane_sim.scenes.schema.backlash import drives_of
from crane_sim.scenes.schema.contact import ContactGroup
from crane_sim.scenes.schema.crane_file import CraneFile
from crane_sim.scenes.schema.exchange import exchange_of
from crane_sim.scenes.schema.falls import FallsGroup, FallsStart, check_ends, stiffest_frequency
from crane_sim.scenes.schema.falls_winch import Hoist, Ropes
from crane_sim.scenes.schema.groups import Group
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.load_at_rest import load_at_rest, product, quaternion
from crane_sim.scenes.schema.rigging import (
    ATTITUDE,
    Quaternion,
    Vector,
    attitude_of,
    attitude_rate,
    check_equipment,
)
from crane_sim.scenes.schema.spreader import SpreaderEvent, contact_of, ground_velocity
from crane_sim.scenes.schema.suspension import TipStart

PLACE = ("payload_x", "payload_y", "payload_z")
"""The joints of a load's place: the coordinates of its centre of mass."""


class LoadStart(Group):
    """The load at t = 0; one whose position is left out hangs at rest below the tip."""

    skew: Angle | None = None  # rad, angle about the vertical, from the support's axes, at which
    # the load is held until t = 0
    position: Vector | None = None  # m, of the load's centre of mass, with `orientation`
    orientation: Quaternion | None = None  # -, unit quaternion (w, x, y, z) from the load's axes to
    # the base's
    velocity: Vector = (0.0, 0.0, 0.0)  # m/s, of the load's centre of mass
    angular_velocity: Vector = (0.0, 0.0, 0.0)  # rad/s, of the load, in its own axes


class PortalStart(LoadStart):
    """The state at t = 0; a load whose position is left out hangs at rest below the trolley."""

    trolley: Real = 0.0  # m, position of the trolley
    bridge: Real = 0.0  # m, position of bridge or portal
    length: Positive  # m, unstretched length of the falls
    v: tuple[Real, Real, Real] = (0.0, 0.0, 0.0)  # m/s, of trolley, bridge and length

    @property
    def q(self) -> tuple[float, float, float]:
        """Positions [m] of trolley, bridge and length."""
        return self.trolley, self.bridge, self.length


class PointLoadStart(TipStart, LoadStart):
    """Suspension point and load at t = 0; without a position the load hangs at rest."""

    length: Positive  # m, unstretched length of the falls, which stays


class FallsFile(CraneFile):
    """A load on elastic falls of fixed length."""

    falls: FallsGroup  # the ropes
    contact: ContactGroup | None = None  # what the load can be set down on; left out: nothing is
    # below it
    events: tuple[SpreaderEvent, ...] = ()  # exchanges of the payload at given times

    is_elastic: ClassVar = True

    @property
    def is_smooth(self) -> bool:
        """Whether nothing switches: falls go slack."""
        return False

    @property
    def length_start(self) -> tuple[float, float]:
        """Unstretched length [m] of the falls at t = 0, and its rate [m/s]."""
        return self._start.length, 0.0

    @property
    def hanging_joints(self) -> dict[str, str]:
        """Units of the joints: of the falls' length with a winch, the load's position, attitude."""
        load = dict.fromkeys(PLACE, "m") | dict.fromkeys(ATTITUDE, "1")
        return dict.fromkeys(self.winch, "m") | load

    @property
    def hanging_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of the falls' length and the load at t = 0."""
        (length, rate), start, n = self.length_start, self._start, len(self.winch)
        turning = attitude_rate(self._load_q[3:], start.angular_velocity)
        return (length,) * n + self._load_q, ((rate,) * n + (*start.velocity, *turning))

    @property
    def hung_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""
        return self.payload.mass

    @cached_property
    def _load(self) -> RigidLoad:
        load = self.payload.load()
        if not isinstance(load, RigidLoad):
            raise SceneError("payload.inertia: is missing; a load on falls is a rigid body")
        return load

    @cached_property
    def _load_q(self) -> tuple[float, ...]:
        """Position [m] and attitude (7,) of the load at t = 0, computed once where at rest."""
        start = self._start
        if start.position is not None:
            if start.skew is not None:
                raise SceneError(
                    "initial.skew: not with initial.position; give initial.orientation instead"
                )
            return (*start.position, *attitude_of(start.orientation))
        if start.orientation is not None:
            raise SceneError(
                "initial.orientation: needs initial.position; initial.skew turns a load at rest"
            )
        return self._rest_pose(self.own_start[0], self.length_start[0], start.skew)

    def _rest_pose(self, q: Any, length: float, skew: float | None) -> tuple[float, ...]:
        """Return the load's position [m] and attitude (7,) at rest on falls of this length.

        The support's joints are at q.
        """
        (x, y, z), yaw = self.tip(q)
        near = self._given_posture(length) if self._start.position is not None else None
        falls = self.falls.falls(length, self._load)
        place, (w, a, b, c) = load_at_rest(falls, self._load, self.gravity, skew, near)
        (dx, dy, dz), (s, k) = place.tolist(), (sin(yaw), cos(yaw))
        half_s, half_c = sin(0.5 * yaw), cos(0.5 * yaw)
        turned = (
            half_c * w - half_s * c,
            half_c * a - half_s * b,
            half_c * b + half_s * a,
            half_c * c + half_s * w,
        )
        return x + k * dx - s * dy, y + s * dx + k * dy, z + dz, *map(float, turned)

    def _given_posture(self, length: float) -> Any:
        """Return the posture (7,) at t = 0 from the tip [m], lowered to falls of this length."""
        tip, yaw = self.tip()
        s, c = sin(yaw), cos(yaw)
        x, y, z = np.array(self._load_q[:3]) - tip
        lowered = z - (length - self.length_start[0])
        return *(c * x + s * y, c * y - s * x, lowered), *product(
            quaternion([0.0, 0.0, -yaw]), self._load_q[3:]
        )

    @property
    def rope_length(self) -> float:
        """Distance [m] of the load's centre of mass from the tip at t = 0."""
        return float(np.linalg.norm(np.array(self._load_q[:3]) - self.tip().position))

    @property
    def payload_height(self) -> float:
        """Height of the payload above the base's origin at t = 0 [m]."""
        return self._load_q[2]

    def rest_positions(self, target: tuple[float, ...]) -> tuple[float, ...]:
        """Return the joint positions (nq,) of the crane at rest at the target (nu,)."""
        q, length = self.rest_at(target), self.length_start[0]
        own, file = q[: len(self.joints)], self.left_to_rest()
        bent = file.deflections(self._structure, own, self.gravity, self.hung_mass)
        drives = [own[i] for i, _, _ in drives_of(self.play, self.joints)]
        pose = file._rest_pose(own, q[-1] if self.winch_units else length, None)
        return (*q, *pose, *bent, *drives)

    @property
    def _ends(self) -> FallsStart:
        """Where the ends of the falls are at t = 0."""
        position, yaw = self.tip()
        return FallsStart(np.array(position), yaw, np.array(self._load_q))

    def _contact(self) -> Any:
        return contact_of(self.contact, self.events, self._load, self._load_q)

    @property
    def wound_mass(self) -> float | None:
        """Mass [kg] that the falls' length moves, None where nothing that they pull does."""
        return None

    def stiffest(self) -> float:
        """Return the largest frequency or decay rate [rad/s] of load, support and winch."""
        contact, loads = (
            self._contact(),
            [self._load, *(event.payload.load() for event in self.events)],
        )
        mobility, length = (self.small_motions.tip_mobility, self.wound_mass), self.length_start[0]
        frequency = max(
            stiffest_frequency(self.falls.falls(length, load), load, mobility, self._ends, contact)
            for load in loads
            if isinstance(load, RigidLoad)
        )
        if contact is not None:
            # slip decays at this rate where it is slower than the slip velocity
            frequency = max(
                frequency, self.gravity * contact.surface.friction / contact.surface.slip_velocity
            )
        return max(frequency, self.support_rate())

    def model(self) -> FallsCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        return self._falls_crane(None, None)

    def _falls_crane(self, hoist: Any, limits: tuple[float, float] | None) -> FallsCrane:
        """Return the crane's parameters; hoist None: no winch; limits (low, high) [m] of length."""
        falls = self.falls.falls(self.length_start[0], self._load)
        load, exchange = exchange_of(self.payload, self.events, ground_velocity(self.contact))
        assert isinstance(load, RigidLoad)
        check_equipment(self, self.payload, self.support_joints)
        check_ends(falls, self._ends)
        return FallsCrane(
            self.support(),
            falls,
            load,
            hoist,
            self.gravity,
            self.payload_drag,
            base=self.base(),
            force=self.force(),
            stops=self._stops(limits),
            wind=self.airflow(),
            contact=self._contact(),
            exchange=exchange,
        )

    def _stops(self, limits: tuple[float, float] | None) -> Stops:
        low, high = limits or (0.0, inf)
        # of the common length: no fall may lose its own
        least = MIN_LENGTH - min(self.falls.offsets or (0.0,))
        return Stops(max(low, least), high, LOOKAHEAD_TIME if low <= least else 0.0)


class HoistedFile(FallsFile):
    """A load on elastic falls, wound up by one winch."""

    winch: ClassVar = ("hoist",)
    hoist: Hoist = Hoist()  # the winch

    @property
    def winch_units(self) -> dict[str, str]:
        """Unit of the winch's command."""
        return {"hoist": self.hoist.effort_unit}

    @property
    def length_start(self) -> tuple[float, float]:
        """Unstretched length [m] of the falls at t = 0, and its rate [m/s]."""
        return self._start.q[-1], self._start.v[-1]

    @property
    def hanging_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the winch."""
        return limits_of(("hoist", "hoist.limits", self.hoist.limits))

    @property
    def _ropes(self) -> Ropes:
        return Ropes(len(self.falls.top), self.falls.parts)

    @property
    def wound_mass(self) -> float | None:
        """Mass [kg] that the falls' length moves, None where it is imposed."""
        return self.hoist.inertia(self._ropes, self.length_start[0])[0]

    def stiffest(self) -> float:
        """Return the largest frequency or decay rate [rad/s] of load, support and winch."""
        return max(super().stiffest(), self.hoist.inertia(self._ropes, self.length_start[0])[1])

    def model(self) -> FallsCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        springs = getattr(self, "springs", None)
        if springs is not None and springs.rope is not None:
            raise SceneError(
                "springs.rope: belongs to one rope and a point mass, here is falls; leave out one "
                "of both"
            )
        return self._falls_crane(
            self.hoist.model(self._ropes, self.length_start[0]), self.hoist.range
        )
