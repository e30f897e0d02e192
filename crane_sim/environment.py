"""What surrounds a process: variables, limits and folders; which nodes get, what is unusual.

Nothing heavy is imported here: a command checks its memory before it imports what needs more.
"""

import os
import resource
import sys
import sysconfig
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import NamedTuple

_READ_BY_NODES = """
    AMENT_ FASTDDS_ FASTRTPS_ LD_ LTTNG_ PYTHON RCL_ RCUTILS_ RMW_ ROS_ SKIP_DEFAULT_XML _ROS_WHEELS_
""".split()  # noqa: E501
"""Beginnings of the names of variables that the loader, Python, ROS and Fast DDS read; others are
the user's own."""
_ADMITTED = """
    AMENT_PREFIX_PATH LD_LIBRARY_PATH PYTHONPATH
    PYTHONDONTWRITEBYTECODE PYTHONFAULTHANDLER PYTHONHASHSEED PYTHONNOUSERSITE PYTHONOPTIMIZE PYTHONPYCACHEPREFIX
    PYTHONUNBUFFERED PYTHONUTF8
    RCUTILS_COLORIZED_OUTPUT RCUTILS_CONSOLE_OUTPUT_FORMAT
    ROS_DISTRO ROS_HOME ROS_LOG_DIR ROS_PYTHON_CHECK_FIELDS ROS_PYTHON_VERSION ROS_VERSION
    ROS_SECURITY_ENABLE ROS_SECURITY_ENCLAVE_OVERRIDE ROS_SECURITY_KEYSTORE ROS_SECURITY_STRATEGY
""".split()  # noqa: E501
"""Which of them nodes get."""
_OWN = ("_ROS_WHEELS_BOOTSTRAP_COMPLETE",)  # set by a package at the start of Python
# variables that are unusual
_IN_EFFECT = ("CRANE_SIM_DDS", "CRANE_SIM_INTERPRETED", "PYTHONOPTIMIZE")
_MEMORY = 2 << 30  # bytes of address space; the largest kinds of scenes compile in these
# bytes in /dev/shm; the tracing library of ROS ends a process that finds no page there
_SHARED_MEMORY = 64 << 10


class Unusual(NamedTuple):
    """Something unusual: a variable, limit or folder, and what it is and does, in one line."""

    name: str
    description: str


def admitted(variables: Mapping[str, str]) -> dict[str, str]:
    """Return the variables that nodes get: those that they do not read, and those of a list."""
    return {name: value for name, value in variables.items() if not _is_kept_from_nodes(name)}


def _is_kept_from_nodes(name: str) -> bool:
    return name.startswith(tuple(_READ_BY_NODES)) and name not in _ADMITTED


def own_ros() -> dict[str, list[str]]:
    """Return the folders of the ROS beside this package by variable; none where there is none."""
    if not Path(sys.prefix, "lib", "librcl.so").exists():
        return {}
    packages = Path(sysconfig.get_path("purelib"))
    libraries = [Path(sys.prefix, "lib"), *sorted(packages.glob("ros_*.libs"))]
    return {
        "AMENT_PREFIX_PATH": [sys.prefix],
        "LD_LIBRARY_PATH": [str(folder) for folder in libraries],
        "PYTHONPATH": [str(packages)],
    }


def memory_shortage() -> str:
    """Return one line where the process may lack the memory that the simulator needs, or ""."""
    for limit, what, option in (
        (resource.RLIMIT_AS, "address space", "-v"),
        (resource.RLIMIT_DATA, "data", "-d"),
    ):
        size, _ = resource.getrlimit(limit)
        if size != resource.RLIM_INFINITY and size < _MEMORY:
            return (
                f"the {what} of a process is limited to {size >> 20} MiB (ulimit {option} "
                f"{size >> 10}), "
                f"{_MEMORY >> 20} MiB are needed"
            )
    return ""


def find_unusual() -> list[Unusual]:
    """Return what of the environment is unusual, and may be why a run does not start."""
    return [*_variables_in_effect(), *_other_ros(), *_limits()]


def describe_unusual() -> str:
    """Return a clause on what is unusual, for a line on a failed start; empty for nothing."""
    names = ", ".join(dict.fromkeys(unusual.name for unusual in find_unusual()))
    return f"; unusual here: {names} (crane doctor)" if names else ""


def find_kept_from_nodes() -> list[Unusual]:
    """Return the variables that are set and without effect on nodes."""
    kept = [
        (name, value) for name, value in sorted(os.environ.items()) if _is_kept_from_nodes(name)
    ]
    return [
        Unusual(name, f"is {_shorten(value)}, which nodes do not get")
        for name, value in kept
        if name not in _OWN
    ]


def _variables_in_effect() -> Iterator[Unusual]:
    for name, value in sorted(os.environ.items()):
        if name in _IN_EFFECT:
            yield Unusual(name, f"is {_shorten(value)}")


def _shorten(value: str) -> str:
    return (value or "empty") if len(value) <= 60 else value[:57] + "..."


def _other_ros() -> Iterator[Unusual]:
    marks = {"PYTHONPATH": "rclpy", "LD_LIBRARY_PATH": "librcl.so"}
    for variable, own in own_ros().items():
        for folder in filter(None, os.environ.get(variable, "").split(os.pathsep)):
            if (
                folder not in own
                and Path(folder, marks.get(variable, "share/ament_index")).exists()
            ):
                yield Unusual(
                    f"another ROS on {variable}", f"{folder}; nodes find that of {sys.prefix} first"
                )


def _limits() -> Iterator[Unusual]:
    if shortage := memory_shortage():
        yield Unusual("limited memory", shortage)
    try:
        status = os.statvfs("/dev/shm")
    except OSError:
        return
    if status.f_bavail * status.f_frsize < _SHARED_MEMORY and not status.f_flag & os.ST_RDONLY:
        yield Unusual(
            "a full /dev/shm",
            "nodes end with SIGBUS, since the tracing library of ROS needs a page there",
        )
