"""Who commands the crane: whoever comes first keeps it until he has been silent for a while; no rclpy here."""


class Helm:
    """One commander at a time, known by the identifier of his publisher.

    Attributes:
        commander: who commands, empty while nobody does; whoever was there alone may be put in.
    """

    def __init__(self, lease: float) -> None:
        """Let a commander keep the crane for `lease` seconds of silence."""
        self.commander = b""
        self._lease, self._heard = lease, 0.0

    def admits(self, sender: bytes, now: float) -> bool:
        """Return whether a command that came at `now` [s] counts."""
        if sender != self.commander:
            if self.commander and now - self._heard <= self._lease:
                return False
            self.commander = sender
        self._heard = now
        return True

    def renew(self, now: float) -> None:
        """Begin the commander's lease anew at `now` [s], if that is later than it began."""
        self._heard = max(self._heard, now)
