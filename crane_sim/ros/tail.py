"""The newest messages of a run, kept by a recorder that stands by, until it has to go on where another one died."""

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import repeat
from math import inf

from crane_sim.recording.topic import stamp_of

SECONDS = 10.0  # more than a recorder, on a busy machine, has in its hands and not yet on the disk
_STAMPED = ("joint_states", "applied_effort", "joint_commands")
_LASTING = ("joint_trajectory", "robot_description", "simulation_state")  # hold until the next one comes


class Tail:
    """Takes serialized messages: keeps the newest ones, and passes all on as soon as there is somebody to take them."""

    def __init__(self, names: Iterable[str]) -> None:
        """Expect messages of these topics."""
        self._names = tuple(names)
        self._kept: deque[tuple[float, str, bytes]] = deque()
        self._lasting: dict[str, bytes] = {}
        self._takers: list[Mapping[str, Callable[[bytes], None]]] = []

    def takers(self) -> dict[str, Callable[[bytes], None]]:
        """Return one function of a serialized message per topic."""
        return {name: partial(self._take, name) for name in self._names}

    def pass_to(self, takers: Sequence[Mapping[str, Callable[[bytes], None]]], behind: Sequence[int]) -> None:
        """Hand over what was kept, and then everything.

        Args:
            takers: functions of a message per topic, by what takes them.
            behind: stamp [ns] for each of them; of what was kept it takes, of each step, only what is stamped later.
        """
        self._takers = list(takers)
        for name, data in self._lasting.items():
            self._pass_on(name, data)
        for _, name, data in self._kept:
            stamp = stamp_of(data) if name in _STAMPED else inf
            self._pass_on(name, data, [stamp > start for start in behind])
        self._kept.clear()

    def _take(self, name: str, data: bytes) -> None:
        if self._takers:
            self._pass_on(name, data)
            return
        now = time.monotonic()
        self._kept.append((now, name, data))
        while self._kept[0][0] < now - SECONDS:
            _, old, dropped = self._kept.popleft()
            if old in _LASTING:
                self._lasting[old] = dropped

    def _pass_on(self, name: str, data: bytes, wanted: Iterable[bool] = repeat(True)) -> None:
        for takers, wants in zip(self._takers, wanted, strict=False):
            if wants and name in takers:
                takers[name](data)
