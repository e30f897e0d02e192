"""Replay buffer of a standby recorder: the newest messages, replayed when it takes over."""

import time
from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from itertools import repeat
from math import inf
from typing import NamedTuple

from crane_sim.recording.mcap.topic import stamp_of

SECONDS = 10.0  # more than a recorder, on a busy machine, has received and not yet written
_STAMPED = (
    "joint_states",
    "true_states",
    "applied_effort",
    "joint_commands",
    "accepted_command",
    "held_command",
)
_LATCHED = ("robot_description", "simulation_state", "/tf_static")  # valid until the next one comes
_LASTING = ("joint_trajectory", *_LATCHED)  # the same, the first one until the plant is reset
_BY_CONTENT = "/tf_static"  # several broadcasters latch different transforms there
_BROADCASTERS = 100  # different messages of that topic that are kept, the newest ones
# of the present state; not replayed, newer ones follow
_FOLLOWING = ("/clock", "/tf", "/diagnostics")


class _Message(NamedTuple):
    received: float  # s of the monotonic clock
    resets: int  # resets of the plant before it
    state: int  # ns, stamp of the newest state before it: a sample of an instrument may be stamped
    # earlier
    name: str  # of its topic
    data: bytes


class ReplayBuffer:
    """Buffer of the newest serialized messages; from `replay_to` on it passes all messages on."""

    def __init__(self, names: Iterable[str], resets: int = 0) -> None:
        """Buffer messages of these topics; `resets` counts the resets of the plant so far."""
        self._names = tuple(names)
        self._newest: deque[_Message] = deque()
        self._lasting: dict[str | bytes, _Message] = {}  # by topic, or by their content
        self._outputs: list[Mapping[str, Callable[[bytes], None]]] = []
        self._resets, self._stamp = resets, 0

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        """Return one callback of a serialized message per topic."""
        return {name: partial(self._on_message, name) for name in self._names}

    def replay_to(
        self,
        outputs: Sequence[Mapping[str, Callable[[bytes], None]]],
        after: Sequence[int],
        resets: int = 0,
    ) -> None:
        """Replay the buffered messages, and pass all later ones on.

        Args:
            outputs: callbacks of a message per topic, for each output.
            after: stamp [ns] for each output, up to which it has been recorded: buffered messages
                of states and commands are replayed where they have a later one, others where the
                newest state had. 0: all are.
            resets: number of resets of the plant before the steps of these stamps: messages before
                the last one are not replayed, those after it all are.
        """
        self._outputs, resets = list(outputs), min(resets, self._resets)
        while self._newest and self._newest[0].resets < resets:
            self._drop()
        for message in self._lasting.values():
            if message.resets >= resets or message.name in _LATCHED:
                self._pass_on(message.name, message.data)
        for message in self._newest:
            if message.name in _FOLLOWING:
                continue
            lasts = message.name in _LASTING or message.resets != resets
            stamp = inf if lasts else _stamp_in_run(message)
            self._pass_on(message.name, message.data, [not last or stamp > last for last in after])
        self._newest.clear()

    def _on_message(self, name: str, data: bytes) -> None:
        if self._outputs:
            self._pass_on(name, data)
            return
        if name == "joint_states":
            self._count_reset(stamp_of(data))
        now = time.monotonic()
        self._newest.append(_Message(now, self._resets, self._stamp, name, data))
        while self._newest[0].received < now - SECONDS:
            self._drop()

    def _count_reset(self, stamp: int) -> None:
        """Count a reset where a state has a smaller stamp than the last: they arrive in order."""
        self._resets += stamp < self._stamp
        self._stamp = stamp

    def _drop(self) -> None:
        message = self._newest.popleft()
        if message.name == _BY_CONTENT:
            self._lasting.pop(message.data, None)
            self._lasting[message.data] = message
            latched = [key for key in self._lasting if isinstance(key, bytes)]
            for key in latched[:-_BROADCASTERS]:
                del self._lasting[key]
        elif message.name in _LASTING:
            self._lasting[message.name] = message

    def _pass_on(self, name: str, data: bytes, selected: Iterable[bool] = repeat(True)) -> None:
        for callbacks, enabled in zip(self._outputs, selected, strict=False):
            if enabled and name in callbacks:
                callbacks[name](data)


def _stamp_in_run(message: _Message) -> int:
    """Return the stamp [ns] of a message's state, by its own stamp or by when it came."""
    return (stamp_of(message.data) if message.name in _STAMPED else 0) or message.state
