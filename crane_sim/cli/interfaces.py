"""The command `crane interfaces`: what there is of the message packages, and building what is missing."""

import fcntl
import shutil
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from crane_sim.interfaces import toolchain
from crane_sim.interfaces.build import build
from crane_sim.interfaces.packages import USES, Package, choose


def interfaces(names: tuple[str, ...], check: bool) -> int:
    """List the packages, or build those that are missing; return the exit code: 1 where `check` misses one."""
    packages = choose(names)
    missing = [package for package in packages if package.missing]
    if missing and not check:
        _build(missing)
        packages = choose(names)
    _print(packages)
    return int(any(package.missing for package in packages))


def _print(packages: list[Package]) -> None:
    table = Table(box=None, pad_edge=False)
    for heading in ("package", "from", "for"):
        table.add_column(heading, overflow="fold")
    for package in packages:
        off = " (off)" if package.folder is None else ""
        table.add_row(package.name, escape(package.origin), USES[package.name] + off)
    Console().print(table)


def _build(packages: list[Package]) -> None:
    """Build packages one after the other, alone in this environment; remove the generators at the end."""
    toolchain.check_machine()
    percentage = TextColumn("{task.percentage:>3.0f} %")
    columns = (TextColumn("{task.description}"), BarColumn(), percentage, TimeElapsedColumn())
    progress = Progress(*columns, console=Console(stderr=True), disable=not sys.stderr.isatty())
    with _lock():
        with progress:
            _show(progress, "generators", lambda _: toolchain.make_tools())
            for package in packages:
                _show(progress, package.name, partial(build, package.name))
        shutil.rmtree(toolchain.FOLDER)


@contextmanager
def _lock() -> Iterator[None]:
    """Keep other processes from building in this environment until the block, or this process, ends."""
    toolchain.FOLDER.mkdir(exist_ok=True)
    with (toolchain.FOLDER / "lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            raise RuntimeError(f"another process builds in {toolchain.FOLDER}") from None
        yield


def _show(progress: Progress, name: str, work: Callable[[Callable[[int, int], None]], None]) -> None:
    """Do `work`, which reports finished and all steps, behind a progress bar; print how long it took."""
    task, begin = progress.add_task(name, total=None), time.monotonic()
    work(lambda done, total: progress.update(task, completed=done, total=total))
    progress.remove_task(task)
    print(f"crane: {name} made in {time.monotonic() - begin:.0f} s", file=sys.stderr, flush=True)
