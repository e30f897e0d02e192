"""Builds a message package with CMake, and installs it as ROS 2's wheels do theirs."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Callable
from pathlib import Path

from crane_sim.interfaces import toolchain
from crane_sim.interfaces.packages import digest, digest_file, source_folder

_STEP = re.compile(rb"\[(\d+)/(\d+)\]")


def build(name: str, on_progress: Callable[[int, int], None]) -> None:
    """Build a package and install it; `on_progress` is given finished and all steps.

    What an interrupted build has finished is used again. The package becomes importable last, and
    at once.

    Raises:
        RuntimeError: it could not be built; the message is one line.
    """
    folder, staged = toolchain.FOLDER / name, toolchain.FOLDER / f"{name}-installed"
    shutil.rmtree(staged, ignore_errors=True)
    toolchain.log_run(_configuration(name, folder), f"the build files of {name}")
    _compile(name, folder, on_progress)
    toolchain.log_run(
        [toolchain.tool("cmake"), "--install", str(folder)], name, DESTDIR=str(staged)
    )
    _install(staged.joinpath(*Path(sys.prefix).parts[1:]), name)


def _configuration(name: str, folder: Path) -> list[str]:
    settings = {
        "CMAKE_INSTALL_PREFIX": sys.prefix,
        # libraries, and from the Python package to them
        "CMAKE_INSTALL_RPATH": "$ORIGIN;$ORIGIN/../../..",
        "BUILD_TESTING": "OFF",
        "CMAKE_PROJECT_INCLUDE": str(source_folder(name).parent / "python_only.cmake"),
        "Python3_EXECUTABLE": toolchain.tool("python"),
    }
    options = [f"-D{key}={value}" for key, value in settings.items()]
    return [
        toolchain.tool("cmake"),
        "-GNinja",
        "-S",
        str(source_folder(name)),
        "-B",
        str(folder),
        *options,
    ]


def _compile(name: str, folder: Path, on_progress: Callable[[int, int], None]) -> None:
    command = [toolchain.tool("ninja"), "-C", str(folder), "-j", str(os.cpu_count() or 1)]
    with toolchain.LOG.open("ab") as log:
        environment = toolchain.environment()
        with subprocess.Popen(
            command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT
        ) as ninja:
            assert ninja.stdout is not None
            for line in ninja.stdout:
                log.write(line)
                if step := _STEP.match(line):
                    on_progress(int(step[1]), int(step[2]))
    if ninja.returncode:
        raise toolchain.failure(name)


def _install(staged: Path, name: str) -> None:
    """Move the files of a package into the environment, its Python module last.

    Once that is there, all is.
    """
    module = Path(sysconfig.get_path("purelib"), name)
    shutil.rmtree(module, ignore_errors=True)
    waiting = toolchain.FOLDER / f"{name}-module"
    shutil.rmtree(waiting, ignore_errors=True)
    (staged / module.relative_to(sys.prefix)).rename(waiting)
    shutil.copytree(staged, sys.prefix, dirs_exist_ok=True, copy_function=_replace)
    digest_file(name).write_text(digest(name))
    waiting.rename(module)


def _replace(source: str, target: str) -> None:
    os.replace(source, target)  # not in place: an older file may be linked from elsewhere
