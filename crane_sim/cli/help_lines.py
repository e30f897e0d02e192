"""Help of the command line: -h everywhere, whole sentences for subcommands, and the names near an unknown one."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import click

from crane_sim.files.errors import did_you_mean
from crane_sim.files.extensions import find_extensions

COMMANDS = "crane_sim.commands"
"""Group of entry points of further commands."""

HELP = {"help_option_names": ["-h", "--help"]}
"""Settings of a command's context."""
_MAX_HELP_LENGTH = 1000  # characters: more than any first sentence has


class CommandGroup(click.Group):
    """A group of commands whose help has the first sentence of each, on as many lines as it takes."""

    def resolve_command(
        self, ctx: click.Context, args: Sequence[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return name, command and remaining arguments; an unknown command fails with the possible ones."""
        if self.get_command(ctx, args[0]) is None:
            names = sorted(self.list_commands(ctx))
            ctx.fail(f"No such command {args[0]!r}{did_you_mean(args[0], names)} (known: {', '.join(names)})")
        return super().resolve_command(ctx, list(args))

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands."""
        for title, names in self.list_sections(ctx).items():
            commands = [(name, self.get_command(ctx, name)) for name in names]
            with formatter.section(title):
                formatter.write_dl(
                    [(name, command.get_short_help_str(_MAX_HELP_LENGTH)) for name, command in commands if command]
                )

    def list_sections(self, ctx: click.Context) -> dict[str, list[str]]:
        """Return the names of commands by the sections of the help."""
        return {"Commands": self.list_commands(ctx)}


class Application(CommandGroup):
    """The command `crane`: its own commands, and those that packages declare as entry points `crane_sim.commands`."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands: its own, then the others."""
        return [name for names in self.list_sections(ctx).values() for name in names]

    def list_sections(self, ctx: click.Context) -> dict[str, list[str]]:
        """Return the names of commands by the sections of the help."""
        others = sorted({entry.name for entry in find_extensions(COMMANDS)} - {*self.commands})
        return {"Commands": sorted(self.commands), "Laboratory": others}

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command; entry points are searched where it is none of its own."""
        own = super().get_command(ctx, cmd_name)
        if own is not None:
            return own
        return next((entry.load() for entry in find_extensions(COMMANDS) if entry.name == cmd_name), None)


class IntAtLeast(click.IntRange):
    """Type of an option: an integer of at least `min`; the error for anything else names what is possible."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number of an option's text."""
        try:
            return super().convert(value, param, ctx)
        except click.BadParameter:
            self.fail(f"{value!r}: must be a whole number of at least {self.min}", param, ctx)


class FiniteRange(click.FloatRange):
    """Type of an option: a finite number in a range; `FloatRange` lets NaN pass."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number of an option's text."""
        number = super().convert(value, param, ctx)
        if not isfinite(number):
            self.fail(f"{value!r}: must be a finite number", param, ctx)
        return number

    def _describe_range(self) -> str:
        """Return the range as the help shows it, nothing without bounds."""
        return "" if self.min is self.max is None else super()._describe_range()
