"""Groups of packages that only some commands need, installed into the tree's environment by the first that does."""

import fcntl
import hashlib
import importlib
import subprocess
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple

import click
from rich.console import Console
from rich.table import Table

from crane_sim.files.catalogue import config_folder
from crane_sim.files.errors import SceneError, did_you_mean
from crane_sim.files.installation import how_to_install, is_of_this_tree


class PackageGroup(NamedTuple):
    """What a group of packages is for, and its size."""

    purpose: str  # what, and which commands
    size: int  # MB, installed


GROUPS = {
    "plots": PackageGroup("figures: plot, report, identify", 80),
    "bench": PackageGroup("pages of the laboratory: bench, soak, league, reproduce, docs, describe --sites", 82),
    "study": PackageGroup("studies: tune, clusters and sensitivity of sweep", 240),
    "gym": PackageGroup("environments of Gymnasium", 4),
    "docs": PackageGroup("the documentation site: docs --build, --serve", 45),
    "test": PackageGroup("the test suite", 420),
    "peers": PackageGroup("other engines: bench --peers, bodies", 1500),
}


def install_groups(*names: str, ask: bool = True) -> None:
    """Install those groups that the tree's environment lacks; an environment of another making is left as it is.

    `ask`: on a terminal they are installed only if the user agrees.

    Raises:
        SceneError: the user does not.
        RuntimeError: the packages could not be installed; the message is one line.
    """
    missing = [name for name in names if not _is_installed(name)]
    if not is_of_this_tree() or not missing:
        return
    if ask and sys.stdin.isatty() and sys.stderr.isatty():
        _ask(missing)
    with _lock():
        for name in names:
            if not _is_installed(name):
                _install(name)


def _ask(names: Sequence[str]) -> None:
    """Ask on the terminal whether groups may be installed; raise SceneError if not."""
    purposes = ", and ".join(GROUPS[name].purpose for name in names)
    size = sum(GROUPS[name].size for name in names)
    if not click.confirm(f"crane: install the packages for {purposes} ({size} MB)?", default=True, err=True):
        commands = " and ".join(how_to_install(name) for name in names)
        raise SceneError(f"the packages for {purposes} are not installed; {commands} installs them")


def check_names(names: tuple[str, ...]) -> None:
    """Check that groups exist, and that they can be installed here.

    Raises:
        SceneError: a name is unknown, or the environment is not the tree's own.
    """
    for name in names:
        if name not in GROUPS:
            raise SceneError(f"{name}: no such group of packages{did_you_mean(name, GROUPS)} ({', '.join(GROUPS)})")
    if names and not is_of_this_tree():
        raise SceneError(f"{sys.prefix}: not made by ./crane; {how_to_install(names[0])} installs the packages")


def _is_installed(name: str) -> bool:
    """Return whether a group was installed from the lock file that it has now."""
    return _stamp(name).is_file() and _stamp(name).read_text() == _digest(name)


def _install(name: str) -> None:
    log = Path(sys.prefix, "install.log")
    line = f"crane: installing the packages for {GROUPS[name].purpose} (once, {GROUPS[name].size} MB)"
    options = ("--disable-pip-version-check", "--no-deps", "--require-hashes")
    command = [sys.executable, "-m", "pip", "install", *options, "-r", str(_lock_file(name))]
    print(line, file=sys.stderr, flush=True)
    with log.open("a") as out:
        code = subprocess.run(command, stdout=out, stderr=out, check=False).returncode
    if code:
        what = f"the packages of {_lock_file(name)} could not be installed"
        raise RuntimeError(f"{what}; is the network there? (all that pip said: {log})")
    _stamp(name).parent.mkdir(exist_ok=True)
    _stamp(name).write_text(_digest(name))
    importlib.invalidate_caches()


@contextmanager
def _lock() -> Iterator[None]:
    """Let one process at a time install packages."""
    with Path(sys.prefix, "groups.lock").open("w") as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("crane: waiting for another command that installs packages", file=sys.stderr, flush=True)
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _lock_file(name: str) -> Path:
    """Return the file of the group's pinned packages."""
    return config_folder().parent / "requirements" / f"{name}.lock"


def _digest(name: str) -> str:
    return hashlib.sha256(_lock_file(name).read_bytes()).hexdigest()


def _stamp(name: str) -> Path:
    """Return the file with the digest of the lock file that the group was installed from."""
    return Path(sys.prefix, "groups", f"{name}.sha256")


@click.command("install")
@click.argument("groups", nargs=-1, metavar="[GROUP ...]")
def install_packages(groups: tuple[str, ...]) -> None:
    """Install groups of packages that only some commands need, which they do themselves; without GROUP, list them."""
    check_names(groups)
    install_groups(*groups, ask=False)
    table = Table(box=None, pad_edge=False)
    for heading in ("group", "MB", "installed", "for"):
        table.add_column(heading, overflow="fold")
    for name, group in GROUPS.items():
        table.add_row(name, str(group.size), "yes" if _is_installed(name) else "no", group.purpose)
    Console().print(table)
