"""The command `crane`: Ctrl-C ends it in one line.

That holds from its first statement on, so what it can do is imported later.
"""

import os
import sys
import warnings
from typing import TYPE_CHECKING, TextIO

from crane_sim import environment, process_signals

if TYPE_CHECKING:
    import click


def main() -> int:
    """Run the command; return its exit code: 0 done, 1 a fault while running, 2 bad input."""
    process_signals.exit_on_signal(_on_interrupt)
    warnings.showwarning = _show_warning
    shortage = environment.memory_shortage()
    return _fail(shortage, 1) if shortage else _run()


def _run() -> int:
    """Run the command with what it imports, and print a failure in one line."""
    import click

    from crane_sim.cli.commands import app
    from crane_sim.files.errors import SceneError
    from crane_sim.files.installation import missing_package

    try:
        return app(standalone_mode=False) or 0
    except SceneError as error:
        return _fail(str(error), 2)
    except ModuleNotFoundError as error:
        return _fail(missing_package(str(error.name), "this command"), 2)
    except click.ClickException as error:
        return _fail_by_usage(error)
    except click.Abort:  # a RuntimeError as well
        return _fail("interrupted", 1)
    except (RuntimeError, OSError) as error:
        return _fail(str(error), 1)
    except MemoryError:
        return _fail("the run does not fit into memory; shorten its duration", 1)
    # a gap in the checks: still one line
    except (ArithmeticError, LookupError, TypeError, ValueError) as error:
        return _fail(
            f"unforeseen {type(error).__name__}: {error}; please report the scene that led here", 1
        )


def _fail_by_usage(error: "click.ClickException") -> int:
    """Print what click says of a command line; return the exit code."""
    if type(error).__name__ == "NoArgsIsHelpError":
        # older versions of click print the usage themselves
        print(error.format_message(), file=sys.stderr)
        return 2
    return _fail(error.format_message(), 2)


def _fail(message: str, code: int, stream: TextIO | None = None) -> int:
    """Print a failure in one line to a stream (None: stderr); return the exit code.

    With --json it is printed as JSON, too.
    """
    if "--json" in sys.argv:
        import json

        try:
            print(json.dumps({"error": message}), flush=True)
        except OSError:  # a full disk: flushing stdout at exit must not fail again
            os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    print(f"crane: {message}", file=stream or sys.stderr, flush=True)
    return code


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Print a deprecation in one line, others with their place; see `warnings.showwarning`."""
    from crane_sim.files.errors import RenameWarning

    own = issubclass(category, RenameWarning)
    text = (
        f"crane: warning: {message}\n"
        if own
        else warnings.formatwarning(message, category, filename, lineno, line)
    )
    print(text, file=file or sys.stderr, end="")


def _on_interrupt() -> None:
    """End the process independent of its other threads."""
    stream = None
    try:
        if sys.stderr.isatty():
            stream = os.fdopen(os.dup(2), "w")
            os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # a progress display draws no more
            print("\r\x1b[K\x1b[?25h", end="", file=stream)  # clear its line, show the cursor
        _fail("interrupted", 1, stream)
        process_signals.end_workers()
    finally:
        os._exit(1)
