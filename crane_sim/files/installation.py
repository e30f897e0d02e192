"""The environment that the simulator runs in, and the optional packages that it may lack.

A source tree has an environment of its own, which the script `crane` makes; elsewhere pip installs
this package with the extras that a user wants.
"""

import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

from crane_sim.files.catalogue import config_folder
from crane_sim.files.errors import SceneError


class OptionalPackage(NamedTuple):
    """A package that only some features need."""

    name: str  # as pip knows it
    extra: str  # of this package, which brings it
    group: str = ""  # of `./crane install`, which brings it; empty: ./crane installs it from the
    # start


_RERUN, _ROS = OptionalPackage("rerun-sdk", "rerun"), OptionalPackage("rclpy", "ros")
PACKAGES = {
    "rclpy": _ROS,
    "rerun": _RERUN,
    "rerun_cli": _RERUN,
    "PIL": OptionalPackage("pillow", "rerun"),
    "rosbags": OptionalPackage("rosbags", "mcap"),
    "mcap": OptionalPackage("mcap", "mcap"),
    "matplotlib": OptionalPackage("matplotlib", "plots", "plots"),
    "jinja2": OptionalPackage("jinja2", "bench", "bench"),
    "pandas": OptionalPackage("pandas", "pandas", "study"),
    "gymnasium": OptionalPackage("gymnasium", "gym", "gym"),
    "zensical": OptionalPackage("zensical", "docs", "docs"),
    "pytest": OptionalPackage("pytest", "test", "test"),
    **{
        module: OptionalPackage(module, "study", "study")
        for module in ("pyarrow", "dask", "distributed", "fsspec", "optuna", "SALib")
    },
}
"""Optional packages by the module that is imported."""


class MissingPackage(SceneError):
    """An optional package is not installed; the message is one line with the command for it."""


def is_of_this_tree() -> bool:
    """Return whether the script `crane` of this tree made the environment, by its stamp."""
    made = Path(sys.prefix, "crane.stamp")
    return made.is_file() and made.read_text().splitlines()[-1] == str(config_folder().parent)


def how_to_install(group: str, extra: str = "") -> str:
    """Return the command that installs a group of packages, elsewhere by pip with an `extra`."""
    return (
        f"./crane install {group}"
        if is_of_this_tree()
        else f"pip install 'crane_sim[{extra or group}]'"
    )


def import_optional(module: str, purpose: str) -> Any:
    """Return a module of an optional package, which `purpose` needs.

    Raises:
        MissingPackage: it is not installed.
    """
    try:
        return import_module(module)
    except ModuleNotFoundError as error:
        raise MissingPackage(missing_package(error.name or module, purpose)) from None


def require(module: str, purpose: str) -> None:
    """Raise MissingPackage where the optional package that `purpose` needs is not installed."""
    try:
        found = find_spec(module) is not None
    except ModuleNotFoundError:  # of the package of a module
        found = False
    if not found:
        raise MissingPackage(missing_package(module, purpose))


def missing_package(module: str, purpose: str) -> str:
    """Return one line on an optional package that `purpose` needs and that is not installed."""
    top = module.partition(".")[0]
    package = PACKAGES.get(top, OptionalPackage(top, ""))
    if is_of_this_tree() and not package.group:
        how = f"remove {sys.prefix}, and ./crane makes it anew"
    elif package.extra:
        how = how_to_install(package.group, package.extra)
    else:
        how = f"pip install {top}"
    return f"{purpose} needs the Python package {package.name}, which is not installed ({how})"
