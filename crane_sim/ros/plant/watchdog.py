"""Command time-out in real time: how long no command has come, and what the plant then does.

Time in which the run is paused does not count.
"""

import time

COMMAND_TIMEOUT_ACTIONS = {"zero": "zero effort", "hold": "the last effort holds", "brake": "the brakes act"}
"""The ways to choose from, and what is told of each."""


class Watchdog:
    """Counts the wall time since the newest command, but for what is skipped.

    Attributes:
        timeout: silence after which a commander counts as silent, s; 0: never.
    """

    def __init__(self, timeout: float, period: float) -> None:
        """Be patient for `timeout` s, in slow motion for two periods [s] of wall time: states come no faster."""
        self.timeout = max(timeout, 2.0 * period) if timeout else 0.0
        self._quiet, self._counted = 0.0, time.monotonic()

    @property
    def silent(self) -> bool:
        """Whether what was counted is too long."""
        return 0.0 < self.timeout < self._quiet

    def heard(self) -> None:
        """Begin anew: a command has come, or a run begins."""
        self._quiet, self._counted = 0.0, time.monotonic()

    def count(self) -> None:
        """Count the time since the last call of any of these."""
        now = time.monotonic()
        self._quiet, self._counted = self._quiet + now - self._counted, now

    def skip(self) -> None:
        """Leave that time out: the crane stood."""
        self._counted = time.monotonic()
