"""Checks of the summary of a whole run."""

from typing import Any

RESEND = 0.05  # s, the shortest time between two sendings of a state that is not answered


def check_one_command_per_state(summary: dict[str, Any], steps: int) -> None:
    """Check that every state was answered once.

    Where the machine stalls for half a second, a state is sent, and may be answered, again.
    """
    commands = summary["commands"]
    repeated = commands["late"] + commands["duplicate"]
    assert commands["rejected"] == 0 and commands["received"] - repeated == steps, commands
    assert repeated <= summary["wall_time"] / RESEND, commands
