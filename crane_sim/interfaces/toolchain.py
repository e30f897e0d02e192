"""The generators of message packages: PyPI wheels in a temporary environment of their own."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

from crane_sim.files.catalogue import config_folder

FOLDER = Path(sys.prefix, "interfaces-build")
LOG = FOLDER / "build.log"
_TOOLS = FOLDER / "tools"
_INCLUDES = re.compile(r'"/[^"]*/include/python3[^"]*"')


def check_machine() -> None:
    """Check that this machine can build packages.

    Raises:
        RuntimeError: something is missing; the message says what in one line.
    """
    if sys.prefix == sys.base_prefix:
        raise RuntimeError(
            f"{sys.prefix} is no virtual environment: install the packages with apt or colcon"
        )
    if not (config_folder().parent / "interfaces").is_dir():
        raise RuntimeError(
            f"{config_folder().parent}: has no definitions of messages; run this in the source tree"
        )
    if not Path(sysconfig.get_path("include"), "Python.h").is_file():
        raise RuntimeError(
            "no headers of Python found; install them (Debian, Ubuntu: apt install python3-dev)"
        )
    for variable, command in (("CC", "cc"), ("CXX", "c++")):
        compiler = os.environ.get(variable, command)
        if shutil.which(compiler.split()[0]) is None:
            raise RuntimeError(
                f"no compiler {compiler} found; install one (Debian, Ubuntu: apt install g++)"
            )


def make_tools() -> None:
    """Make the environment of the generators, unless an earlier build left it complete.

    Raises:
        RuntimeError: the wheels could not be installed; the message is one line.
    """
    lock = config_folder().parent / Path("requirements", "interfaces.lock")
    complete = _TOOLS / "crane.stamp"
    if complete.is_file() and complete.read_text() == lock.read_text():
        return
    shutil.rmtree(_TOOLS, ignore_errors=True)
    log_run(
        [sys.executable, "-m", "venv", "--without-pip", str(_TOOLS)],
        "the environment of the generators",
    )
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--disable-pip-version-check",
        "--python",
        str(_TOOLS / "bin" / "python"),
    ]
    log_run(
        [*pip, "install", "--no-deps", "--require-hashes", "-r", str(lock)],
        "the wheels of requirements/interfaces.lock; is the network there?",
    )
    _correct_includes()
    complete.write_text(lock.read_text())


def _correct_includes() -> None:
    """Name this Python's headers where the wheels name those of the machine that built them."""
    numpy = next(_TOOLS.glob("lib/python3*/site-packages/numpy/_core/include"))
    includes = f'"{sysconfig.get_path("include")};{numpy}"'
    for file in _TOOLS.glob("share/*/cmake/*rosidl_generator_pyExport.cmake"):
        file.write_text(_INCLUDES.sub(includes, file.read_text()))


def environment() -> dict[str, str]:
    """Return the environment of the generators' programs."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "PYTHONHOME", "_ROS_WHEELS_BOOTSTRAP_COMPLETE", "DESTDIR")
    }
    return kept | {
        "AMENT_PREFIX_PATH": str(_TOOLS),
        "CMAKE_PREFIX_PATH": str(_TOOLS),
        "LD_LIBRARY_PATH": str(_TOOLS / "lib"),
        "PATH": os.pathsep.join((str(_TOOLS / "bin"), os.environ.get("PATH", os.defpath))),
    }


def tool(name: str) -> str:
    """Return the path of one of the generators' programs."""
    return str(_TOOLS / "bin" / name)


def log_run(command: list[str], what: str, **variables: str) -> None:
    """Run a program of the build; what it says goes into the log.

    Raises:
        RuntimeError: it failed; the message says in one line that `what` could not be made.
    """
    LOG.parent.mkdir(parents=True, exist_ok=True)
    with LOG.open("a") as log:
        code = subprocess.run(
            command, env=environment() | variables, stdout=log, stderr=log, check=False
        ).returncode
    if code:
        raise failure(what)


def failure(what: str) -> RuntimeError:
    """Return the error of a build that failed, one line."""
    return RuntimeError(f"could not be made: {what} (all that was said: {LOG})")
