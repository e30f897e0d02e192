"""What the plant lets in: every command is screened before it can move the crane, every refusal is counted."""

from collections import Counter
from collections.abc import Callable, Sequence
from math import isfinite
from operator import gt
from typing import TypeVar

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


class CommandGate:
    """Screens the commands of one run; knows stamps [ns], joint names and numbers, but no ROS.

    Attributes:
        received: commands that arrived, good or bad.
        refused: number of refusals by reason (`names`, `length`, `not finite`, `huge`, `unreadable`, `commander`,
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

    def screen(
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
        ordered = self.sized(names, efforts)
        if ordered is not None:
            self._newest = stamp
        return ordered

    def sized(self, names: Sequence[str], efforts: Sequence[float]) -> tuple[float, ...] | None:
        """Return the efforts (nu,) of a command in joint order, or None when it is refused, whatever its stamp."""
        return self._numbers(efforts) if names == self._actuated else self._sorted(names, efforts)

    def screen_array(self, efforts: Sequence[float]) -> tuple[float, ...] | None:
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

    def opened(self, decode: Callable[[bytes], Opened], data: bytes) -> Opened | None:
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

    def _sorted(self, names: Sequence[str], efforts: Sequence[float]) -> tuple[float, ...] | None:
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
