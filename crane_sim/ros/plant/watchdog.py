"""Watchdog of commands in real time: the time since the newest one, and the action at its time-out.

Time in which the run is paused does not count.
"""

import time
from enum import StrEnum


class TimeoutAction(StrEnum):
    """Actions of the plant at the time-out of commands."""

    ZERO = "zero"
    HOLD = "hold"
    BRAKE = "brake"

    @property
    def description(self) -> str:
        """The action in words, for warnings and options."""
        return COMMAND_TIMEOUT_ACTIONS[self.value]


COMMAND_TIMEOUT_ACTIONS = {
    TimeoutAction.ZERO.value: "zero effort",
    TimeoutAction.HOLD.value: "the last effort holds",
    TimeoutAction.BRAKE.value: "the brakes act",
}
"""Descriptions of the actions, by their names."""


class Watchdog:
    """Timer of the wall time since the newest command, without the time that is skipped.

    Attributes:
        timeout: time without a command after which the watchdog expires, s; 0: never.
    """

    def __init__(self, timeout: float, period: float) -> None:
        """Expire after `timeout` s, in slow motion after two periods [s] of wall time: states come no faster."""
        self.timeout = max(timeout, 2.0 * period) if timeout else 0.0
        self._elapsed, self._last_update = 0.0, time.monotonic()

    @property
    def expired(self) -> bool:
        """Whether the elapsed time is beyond the time-out."""
        return 0.0 < self.timeout < self._elapsed

    def reset(self) -> None:
        """Begin anew: a command has come, or a run begins."""
        self._elapsed, self._last_update = 0.0, time.monotonic()

    def update(self) -> None:
        """Add the time since the last call of any of these."""
        now = time.monotonic()
        self._elapsed, self._last_update = self._elapsed + now - self._last_update, now

    def skip(self) -> None:
        """Leave that time out: the run was paused."""
        self._last_update = time.monotonic()
