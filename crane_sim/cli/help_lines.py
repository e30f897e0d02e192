"""Help of the command line: -h everywhere, whole sentences for subcommands, and the names near an unknown one."""

from collections.abc import Sequence
from math import isfinite
from typing import Any

import click

from crane_sim.files.errors import did_you_mean

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
            names = self.list_commands(ctx)
            ctx.fail(f"No such command {args[0]!r}{did_you_mean(args[0], names)} (known: {', '.join(names)})")
        return super().resolve_command(ctx, list(args))

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands."""
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl(
                [(name, command.get_short_help_str(_MAX_HELP_LENGTH)) for name, command in commands if command]
            )


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
