"""The commands of `crane`, those of entry points among them."""

import click

from crane_sim.cli.commands import app


def commands() -> dict[str, click.Command]:
    """Return all commands by name."""
    context = click.Context(app)
    found = {name: app.get_command(context, name) for name in app.list_commands(context)}
    return {name: command for name, command in found.items() if command is not None}
