"""What hangs on one rope: further links, and a payload that is a point mass or a body.

One rope and a point mass have a closed form of their own below some supports; all else is the
suspended cable.
"""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from functools import cached_property
from math import cos, hypot, inf, sin
from typing import Any, ClassVar

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.models.cables.rope import ForceRope, LockedRope, MotionRope
from crane_sim.models.effects import PaperFriction, QuadraticFriction
from crane_sim.models.loads import PointLoad
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.stops import Stops
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.scenes.schema.actuated import has_strength
from crane_sim.scenes.schema.crane_file import CraneFile
from crane_sim.scenes.schema.exchange import LoadEvent, exchange_of
from crane_sim.scenes.schema.groups import Friction
from crane_sim.scenes.schema.integrator import needs_frequency
from crane_sim.scenes.schema.limits import TravelLimits, limits_of
from crane_sim.scenes.schema.motors import reflected_inertia
from crane_sim.scenes.schema.oscillation import swing_frequency
from crane_sim.scenes.schema.rigging import (
    ATTITUDE,
    Link,
    RiggingStart,
    chain_of,
    check_equipment,
    link_names,
    rigging_start,
    twist_frequency,
)
from crane_sim.scenes.schema.rods import joint_friction
from crane_sim.scenes.schema.winch import ReevedRope


class RiggedFile(CraneFile):
    """The groups of all cranes with one rope: what hangs below it."""

    swing_friction: Friction = None  # friction of the swing joints, of the rope at the tip
    links: tuple[Link, ...] = ()  # further links below the rope, from the top
    events: tuple[LoadEvent, ...] = ()  # exchanges of the payload at given times

    @property
    def _rope(self) -> Any:
        return getattr(self, "rope")  # noqa: B009  (each kind of rope declares its own)

    @property
    @abstractmethod
    def _rope_start(self) -> float:
        """Length of the rope at t = 0 [m]."""

    @cached_property
    @abstractmethod
    def _direction(self) -> tuple[Any, Any]:
        """The rope's unit vector and its rate, each (3,), in the axes of the base at t = 0."""

    @cached_property
    @abstractmethod
    def _stops(self) -> Stops | None:
        """The conditions that end a run, None where nothing ends or switches it."""

    @property
    def hung_mass(self) -> float:
        """Mass [kg] of all that hangs below the tip at t = 0."""
        return self.payload.mass + sum(link.mass for link in self.links)

    @property
    def beyond_one_rope(self) -> list[str]:
        """Keys of the file that the equations of one rope and a point mass do not support."""
        rope = {
            f"rope.{key}": getattr(self._rope, key, None)
            for key in ("reeving", "friction", "torsion")
        }
        body = {"payload.inertia": self.payload.inertia, "links": self.links, "events": self.events}
        return [key for key, value in (body | {"backlash": self.play} | rope).items() if value]

    @cached_property
    def _rigging(self) -> tuple[Any, Any]:
        """(q, v) of further links and attitude."""
        start = self._start.rigging or RiggingStart()
        if self._rope.torsion is not None:
            start = start.nearest_to(self.tip().yaw)
        return rigging_start(
            start, len(self.links), self.payload.inertia is not None, self._direction
        )

    @property
    def rope_length(self) -> float:
        """Length of rope and further links at t = 0 [m]."""
        return self._rope_start + sum(link.length for link in self.links)

    @property
    def payload_height(self) -> float:
        """Height of the payload's attachment above the base's origin at t = 0 [m]."""
        further = [self._rigging[0][3 * k + 2] * link.length for k, link in enumerate(self.links)]
        return self.tip().position[2] + self._rope_start * self._direction[0][2] + sum(further)

    @property
    def _payloads(self) -> list[Any]:
        return [self.payload, *(event.payload for event in self.events)]

    @property
    def lowest_pressure(self) -> float:
        """Height [m] above the base's origin below which no wind presses on the payload."""
        if self.base_motion is not None or self.modes or self._tip_rises:
            return -inf
        arms = [hypot(*(payload.attachment or (0.0,))) for payload in self._payloads]
        centres = [
            hypot(*(p.windage.centre or (0.0,))) if p.windage else 0.0 for p in self._payloads
        ]
        below = self._longest_rope + sum(link.length for link in self.links)
        return self.tip().position[2] - below - max(arms) - max(centres)

    @property
    def _tip_rises(self) -> bool:
        return bool(self.small_motions.tip_mobility[2, 2] != 0.0)

    @property
    @abstractmethod
    def _longest_rope(self) -> float:
        """Longest rope of the run [m]."""

    @property
    def is_smooth(self) -> bool:
        """Whether nothing switches, and no loss |v| v has a kink in its slope at each reversal."""
        rubs = isinstance(self.swing_friction, QuadraticFriction | PaperFriction)
        return not (self._stops or rubs or self.payload_drag is not None)

    def _hanging_rate(self, length: float) -> float:
        """Return a bound [rad/s] of the frequencies of all payloads that hang on a rope [m].

        That of their swings only for methods that depend on it.
        """
        mobility, inertias = (
            self.small_motions.tip_mobility,
            [p.inertia for p in self._payloads if p.inertia],
        )
        twist = twist_frequency(self._rope.torsion, inertias, float(mobility[3, 3]))
        if not needs_frequency(self.integrator):
            return twist
        lengths, masses = (
            [length, *(link.length for link in self.links)],
            [link.mass for link in self.links],
        )
        upper = float(np.linalg.eigvalsh(mobility[:3, :3])[-1])
        swings = [
            swing_frequency(lengths, masses, upper, payload, self.gravity)
            for payload in self._payloads
        ]
        return max(twist, *swings)

    def _suspended_crane(self, hoist: Any, joints: Sequence[str]) -> SuspendedCrane:
        """Return the parameters of the crane; SceneError: groups contradict each other.

        Args:
            hoist: drive of the rope; None: its length stays.
            joints: those whose motors add their inertia.
        """
        if self._rope.torsion is not None and self.payload.inertia is None:
            raise SceneError(
                "rope.torsion: belongs to a payload that is a body; give payload.inertia, or leave "
                "it out"
            )
        check_equipment(self, self.payload, joints)
        load, exchange = exchange_of(self.payload, self.events)
        return SuspendedCrane(
            self.support(),
            chain_of(self._rope_start, self.links, load.mass),
            load,
            hoist,
            self.gravity,
            self.payload_drag,
            base=self.base(),
            force=self.force(),
            stops=self._stops,
            wind=self.airflow(),
            exchange=exchange,
            torsion=self._rope.torsion,
            swing_friction=self.swing_friction,
        )

    def _crane_with_one_rope(self, structure: Any, rope: Any) -> Crane:
        """Return the parameters of the crane with one rope and a point mass."""
        load = self.payload.load()
        assert isinstance(load, PointLoad)
        return Crane(
            structure,
            rope,
            load,
            self.gravity,
            self.swing_friction,
            self.payload_drag,
            base=self.base(),
            force=self.force(),
            stops=self._stops,
            wind=self.airflow(),
        )


class RopeFile(RiggedFile):
    """A payload on links and a rope, moved by a winch; the rope has a length and two angles.

    Below a knuckle boom one rope and a point mass have a closed form of their own. `links`,
    `payload.inertia`, `events`, `backlash`, `rope.reeving`, `rope.friction` and `rope.torsion`
    choose the suspended cable of the other cranes, beside which `springs.rope` and `friction.rope`
    are refused.
    """

    winch: ClassVar = ("rope",)
    rope: ReevedRope = ReevedRope()  # the winch

    @property
    def winch_units(self) -> dict[str, str]:
        """Unit of the winch's command, empty where the rope is locked."""
        return {"rope": self.rope.effort_unit} if self.rope.effort_unit else {}

    @property
    def hanging_joints(self) -> dict[str, str]:
        """Units of the joints: rope, two angles of swing, further links, the payload's attitude."""
        body = ATTITUDE if self.payload.inertia is not None else ()
        further = dict.fromkeys((*link_names(len(self.links)), *body), "1")
        return {"rope": "m", "swing_tangential": "rad", "swing_radial": "rad"} | further

    @property
    def _own(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of the rope at t = 0: its length and angles."""
        start, n = self._start, len(self.joints)
        return start.q[n:], start.v[n:]

    @property
    def hanging_start(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """(q, v) of rope, further links and attitude at t = 0."""
        return (*self._own[0], *self._rigging[0]), (*self._own[1], *self._rigging[1])

    @property
    def _rope_start(self) -> float:
        return self._own[0][0]

    @cached_property
    def _direction(self) -> tuple[Any, Any]:
        (_, *angles), (_, *rates) = self._own
        yaws = (i for i in self._structure.mechanism().yaw if i < len(self.joints))
        yaw_rate = sum(self.own_start[1][i] for i in yaws)
        return rope_direction(self.tip().yaw, yaw_rate, angles, rates)

    @property
    def hanging_limits(self) -> tuple[TravelLimits, ...]:
        """Travel limits of the rope."""
        return limits_of(("rope", "rope.limits", self.rope.limits))

    @property
    def _longest_rope(self) -> float:
        free = self.rope.limits[1] if self.rope.limits is not None else inf
        return self._rope_start if self.rope.drive == "locked" else free

    def resting_joints(self, target: tuple[float, ...]) -> Mapping[str, float]:
        """Return the modes' angles [rad], by joint, at rest at a target (nu,); none if rigid.

        Raises:
            SceneError: it bends too far.
        """
        if not self.modes:
            return {}
        q, groups = self.rest_at(target)[: len(self.joints)], self.left_to_rest()
        return dict(
            zip(
                self.modes,
                groups.deflections(self._structure, q, self.gravity, self.hung_mass),
                strict=True,
            )
        )

    def stiffest(self) -> float:
        """Return the largest frequency or decay rate [rad/s] of support, rope and payloads."""
        lengths = [self._rope_start]
        if self.target is not None and self.winch_units:
            lengths.append(self.target[-1])
        return max(self.support_rate(), self._hanging_rate(min(lengths)))

    @cached_property
    def _stops(self) -> Stops | None:
        rubs = has_strength(getattr(self, "friction"), getattr(self, "lugre"))  # noqa: B009
        if not self.beyond_one_rope and isinstance(self._structure, Knuckle):
            return self.rope.stops(bool(self.limits or rubs)) or (
                Stops() if self.is_in_kinked_wind else None
            )
        switches = self.events or self.play or self.rope.torsion or rubs or self.is_in_kinked_wind
        return self.rope.stops(bool(self.limits)) or (Stops() if switches else None)

    def model(self) -> Crane | SuspendedCrane:
        """Return the parameters of the crane.

        Raises:
            SceneError: groups contradict each other.
        """
        (length, *_), (rate, *_) = self._own
        self.rope.check(length, rate, len(self.joints))
        structure = self._structure
        if isinstance(structure, Knuckle) and not self.beyond_one_rope:
            return self._knuckle_crane(structure)
        self._refuse_keys_of_one_rope()
        self.rope.check_surroundings(self)
        joints = (*self.support_joints, *(("rope",) if self.rope.takes_motor else ()))
        return self._suspended_crane(self.rope.drive_of(self), joints)

    def _knuckle_crane(self, structure: Knuckle) -> Crane:
        """Return the closed form of a knuckle-boom crane with one rope and a point mass."""
        drive, spring = self.rope.drive, getattr(self, "springs").rope  # noqa: B009
        if spring is not None and drive != "force":
            raise SceneError(
                f"springs.rope: only a force drive can have one, this drive is {drive!r}"
            )
        if reflected_inertia(self, "rope") > 0.0:
            raise SceneError(
                "actuators.rope.motor.inertia: the winch of rope.drive: force has no inertia; must "
                "be 0"
            )
        motors = tuple(reflected_inertia(self, joint.name) for joint in self.joints)
        friction = joint_friction(getattr(self, "friction"), getattr(self, "lugre"), drive)  # noqa: B009
        rope = LockedRope(self._rope_start) if drive == "locked" else ForceRope(spring)
        if drive == "rate":
            rope = MotionRope(self.rope.time_constant)
        geared = structure._replace(motors=motors if any(motors) else None)
        return self._crane_with_one_rope(geared, rope)._replace(friction=friction)

    def _refuse_keys_of_one_rope(self) -> None:
        """Raise SceneError for keys that only the model of one rope and a point mass takes."""
        springs = getattr(self, "springs", None)
        groups = {"springs.rope": springs.rope if springs is not None else None}
        groups |= {f"{key}.rope": getattr(self, key).get("rope") for key in ("friction", "lugre")}
        for key in (key for key, value in groups.items() if value is not None):
            raise SceneError(
                f"{key}: belongs to one rope and a point mass, here is {self.beyond_one_rope[0]}; "
                "leave out one of both"
                + ("; the winch has rope.friction" if key == "friction.rope" else "")
            )


def rope_direction(yaw: float, yaw_rate: float, angles: Any, rates: Any) -> tuple[Any, Any]:
    """Return the rope's unit vector and its rate, each (3,), in the axes of the base.

    Args:
        yaw, yaw_rate: of the support's frame [rad], [rad/s].
        angles, rates: of the swing (θ1, θ2) in that frame.
    """
    (s1, c1, s2, c2), (w1, w2) = (
        (sin(angles[0]), cos(angles[0]), sin(angles[1]), cos(angles[1])),
        rates,
    )
    n, u = (
        (s2, c2 * s1, -c2 * c1),
        (c2 * w2, c2 * c1 * w1 - s2 * s1 * w2, c2 * s1 * w1 + s2 * c1 * w2),
    )
    u = (u[0] - yaw_rate * n[1], u[1] + yaw_rate * n[0], u[2])
    s, c = sin(yaw), cos(yaw)
    return (c * n[0] - s * n[1], s * n[0] + c * n[1], n[2]), (
        c * u[0] - s * u[1],
        s * u[0] + c * u[1],
        u[2],
    )
