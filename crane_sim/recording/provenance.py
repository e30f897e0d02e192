"""Provenance of a run: package versions, the processor, the hash of the locked packages."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Iterable
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

from crane_sim.files.catalogue import config_folder

PACKAGES = ("crane_sim", "numpy", "scipy", "llvmlite", "pydantic", "rerun-sdk", "rclpy")
_CPU = Path("/proc/cpuinfo")


def of_this_process() -> dict[str, str]:
    """Return versions by package, `python`, `system`, `cpu`, and the lock file's `lock_sha256`."""
    return {"python": platform.python_version()} | versions_of(PACKAGES) | _machine() | _lock_hash()


def versions_of(packages: Iterable[str]) -> dict[str, str]:
    """Return the versions of those packages that are installed."""
    found = {}
    for name in packages:
        with suppress(PackageNotFoundError):
            found[name] = version(name)
    return found


def processor() -> str:
    """Return the processor's own name; platform.processor() is empty on many systems."""
    lines = _CPU.read_text().splitlines() if _CPU.is_file() else []
    models = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(models, platform.processor() or platform.machine())


def _machine() -> dict[str, str]:
    return {"system": f"{platform.system()} {platform.machine()}", "cpu": processor()}


def _lock_hash() -> dict[str, str]:
    """Return the hash of the tree's lock file; an installed package has none."""
    file = config_folder().parent / Path("requirements", "run.lock")
    return {"lock_sha256": hashlib.sha256(file.read_bytes()).hexdigest()} if file.is_file() else {}
