"""Common parts of all measurements: statistics of rounds, and the machine."""

import os
import platform
import statistics
import time
from collections.abc import Mapping, Sequence
from typing import Any

from crane_sim.recording.provenance import processor, versions_of

_ADDITIONS = 20_000  # of a measurement of the processor's speed, about a millisecond
_PACKAGES = ("numpy", "llvmlite", "scipy", "rclpy", "rerun-sdk", "rosbags")


def describe_spread(values: Sequence[float]) -> dict[str, Any]:
    """Return median, least and most of a measurement, and the value of every round."""
    return {
        "median": statistics.median(values),
        "least": min(values),
        "most": max(values),
        "rounds": list(values),
    }


def ratio(numerators: Sequence[float], denominators: Sequence[float]) -> dict[str, Any]:
    """Return the spread of ratios, round by round: common disturbances of a round cancel."""
    return describe_spread([a / b for a, b in zip(numerators, denominators, strict=True)])


def measure_processor_speed() -> float:
    """Return additions per second of this thread's processor time.

    What other processes take does not count.
    """
    start, total = time.thread_time(), 0
    for i in range(_ADDITIONS):
        total += i
    return _ADDITIONS / (time.thread_time() - start)


def machine() -> dict[str, Any]:
    """Return the conditions of a measurement: processor, cores, memory, system, versions."""
    return {
        "processor": processor(),
        "cores": os.cpu_count(),
        "memory_GB": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 1e9, 1),
        "system": f"{platform.system()} {platform.release()} {platform.machine()}",
        "python": platform.python_version(),
        "versions": versions_of(_PACKAGES),
    }


def describe_machine(machine: Mapping[str, Any]) -> str:
    """Return the result of `machine` in the words of the documentation."""
    conditions = f"{machine['processor']}, {machine['cores']} cores, {machine['system']}"
    return ", ".join(
        (conditions, f"Python {machine['python']}", *map(" ".join, machine["versions"].items()))
    )
