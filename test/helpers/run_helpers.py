"""What tests of whole runs check of a summary."""

from typing import Any

RESEND = 0.5  # s without a command until lockstep sends a state again


def check_answers(summary: dict[str, Any], steps: int) -> None:
    """Check that every state was answered, and once.

    Where the machine stands still for longer than `RESEND`, a state is sent, and may be answered, again.
    """
    commands = summary["commands"]
    again = commands["late"] + commands["duplicate"]
    assert commands["rejected"] == 0 and commands["received"] - again == steps, commands
    assert again <= summary["wall_time"] / RESEND, commands
