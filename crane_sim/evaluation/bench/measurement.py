"""What all measurements have in common: how rounds are summed up, and on which machine they were taken."""

import os
import platform
import statistics
from collections.abc import Mapping, Sequence
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

_PACKAGES = ("numpy", "numba", "scipy", "rclpy", "rerun-sdk", "rosbags")


def describe_spread(values: Sequence[float]) -> dict[str, Any]:
    """Return median, least and most of a measurement, and what every round gave."""
    return {"median": statistics.median(values), "least": min(values), "most": max(values), "rounds": list(values)}


def ratio(ours: Sequence[float], theirs: Sequence[float]) -> dict[str, Any]:
    """Return the spread of ours / theirs, round by round: what both had to bear in a round drops out."""
    return describe_spread([a / b for a, b in zip(ours, theirs, strict=True)])


def machine() -> dict[str, Any]:
    """Return what the numbers of a measurement depend on: processor, cores, memory, system, versions."""
    return {
        "processor": _processor(),
        "cores": os.cpu_count(),
        "memory_GB": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9, 1),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
        "versions": {name: found for name in _PACKAGES if (found := _version(name))},
    }


def in_words(machine: Mapping[str, Any]) -> str:
    """Return what `machine` found, as the pages of documentation say it."""
    numba = machine["versions"].get("numba", "?")
    on = f"{machine['processor']}, {machine['cores']} cores, {machine['system']}"
    return f"{on}, Python {machine['python']}, numba {numba}"


def _processor() -> str:
    """Return the processor as it calls itself; platform.processor() is empty on many systems."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        lines = []
    named = (line.partition(":")[2].strip() for line in lines if line.startswith("model name"))
    return next(named, platform.processor() or platform.machine())


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return ""
