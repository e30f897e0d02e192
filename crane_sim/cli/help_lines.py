"""Help of the command line: -h everywhere, and what each subcommand does in a whole sentence."""

import click

HELP = {"help_option_names": ["-h", "--help"]}
"""Settings of a command's context."""
_WHOLE = 1000  # letters of a sentence that is not cut


class Group(click.Group):
    """A group of commands whose help has the first sentence of each, on as many lines as it takes."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the list of commands."""
        commands = [(name, self.get_command(ctx, name)) for name in self.list_commands(ctx)]
        with formatter.section("Commands"):
            formatter.write_dl([(name, command.get_short_help_str(_WHOLE)) for name, command in commands if command])
