"""The newest messages of a run, kept by a recorder that stands by, until it has to go on where another one died."""

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import repeat
from math import inf
from typing import NamedTuple

from crane_sim.recording.mcap.topic import stamp_of

SECONDS = 10.0  # more than a recorder, on a busy machine, has in its hands and not yet on the disk
_STAMPED = ("joint_states", "applied_effort", "joint_commands", "accepted_command")
_LATCHED = ("robot_description", "simulation_state")  # hold until the next one comes
_LASTING = ("joint_trajectory", *_LATCHED)  # the same, the first one until the plant is reset


class _Message(NamedTuple):
    at: float  # s of the monotonic clock
    passes: int  # resets of the plant before it
    name: str  # of its topic
    data: bytes


class ReplayBuffer:
    """Takes serialized messages: keeps the newest ones, and passes all on as soon as there is somebody to take them."""

    def __init__(self, names: Iterable[str], passes: int = 0) -> None:
        """Expect messages of these topics; `passes` counts the resets of the plant so far."""
        self._names = tuple(names)
        self._kept: deque[_Message] = deque()
        self._lasting: dict[str, _Message] = {}
        self._takers: list[Mapping[str, Callable[[bytes], None]]] = []
        self._passes, self._stamp = passes, 0

    def takers(self) -> dict[str, Callable[[bytes], None]]:
        """Return one function of a serialized message per topic."""
        return {name: partial(self._take, name) for name in self._names}

    def pass_to(
        self, takers: Sequence[Mapping[str, Callable[[bytes], None]]], behind: Sequence[int], passes: int = 0
    ) -> None:
        """Hand over what was kept, and then everything.

        Args:
            takers: functions of a message per topic, by what takes them.
            behind: stamp [ns] for each of them; of what was kept it takes, of each step, only what is stamped later.
            passes: resets of the plant before the steps of these stamps: what is older is not handed over, and of what
                is newer all.
        """
        self._takers, passes = list(takers), min(passes, self._passes)
        while self._kept and self._kept[0].passes < passes:
            self._drop()
        for message in self._lasting.values():
            if message.passes >= passes or message.name in _LATCHED:
                self._pass_on(message.name, message.data)
        for message in self._kept:
            counts = message.name in _STAMPED and message.passes == passes
            stamp = stamp_of(message.data) if counts else inf
            self._pass_on(message.name, message.data, [stamp > start for start in behind])
        self._kept.clear()

    def _take(self, name: str, data: bytes) -> None:
        if self._takers:
            self._pass_on(name, data)
            return
        if name == "joint_states":
            self._note(stamp_of(data))
        now = time.monotonic()
        self._kept.append(_Message(now, self._passes, name, data))
        while self._kept[0].at < now - SECONDS:
            self._drop()

    def _note(self, stamp: int) -> None:
        """Count a reset where a state has a smaller stamp than the one before it: they arrive in order."""
        self._passes += stamp < self._stamp
        self._stamp = stamp

    def _drop(self) -> None:
        message = self._kept.popleft()
        if message.name in _LASTING:
            self._lasting[message.name] = message

    def _pass_on(self, name: str, data: bytes, wanted: Iterable[bool] = repeat(True)) -> None:
        for takers, wants in zip(self._takers, wanted, strict=False):
            if wants and name in takers:
                takers[name](data)
