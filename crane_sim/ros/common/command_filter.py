"""What the plant lets in: every command is screened before it can move the crane, every refusal is counted.

The largest efforts that a plant takes: far beyond what any law needs, and no burden to any method.
"""

from collections import Counter
from collections.abc import Callable, Sequence
from math import isfinite
from operator import gt
from typing import TypeVar

import numpy as np

from crane_sim.scenes.scene import Scene
from crane_sim.simulation.metrics import derive

_HARD = 1e5  # rad/s² or m/s², for a joint with all that it carries; in other units than N m and N, as it stands


_LOADS = 1e3  # times what holds a joint against gravity


_APART = 1e-3  # rad or m, between postures whose potential energies are compared


def largest_efforts(scene: Scene, given: float = 0.0) -> tuple[float, ...]:
    """Return bounds (nu,) on the efforts of commands, in the units of the scene's efforts.

    Args:
        scene: its initial posture tells what inertia and gravity ask of a joint.
        given: the same bound for all joints instead; 0 for none.
    """
    if given:
        return (given,) * len(scene.actuated)
    if not scene.actuated:
        return ()
    inertia, load = _required_efforts(scene)
    bounds = np.where(np.isin(scene.effort_units, ("N m", "N")), _HARD * inertia + _LOADS * load, _HARD)
    return tuple(bounds.tolist())


def _required_efforts(scene: Scene) -> tuple[np.ndarray, np.ndarray]:
    """Return the inertia of each joint with all that it carries (nu,), and what gravity asks of it (nu,), at first."""
    joints = [scene.joint_names.index(joint) for joint in scene.actuated]
    n = len(joints)
    q, v = np.tile(scene.initial_q, (4, n, 1)), np.zeros((4, n, len(scene.joint_names)))
    each = range(n)
    q[0, each, joints] += _APART
    q[1, each, joints] -= _APART
    v[2, each, joints] = 1.0
    known = derive(scene, np.zeros(4 * n), q.reshape(4 * n, -1), v.reshape(4 * n, -1), np.zeros((4 * n, n)))
    up, down, _, _ = known.potential_relative.reshape(4, n)
    _, _, moving, still = known.kinetic_relative.reshape(4, n)
    return 2.0 * np.abs(moving - still), np.abs(up - down) / (2.0 * _APART)


Opened = TypeVar("Opened")


_BAD = (
    "names",
    "length",
    "not finite",
    "huge",
    "unstamped",
    "future",
    "unreadable",
    "commander",
)  # refusals that are the sender's mistake


_LATE = ("late", "stale")


_TOLD = 200  # characters of a refusal


class CommandValidator:
    """Screens the commands of one run; knows stamps [ns], joint names and numbers, but no ROS.

    Attributes:
        received: commands that arrived, good or bad.
        refused: number of refusals by reason (`names`, `length`, `not finite`, `huge`, `unreadable`, `owner`,
            `unstamped`, `future`, `late`, `stale`, `duplicate`).
        last_refusal: one line on the latest refusal, empty while there is none.
    """

    def __init__(self, actuated: Sequence[str], largest: Sequence[float]) -> None:
        """Accept commands for exactly the joints `actuated`; the caller gets their efforts in this order.

        Efforts beyond `largest` (nu,) [N m or N] are refused: no state would stay finite.
        """
        self._largest = tuple(largest)
        self.received = 0
        self.refused: Counter[str] = Counter()
        self.last_refusal = ""
        self._actuated = list(actuated)
        self._newest = 0  # stamp of the last accepted command

    def validate(
        self, stamp: int, names: Sequence[str], efforts: Sequence[float], *, now: int, oldest: int
    ) -> tuple[float, ...] | None:
        """Return the efforts (nu,) of a command in joint order, or None when it is refused.

        Args:
            stamp: the command's stamp, ns: that of the state it answers.
            names: its joints, in any order.
            efforts: N m or N, in the order of `names`.
            now: stamp of the newest published state, ns.
            oldest: the oldest stamp still welcome, ns; equal to `now` in lockstep.
        """
        self.received += 1
        if reason := self._untimely(stamp, now, oldest):
            return self.refuse(reason, f"command with stamp {stamp} ns while the state's is {now} ns")
        ordered = self.match_joints(names, efforts)
        if ordered is not None:
            self._newest = stamp
        return ordered

    def match_joints(self, names: Sequence[str], efforts: Sequence[float]) -> tuple[float, ...] | None:
        """Return the efforts (nu,) of a command in joint order, or None when it is refused, whatever its stamp."""
        return self._numbers(efforts) if names == self._actuated else self._sort_by_joint(names, efforts)

    def validate_array(self, efforts: Sequence[float]) -> tuple[float, ...] | None:
        """Return the efforts (nu,) of a command without names and stamp, in joint order, or None when refused."""
        self.received += 1
        return self._numbers(efforts)

    def summary(self) -> dict[str, int]:
        """Return the counters of the run's summary."""
        return {
            "received": self.received,
            "rejected": sum(self.refused[reason] for reason in _BAD),
            "late": sum(self.refused[reason] for reason in _LATE),
            "duplicate": self.refused["duplicate"],
        }

    def decode(self, decode: Callable[[bytes], Opened], data: bytes) -> Opened | None:
        """Return what a message says, or None when it is refused because it says nothing."""
        try:
            return decode(data)
        except ValueError as error:
            self.reject("unreadable", f"command {error}")
            return None

    def reject(self, reason: str, line: str) -> None:
        """Count a command that is refused unread."""
        self.received += 1
        self.refuse(reason, line)

    def refuse(self, reason: str, line: str) -> None:
        """Count a refusal and keep the line on it."""
        self.refused[reason] += 1
        self.last_refusal = f"{line[:_TOLD]} ({reason})"

    def _untimely(self, stamp: int, now: int, oldest: int) -> str:
        if not stamp:
            return "unstamped"
        if stamp > now:
            return "future"
        if stamp == self._newest:
            return "duplicate"
        if stamp < self._newest:
            return "late"
        return "stale" if stamp < oldest else ""

    def _sort_by_joint(self, names: Sequence[str], efforts: Sequence[float]) -> tuple[float, ...] | None:
        if sorted(names) != sorted(self._actuated):
            return self.refuse("names", f"command for joints {list(names)}, the actuated ones are {self._actuated}")
        if len(efforts) != len(names):
            return self._numbers(efforts)
        by_name = dict(zip(names, efforts, strict=True))
        return self._numbers([by_name[name] for name in self._actuated])

    def _numbers(self, efforts: Sequence[float]) -> tuple[float, ...] | None:
        if len(efforts) != len(self._actuated):
            return self.refuse("length", f"command with {len(efforts)} efforts for {len(self._actuated)} joints")
        if not all(map(isfinite, efforts)):
            return self.refuse("not finite", f"command with efforts {list(efforts)}")
        if any(map(gt, map(abs, efforts), self._largest)):
            most = [float(f"{largest:.3g}") for largest in self._largest]
            return self.refuse("huge", f"command with efforts {list(efforts)}, the largest are {most}")
        return tuple(efforts)
