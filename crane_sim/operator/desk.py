"""The operator's desk: interlocks between levers and drives, and soft limits; no ROS, no devices.

- Dead man's switch: while it is not held, every speed is zero.
- Interlock of zero position: after the start, a stop or a loss of the device, levers count again
  only when all of them have been at rest.
- Emergency stop: latched; a release counts only while the dead man's switch is open and all levers
  rest.
- Brakes: on from the emergency stop until the first lever that counts after its release. A drive
  that is weaker than its brake would be dragged along by a load that still swings.
- Loss: without a heartbeat for longer than the time-out, every speed is zero.
- Soft limits: see `hardware.soft_limits`.
"""

from collections.abc import Sequence
from enum import StrEnum
from math import inf
from typing import NamedTuple

from crane_sim.hardware.reference_profiles import Bounds
from crane_sim.hardware.soft_limits import ReferenceMotion, follow, permitted_speed
from crane_sim.operator.inputs import Demand

REACTION_TIME = 0.1
"""Seconds for which a speed may hold until the next one counts: transport, and late steps on a busy
machine."""
DRAG_THRESHOLD = 0.25
"""Fraction of a joint's largest speed: a velocity that differs by more from a drive's reference is
due to a load."""


class Mode(StrEnum):
    """Whether the desk permits motion, and if not, why."""

    STOPPED = "emergency stop"
    DEVICE_LOST = "device lost"
    INTERLOCKED = "levers to zero"
    OPEN = "dead man's switch open"
    MOVING = "in operation"


class DrivenJoint(NamedTuple):
    """An actuated joint that an operator drives."""

    name: str
    unit: str  # m or rad
    bounds: Bounds  # of its reference, whose speed is that of the lever's end
    low: float = -inf  # m or rad, ends of the travel that soft limits keep
    high: float = inf
    lag: float = 0.0  # s, with which the joint follows its reference


class Desk:
    """The interlocks and their state.

    Attributes:
        mode: since the last demand.
        stopped: the emergency stop is latched.
        braked: the brakes are to act.
        assisted: assistance is switched on.
    """

    def __init__(
        self, joints: Sequence[DrivenJoint], timeout: float, assisted: bool = False
    ) -> None:
        """Begin interlocked; `timeout`: s without a heartbeat until the device counts as lost."""
        self._joints, self._timeout = tuple(joints), timeout
        self.mode, self.stopped, self.assisted = Mode.INTERLOCKED, False, assisted
        self.braked = False
        self._interlocked, self._last_heartbeat, self._switched = True, -inf, False

    def heartbeat(self, now: float) -> None:
        """Note a heartbeat of the device at `now` [s]."""
        self._last_heartbeat = now

    def lose(self) -> None:
        """Note that the device is gone."""
        self._last_heartbeat = -inf

    def take(self, demand: Demand, now: float) -> tuple[float, ...]:
        """Return speeds (nu,), exactly the levers' fractions of the largest; 0 if interlocked."""
        self._switch_assistance(demand.assistance)
        at_rest = not any(demand.axes)
        self.stopped = demand.stop or (
            self.stopped and not (demand.release and at_rest and not demand.enabled)
        )
        lost = now - self._last_heartbeat > self._timeout
        self._interlocked = self.stopped or lost or (self._interlocked and not at_rest)
        self.mode = self._mode(lost, demand.enabled)
        self.braked = self.stopped or (self.braked and (at_rest or self.mode != Mode.MOVING))
        if self.mode != Mode.MOVING:
            return (0.0,) * len(self._joints)
        return tuple(
            axis * joint.bounds.speed for axis, joint in zip(demand.axes, self._joints, strict=True)
        )

    def _switch_assistance(self, pressed: bool) -> None:
        self.assisted ^= pressed and not self._switched
        self._switched = pressed

    def _mode(self, lost: bool, enabled: bool) -> Mode:
        if self.stopped:
            return Mode.STOPPED
        if lost:
            return Mode.DEVICE_LOST
        if self._interlocked:
            return Mode.INTERLOCKED
        return Mode.MOVING if enabled else Mode.OPEN


class SoftLimits:
    """Speeds from which the crane can stop within its travel, with the references for its drives.

    Attributes:
        limited: names of the joints whose last speed was reduced.
    """

    def __init__(self, joints: Sequence[DrivenJoint], period: float) -> None:
        """Begin at rest; `period` [s] of commands."""
        self._joints, self._period, self.limited = tuple(joints), period, list[str]()
        self.reset()

    def reset(self) -> None:
        """Let the references rest: brakes have stopped the crane."""
        self._references = [ReferenceMotion(0.0, 0.0, 0.0)] * len(self._joints)

    def take(
        self, speeds: Sequence[float], q: Sequence[float], v: Sequence[float]
    ) -> tuple[float, ...]:
        """Return the permitted speeds (nu,) at the joints' positions and velocities (nu,)."""
        allowed = tuple(
            self._permitted_speed(joint, reference, speed, *state)
            for joint, reference, speed, *state in zip(
                self._joints, self._references, speeds, q, v, strict=True
            )
        )
        joints = zip(self._joints, allowed, speeds, strict=True)
        self.limited = [joint.name for joint, least, speed in joints if least != speed]
        self._references = [
            follow(reference, speed, joint.bounds, self._period)
            for joint, reference, speed in zip(self._joints, self._references, allowed, strict=True)
        ]
        return allowed

    def dragged(self, v: Sequence[float]) -> list[str]:
        """Return the joints whose velocities (nu,) are far from what their drives follow."""
        joints = zip(self._joints, self._references, v, strict=True)
        return [
            joint.name
            for joint, reference, now in joints
            if abs(now - reference.velocity) > _drag_tolerance(joint)
        ]

    def _permitted_speed(
        self, joint: DrivenJoint, reference: ReferenceMotion, speed: float, q: float, v: float
    ) -> float:
        """Return a joint's permitted speed; the faster of its velocity and reference counts."""
        speed = min(max(speed, -joint.bounds.speed), joint.bounds.speed)
        if speed == 0.0 or (joint.low == -inf and joint.high == inf):
            return speed
        fastest = max(v, reference.velocity) if speed > 0.0 else min(v, reference.velocity)
        motion = ReferenceMotion(q + joint.lag * fastest, fastest, reference.acceleration)
        return permitted_speed(motion, speed, joint.bounds, joint.low, joint.high, REACTION_TIME)


def _drag_tolerance(joint: DrivenJoint) -> float:
    """Return a drive's deviation of velocity without a load: of its lag on a ramp, and its loop."""
    return DRAG_THRESHOLD * joint.bounds.speed + joint.lag * joint.bounds.acceleration
