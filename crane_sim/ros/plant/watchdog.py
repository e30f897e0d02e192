"""Watchdog of commands in real time: the time since the newest one, and the action at its time-out.

Time in which the run is paused does not count.
"""

import time
from enum import StrEnum


class CommandTimeoutAction(StrEnum):
    """Actions of the plant at the time-out of commands."""

    ZERO = "zero"
    HOLD = "hold"
    BRAKE = "brake"

    @property
    def description(self) -> str:
        """The action in words, for warnings and options."""
        return COMMAND_TIMEOUT_ACTIONS[self.value]


COMMAND_TIMEOUT_ACTIONS = {
    CommandTimeoutAction.ZERO.value: "zero effort",
    CommandTimeoutAction.HOLD.value: "the last effort holds",
    CommandTimeoutAction.BRAKE.value: "the brakes act",
}
"""Descriptions of the actions, by their names."""


class Watchdog:
    """Timer of the wall time since the newest command, less the time that is skipped.

    Attributes:
        timeout: time without a command after which the watchdog expires, s; 0: never.
    """

    def __init__(self, timeout: float, wall_period: float) -> None:
        """Start with a time-out [s] of at least two periods of wall time [s]: a slowed-down run publishes no faster."""
        self.timeout = max(timeout, 2.0 * wall_period) if timeout else 0.0
        self._elapsed, self._last_update = 0.0, time.monotonic()

    @property
    def expired(self) -> bool:
        """Whether the elapsed time is beyond the time-out."""
        return 0.0 < self.timeout < self._elapsed

    def reset(self) -> None:
        """Restart the time-out: a command has arrived, or a run begins."""
        self._elapsed, self._last_update = 0.0, time.monotonic()

    def update(self) -> None:
        """Add the time since the last reset, update or skip."""
        now = time.monotonic()
        self._elapsed, self._last_update = self._elapsed + now - self._last_update, now

    def skip(self) -> None:
        """Discard the time since then: the run was paused."""
        self._last_update = time.monotonic()
