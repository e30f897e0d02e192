"""Entry of summaries on messages that a run's nodes refuse; no rclpy here."""

from collections.abc import Mapping

REFUSED = "refused_messages"
"""Name of the entry: messages of other nodes on topics of the run's own ones, with their numbers by
topic and node."""


def refused_entry(refused: Mapping[str, int]) -> dict[str, dict[str, int]]:
    """Return the entry for the numbers of messages refused, by topic and node; none without any."""
    return {REFUSED: dict(refused)} if refused else {}
