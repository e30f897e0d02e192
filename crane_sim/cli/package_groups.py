"""Groups of packages that only some commands need; the first of these installs them.

They go into the tree's environment.
"""

import fcntl
import hashlib
import importlib
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import click
from rich.console import Console

from crane_sim.cli.tables import print_table
from crane_sim.files.catalogue import config_folder
from crane_sim.files.errors import SceneError, did_you_mean
from crane_sim.files.installation import how_to_install, is_of_this_tree


class PackageGroup(NamedTuple):
    """What a group of packages is for, and its size."""

    purpose: str  # what, and which commands
    size: int  # MB, installed


GROUPS = {
    "plots": PackageGroup("figures: plot, report, identify", 80),
    "bench": PackageGroup(
        "pages of the laboratory: bench, soak, league, reproduce, docs, describe --sites", 82
    ),
    "study": PackageGroup("studies: tune, clusters and sensitivity of sweep", 240),
    "gym": PackageGroup("environments of Gymnasium", 4),
    "docs": PackageGroup("the documentation site: docs --build, --serve", 45),
    "test": PackageGroup("the test suite", 420),
    "peers": PackageGroup("other engines: bench --peers, bodies", 1500),
}
_PIP = ("-m", "pip", "install", "--disable-pip-version-check", "--no-deps", "--require-hashes")


def install_groups(*names: str, ask: bool = True) -> None:
    """Install those groups that the tree's environment lacks; other environments are left as is.

    `ask`: on a terminal they are installed only if the user agrees.

    Raises:
        SceneError: the user does not.
        RuntimeError: the packages could not be installed; the message is one line.
    """
    missing = [name for name in names if not _is_installed(name)]
    if not missing or not is_of_this_tree():
        return
    if ask and sys.stdin.isatty() and sys.stderr.isatty():
        _ask(missing)
    with Path(sys.prefix, "groups.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # until another command has installed its own
        missing = [name for name in missing if not _is_installed(name)]
        if missing:
            _install(missing)


def _describe(names: Sequence[str]) -> str:
    return ", and ".join(GROUPS[name].purpose for name in names)


def _ask(names: Sequence[str]) -> None:
    """Ask on the terminal whether groups may be installed; raise SceneError if not."""
    size = sum(GROUPS[name].size for name in names)
    question = f"crane: install the packages for {_describe(names)} ({size} MB)?"
    if not click.confirm(question, default=True, err=True):
        commands = " and ".join(how_to_install(name) for name in names)
        raise SceneError(
            f"the packages for {_describe(names)} are not installed; {commands} installs them"
        )


def _install(names: Sequence[str]) -> None:
    log, files = Path(sys.prefix, "install.log"), [str(_lock_file(name)) for name in names]
    size = sum(GROUPS[name].size for name in names)
    line = f"crane: installing the packages for {_describe(names)} (once, {size} MB)"
    print(line, file=sys.stderr, flush=True)
    options = [option for file in files for option in ("-r", file)]
    with log.open("a") as out:
        pip = subprocess.run([sys.executable, *_PIP, *options], stdout=out, stderr=out, check=False)
    if pip.returncode:
        what = f"the packages of {' and '.join(files)} could not be installed"
        raise RuntimeError(f"{what}; is the network there? (all that pip said: {log})")
    for name in names:
        _stamp(name).parent.mkdir(exist_ok=True)
        _stamp(name).write_text(_digest(name))
    importlib.invalidate_caches()


def _is_installed(name: str) -> bool:
    """Return whether a group was installed from the lock file that it has now."""
    return _stamp(name).is_file() and _stamp(name).read_text() == _digest(name)


def _stamp(name: str) -> Path:
    """Return the file with the digest of the lock file that the group was installed from."""
    return Path(sys.prefix, "groups", f"{name}.sha256")


def _lock_file(name: str) -> Path:
    """Return the file of the group's pinned packages."""
    return config_folder().parent / "requirements" / f"{name}.lock"


def _digest(name: str) -> str:
    return hashlib.sha256(_lock_file(name).read_bytes()).hexdigest()


@click.command("install")
@click.argument("groups", nargs=-1, metavar="[GROUP ...]")
def install_packages(groups: tuple[str, ...]) -> None:
    """Install packages that only some commands need, as these do, too; list them without GROUP."""
    for name in groups:
        if name not in GROUPS:
            near = did_you_mean(name, GROUPS)
            raise SceneError(f"{name}: no such group of packages{near} ({', '.join(GROUPS)})")
    if groups and not is_of_this_tree():
        how = how_to_install(groups[0])
        raise SceneError(f"{sys.prefix}: not made by ./crane; {how} installs the packages")
    install_groups(*groups, ask=False)
    rows = (
        (name, str(group.size), "yes" if _is_installed(name) else "no", group.purpose)
        for name, group in GROUPS.items()
    )
    print_table(Console(), "", ("group", "MB", "installed", "for"), rows)
