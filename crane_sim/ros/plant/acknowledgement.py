"""Liveness of the command owner in lockstep, by acknowledgements of published states; no rclpy."""

from math import inf


class AcknowledgementMonitor:
    """Monitor that distinguishes the owner's missing acknowledgement from another subscriber's.

    The middleware reports only whether all subscribers have acknowledged the newest state. An owner
    that answers states has them: where acknowledgements were missing for longer than the lease
    while answers came, another subscriber's were. Then the owner's own are unknown, and it counts
    as alive as long as it is in the graph.
    """

    def __init__(self, lease: float) -> None:
        """Create it without an observation; `lease` [s]: that of the commands."""
        self._lease = lease
        self._acknowledged = False
        # s, when all had acknowledged, and of the last observation
        self._last_complete = self._last_update = -inf

    def update(self, acknowledged: bool, now: float) -> None:
        """Record whether all acknowledged the newest state at `now` [s]; old records expire."""
        if acknowledged or now - self._last_update > self._lease:
            self._last_complete = now
        self._acknowledged, self._last_update = acknowledged, now

    def may_be_alive(self, last_answer: float) -> bool:
        """Return whether an owner that last answered at `last_answer` [s] may be alive.

        This holds as of the last update.
        """
        return self._acknowledged or last_answer - self._last_complete > self._lease
