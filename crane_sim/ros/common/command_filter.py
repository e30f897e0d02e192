"""Validation of commands before they reach the plant, counts of refusals, and bounds on efforts.

The bounds are far beyond what any law needs, and no burden to any integrator.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from enum import StrEnum
from math import isfinite, isnan
from operator import le
from typing import NamedTuple, TypeVar

import numpy as np

from crane_sim.ros.common.command_stamps import StampRange
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import derive

# rad/s² or m/s² of a joint with its load; the bound itself, in units other than N m and N
_ACCELERATION = 1e5
_LOAD_FACTOR = 1e3  # times the effort that holds a joint against gravity
_HALF_DIFFERENCE = 1e-3  # rad or m, of the central difference of the potential energy
_LINE_LENGTH = 200  # characters of a refusal's line

Decoded = TypeVar("Decoded")


class RequiredEfforts(NamedTuple):
    """What actuated joints need at the start of a scene."""

    inertia: np.ndarray  # (nu,) of each joint with its load
    gravity: np.ndarray  # (nu,) the effort that holds it, signed


def largest_efforts(scene: Scene, bound: float = 0.0) -> tuple[float, ...]:
    """Return bounds (nu,) on the numbers of commands, in the units of the scene's commands.

    Args:
        scene: its initial posture determines inertia and gravity of a joint.
        bound: the same bound for all joints instead; 0 for none.
    """
    if bound:
        return (bound,) * len(scene.actuated)
    if not scene.actuated:
        return ()
    inertia, gravity = required_efforts(scene)
    bounds = np.where(
        np.isin(scene.command_units, ("N m", "N")),
        _ACCELERATION * inertia + _LOAD_FACTOR * np.abs(gravity),
        _ACCELERATION,
    )
    return tuple(bounds.tolist())


def required_efforts(scene: Scene) -> RequiredEfforts:
    """Return what unit accelerations and gravity require in the initial posture.

    They are computed from differences of energies.
    """
    joints = [scene.joint_names.index(joint) for joint in scene.actuated]
    n = len(joints)
    q, v = np.tile(scene.initial_q, (4, n, 1)), np.zeros((4, n, len(scene.joint_names)))
    indices = range(n)
    q[0, indices, joints] += _HALF_DIFFERENCE
    q[1, indices, joints] -= _HALF_DIFFERENCE
    v[2, indices, joints] = 1.0
    derived = derive(
        scene, np.zeros(4 * n), q.reshape(4 * n, -1), v.reshape(4 * n, -1), np.zeros((4 * n, n))
    )
    up, down, _, _ = derived.potential_relative.reshape(4, n)
    _, _, moving, at_rest = derived.kinetic_relative.reshape(4, n)
    return RequiredEfforts(2.0 * np.abs(moving - at_rest), (up - down) / (2.0 * _HALF_DIFFERENCE))


class Refusal(StrEnum):
    """Reasons for which a command is refused."""

    NAMES = "names"
    LENGTH = "length"
    NOT_FINITE = "not finite"
    HUGE = "huge"
    UNSTAMPED = "unstamped"
    FUTURE = "future"
    UNREADABLE = "unreadable"
    COMMANDER = "commander"  # another publisher owns the crane
    LATE = "late"  # older than the last accepted command
    STALE = "stale"
    DUPLICATE = "duplicate"


_REJECTED = (
    Refusal.NAMES,
    Refusal.LENGTH,
    Refusal.NOT_FINITE,
    Refusal.HUGE,
    Refusal.UNSTAMPED,
    Refusal.FUTURE,
    Refusal.UNREADABLE,
    Refusal.COMMANDER,
)  # mistakes of the publisher
_BY_STAMP = (Refusal.UNSTAMPED, Refusal.FUTURE, Refusal.LATE, Refusal.STALE)
_STAMPS_HELP = (
    "a command echoes the stamp of its state; --command-stamps ros takes those of ROS time, any all"
)
_TOO_OLD = (Refusal.LATE, Refusal.STALE)


class CommandValidator:
    """Validator of the commands of one run by stamps [ns], joint names and efforts; without ROS.

    Attributes:
        received: commands that arrived, accepted or refused.
        refused: number of refusals by reason.
        last_refusal: one line on the latest refusal, empty while there is none.
    """

    def __init__(
        self, actuated: Sequence[str], largest: Sequence[float], joints: Sequence[str] = ()
    ) -> None:
        """Accept commands for all joints `actuated`; the caller gets their efforts in this order.

        Efforts beyond `largest` (nu,) [N m or N] are refused: no state would stay finite. Commands
        may also name other ones of the crane's `joints`, without an effort.
        """
        self._largest = tuple(largest)
        self.received = 0
        self.refused: Counter[Refusal] = Counter()
        self.last_refusal = ""
        self._actuated, self._passive = list(actuated), set(joints) - set(actuated)
        self._newest: dict[str, int] = {}  # stamps of the last accepted commands, by their clocks

    def validate(
        self,
        stamp: int,
        names: Sequence[str],
        efforts: Sequence[float],
        possible: StampRange | None,
    ) -> tuple[float, ...] | None:
        """Return the efforts (nu,) of a command in joint order, or None when it is refused.

        Args:
            stamp: the command's stamp, ns.
            names: its joints, in any order.
            efforts: N m or N, in the order of `names`.
            possible: the stamps that it may have, None: any.
        """
        self.received += 1
        if possible is None:
            return self.match_joints(names, efforts)
        if reason := self._check_stamp(stamp, possible):
            line = (
                f"command with stamp {stamp} ns, possible: {possible.oldest} .. {possible.newest} "
                "ns"
            )
            return self.refuse(reason, line)
        ordered = self.match_joints(names, efforts)
        if ordered is not None:
            self._newest[possible.epoch] = stamp
        return ordered

    def match_joints(
        self, names: Sequence[str], efforts: Sequence[float]
    ) -> tuple[float, ...] | None:
        """Return the efforts (nu,) of a command with any stamp in joint order; None if refused."""
        return (
            self._check_efforts(efforts)
            if names == self._actuated
            else self._sort_by_joint(names, efforts)
        )

    def validate_array(self, efforts: Sequence[float]) -> tuple[float, ...] | None:
        """Return the efforts (nu,) of a command without names and stamp; None if refused."""
        self.received += 1
        return self._check_efforts(efforts)

    def summary(self) -> dict[str, int]:
        """Return the counters of the run's summary."""
        return {
            "received": self.received,
            "rejected": sum(self.refused[reason] for reason in _REJECTED),
            "late": sum(self.refused[reason] for reason in _TOO_OLD),
            "duplicate": self.refused[Refusal.DUPLICATE],
        }

    def describe_refusals(self) -> str:
        """Return why every command so far was refused and what helps; empty if one was accepted."""
        refused = sum(self.refused.values())
        if not refused or refused < self.received:
            return ""
        stamps = sum(self.refused[reason] for reason in _BY_STAMP)
        line = f"all {refused} commands so far were refused, the last one: {self.last_refusal}"
        return f"{line}; {_STAMPS_HELP}" if 2 * stamps > refused else line

    def decode(self, decode: Callable[[bytes], Decoded], data: bytes) -> Decoded | None:
        """Return a decoded message, or None when it is refused as unreadable."""
        try:
            return decode(data)
        except ValueError as error:
            self.reject(Refusal.UNREADABLE, f"command {error}")
            return None

    def reject(self, reason: Refusal, line: str, number: int = 1) -> None:
        """Count a command, or several, refused unread."""
        self.received += number
        self.refuse(reason, line, number)

    def refuse(self, reason: Refusal, line: str, number: int = 1) -> None:
        """Count refusals and keep the line on them."""
        self.refused[reason] += number
        self.last_refusal = f"{line[:_LINE_LENGTH]} ({reason})"

    def _check_stamp(self, stamp: int, possible: StampRange) -> Refusal | None:
        newest = self._newest.get(possible.epoch, 0)
        if not stamp:
            return Refusal.UNSTAMPED
        if stamp > possible.newest:
            return Refusal.FUTURE
        if stamp == newest and not possible.repeats:
            return Refusal.DUPLICATE
        if stamp < newest:
            return Refusal.LATE
        return Refusal.STALE if stamp < possible.oldest else None

    def _sort_by_joint(
        self, names: Sequence[str], efforts: Sequence[float]
    ) -> tuple[float, ...] | None:
        commanded = [name for name in names if name not in self._passive]
        if sorted(commanded) != sorted(self._actuated) or len(set(names)) != len(names):
            line = f"command for joints {list(names)}, the actuated ones are {self._actuated}"
            return self.refuse(Refusal.NAMES, line)
        if len(efforts) != len(names) and len(efforts) != len(commanded):
            return self._check_efforts(efforts)
        by_name = dict(
            zip(names if len(efforts) == len(names) else commanded, efforts, strict=True)
        )
        if driven := [
            name
            for name in by_name.keys() & self._passive
            if by_name[name] and not isnan(by_name[name])
        ]:
            line = (
                f"command with effort {by_name[driven[0]]} on {driven[0]}, the actuated joints are "
                f"{self._actuated}"
            )
            return self.refuse(Refusal.NAMES, line)
        return self._check_efforts([by_name[name] for name in self._actuated])

    def _check_efforts(self, efforts: Sequence[float]) -> tuple[float, ...] | None:
        if len(efforts) != len(self._actuated):
            line = f"command with {len(efforts)} efforts for {len(self._actuated)} joints"
            return self.refuse(Refusal.LENGTH, line)
        if all(map(le, map(abs, efforts), self._largest)):
            return tuple(efforts)
        if not all(map(isfinite, efforts)):
            return self.refuse(Refusal.NOT_FINITE, f"command with efforts {list(efforts)}")
        most = [float(f"{largest:.3g}") for largest in self._largest]
        return self.refuse(
            Refusal.HUGE, f"command with efforts {list(efforts)}, the largest are {most}"
        )
