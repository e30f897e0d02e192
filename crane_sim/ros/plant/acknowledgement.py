"""Whether a commander that is silent in lockstep may be alive, by what the subscribers acknowledge; no rclpy here."""

from math import inf


class Acknowledgement:
    """Tells a commander's missing acknowledgement from another subscriber's.

    The middleware says only whether all subscribers have the newest state. A commander that answers states has them:
    where acknowledgements were missing for longer than the lease while answers came, another subscriber's were. Then
    the commander's own are unknown, and it counts as alive as long as it is in the graph.
    """

    def __init__(self, lease: float) -> None:
        """Begin without a note; `lease` [s] as of the commands."""
        self._lease = lease
        self._acknowledged = False
        self._complete = self._noted = -inf  # s, when all had the newest state, and when that was last looked at

    def note(self, acknowledged: bool, now: float) -> None:
        """Take note of whether all have the newest state at `now` [s]; what was long ago counts no more."""
        if acknowledged or now - self._noted > self._lease:
            self._complete = now
        self._acknowledged, self._noted = acknowledged, now

    def excuses(self, answered: float) -> bool:
        """Return whether a commander whose last answer came at `answered` [s] may be alive, as of the last note."""
        return self._acknowledged or answered - self._complete > self._lease
