"""Who commands the crane: the first to send a good command keeps it until he sends none for a while; no rclpy here."""


class Helm:
    """One commander at a time, known by the identifier of his publisher.

    Attributes:
        commander: who commands, empty while nobody does; whoever was alone and at work may be put in.
    """

    def __init__(self, lease: float) -> None:
        """Let a commander keep the crane for `lease` seconds without a good command."""
        self.commander = b""
        self._lease, self._heard = lease, 0.0

    def admits(self, sender: bytes, now: float) -> bool:
        """Return whether what he sends at `now` [s] may be a command."""
        return sender == self.commander or not self.commander or now - self._heard > self._lease

    def follow(self, sender: bytes, now: float) -> None:
        """Take note of a good command that came at `now` [s]: he commands from now on, and his lease begins anew."""
        self.commander, self._heard = sender, now

    def renew(self, now: float) -> None:
        """Begin the commander's lease anew at `now` [s], if that is later than it began."""
        self._heard = max(self._heard, now)
