"""The command `crane interfaces`: lists the message packages, and builds those that are missing."""

import fcntl
import shutil
import sys
import time
from collections.abc import Callable
from functools import partial

import click
from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

from crane_sim.cli.tables import print_table
from crane_sim.interfaces import toolchain
from crane_sim.interfaces.build import build
from crane_sim.interfaces.packages import USES, Package, choose


@click.command()
@click.argument("packages", nargs=-1)
@click.option(
    "--check", is_flag=True, help="Build nothing: only list what is there and from where."
)
def interfaces(packages: tuple[str, ...], check: bool) -> None:
    """Build and list the message packages that ROS 2's wheels lack.

    They are built into the environment once, which takes about a minute.

    PACKAGES: tf2_msgs, simulation_interfaces, control_msgs; all when left out. One that is there is
    used as it is.
    """
    found = choose(packages)
    missing = [package for package in found if package.missing]
    if missing and not check:
        _build(missing)
        found = choose(packages)
    rows = (
        (package.name, package.origin, USES[package.name] + ("" if package.folder else " (off)"))
        for package in found
    )
    print_table(Console(), "", ("package", "from", "for"), rows)
    raise SystemExit(int(any(package.missing for package in found)))


def _build(packages: list[Package]) -> None:
    """Build packages one after the other, alone in this environment; finally remove generators."""
    toolchain.check_machine()
    toolchain.FOLDER.mkdir(exist_ok=True)
    with (toolchain.FOLDER / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise RuntimeError(f"another process builds in {toolchain.FOLDER}") from None
        percentage = TextColumn("{task.percentage:>3.0f} %")
        columns = (TextColumn("{task.description}"), BarColumn(), percentage, TimeElapsedColumn())
        console = Console(stderr=True)
        with Progress(*columns, console=console, disable=not console.is_terminal) as progress:
            _show(progress, "generators", lambda _: toolchain.make_tools())
            for package in packages:
                _show(progress, package.name, partial(build, package.name))
        shutil.rmtree(toolchain.FOLDER)


def _show(
    progress: Progress, name: str, work: Callable[[Callable[[int, int], None]], None]
) -> None:
    """Do `work`, which reports steps done and in all, behind a progress bar; print its duration."""
    task, begin = progress.add_task(name, total=None), time.monotonic()
    work(lambda done, total: progress.update(task, completed=done, total=total))
    progress.remove_task(task)
    print(f"crane: {name} made in {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
