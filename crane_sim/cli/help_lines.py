"""Help of the command line: -h everywhere, groups of commands, and names near an unknown one."""

from collections.abc import Sequence
from functools import cache
from math import isfinite
from typing import Any

import click

from crane_sim.files.errors import SceneError, did_you_mean
from crane_sim.files.extensions import find_extensions

COMMANDS = "crane_sim.commands"
"""Group of entry points of further commands."""
SECTIONS = {
    "Run a crane": ("run", "drive", "simulate", "scenes", "check", "describe", "urdf"),
    "Look at runs": ("view", "shot", "clip", "plot", "report", "compare", "replay"),
    "Study many runs": ("sweep", "tune", "identify"),
    "Set up": ("doctor", "install", "interfaces"),
}
"""Commands by the sections of the help; all others are in the last one, the laboratory."""

HELP = {"help_option_names": ["-h", "--help"]}
"""Settings of a command's context."""
_MAX_HELP_LENGTH = 1000  # characters: more than any first sentence has


class CommandGroup(click.Group):
    """A group of commands whose help has the first sentence of each, on any number of lines."""

    def resolve_command(
        self, ctx: click.Context, args: Sequence[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Return name, command, other arguments; an unknown command fails with those that exist."""
        if self.get_command(ctx, args[0]) is None:
            names = sorted(self.list_commands(ctx))
            near = did_you_mean(args[0], names)
            ctx.fail(f"No such command {args[0]!r}{near} (known: {', '.join(names)})")
        return super().resolve_command(ctx, list(args))

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands."""
        self._write_section(ctx, formatter, "Commands", self.list_commands(ctx))

    def _write_section(
        self, ctx: click.Context, formatter: click.HelpFormatter, title: str, names: Sequence[str]
    ) -> None:
        rows = []
        for name in names:
            try:
                command = self.get_command(ctx, name)
            except SceneError as error:  # of a package, which must not cost the others their help
                click.echo(f"crane: warning: {error}", err=True)
                continue
            if command is not None:
                rows.append((name, command.get_short_help_str(_MAX_HELP_LENGTH)))
        if not rows:
            return
        with formatter.section(title):
            formatter.write_dl(rows)


class Application(CommandGroup):
    """The command `crane`: its own commands, and those that packages declare as entry points."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Return the names of all commands."""
        return sorted({*self.commands, *(entry.name for entry in find_extensions(COMMANDS))})

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands by sections."""
        names = self.list_commands(ctx)
        listed = {name for section in SECTIONS.values() for name in section}
        for title, section in SECTIONS.items():
            self._write_section(ctx, formatter, title, [name for name in section if name in names])
        others = [name for name in names if name not in listed]
        self._write_section(ctx, formatter, "Laboratory", others)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Return a command; entry points are searched where it is none of its own.

        Raises:
            SceneError: the package that declares it cannot be imported.
        """
        return super().get_command(ctx, cmd_name) or _find_command(cmd_name)


@cache
def _find_command(name: str) -> click.Command | None:
    """Return the command of an entry point, None where there is none of this name."""
    for entry in find_extensions(COMMANDS):
        if entry.name == name:
            try:
                return entry.load()
            except Exception as error:  # whatever the package does as it is imported
                line = f"{type(error).__name__}: {error}".splitlines()[0]
                raise SceneError(
                    f"command {name}: {entry.value} cannot be imported: {line}"
                ) from None
    return None


class IntAtLeast(click.IntRange):
    """Type of an option: an integer of at least `min`; other values are errors that say so."""

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
