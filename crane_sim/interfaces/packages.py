"""The message packages that the simulator uses where they are importable."""

import hashlib
import sys
from importlib import invalidate_caches
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from crane_sim.files.catalogue import config_folder
from crane_sim.files.errors import SceneError, did_you_mean

USES = {
    "tf2_msgs": "transforms on /tf and /tf_static",
    "simulation_interfaces": "the standard services of simulators",
    "control_msgs": "the action FollowJointTrajectory",
}
"""What each package is for: without it this is off, and everything else works."""


class Package(NamedTuple):
    """A message package as this environment has it."""

    name: str
    folder: Path | None  # of its Python module, None where it is not importable
    built: str | None  # digest of the definitions that it was built from, None where it came from
    # elsewhere

    @property
    def missing(self) -> bool:
        """Whether it has to be built: it is not there, or was built here from other definitions."""
        return self.folder is None or (self.built is not None and self.built != digest(self.name))

    @property
    def origin(self) -> str:
        """Where it comes from, in words."""
        if self.folder is None:
            return "not there"
        if self.built is None:
            return str(self.folder)
        return "built here, from other definitions" if self.missing else "built here"


def find_package(name: str) -> Package:
    """Return what this environment has of a package, without importing it."""
    invalidate_caches()
    spec = find_spec(name)
    folder = Path(spec.origin).parent if spec and spec.origin else None
    file = digest_file(name)
    return Package(name, folder, file.read_text() if folder and file.is_file() else None)


def choose(names: tuple[str, ...]) -> list[Package]:
    """Return the packages of these names, all where there are none.

    Raises:
        SceneError: there is no such package.
    """
    for name in names:
        if name not in USES:
            raise SceneError(
                f"package {name}: unknown{did_you_mean(name, list(USES))} (known: "
                f"{', '.join(USES)})"
            )
    return [find_package(name) for name in names or USES]


def source_folder(name: str) -> Path:
    """Return the folder of a package's definitions, in the source tree."""
    return config_folder().parent / "interfaces" / name


def digest_file(name: str) -> Path:
    """Return the file that says from which definitions a package was built here."""
    return Path(sys.prefix, "share", name, "crane_sim_definitions.sha256")


def digest(name: str) -> str:
    """Return the SHA-256 of a package's definitions, by name and content."""
    total = hashlib.sha256()
    for file in sorted(file for file in source_folder(name).rglob("*") if file.is_file()):
        total.update(
            f"{file.relative_to(source_folder(name))}\0".encode() + file.read_bytes() + b"\0"
        )
    return total.hexdigest()
