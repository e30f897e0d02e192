"""Pinocchio: a small C++ loop around its articulated-body algorithm, using installed headers.

Pinocchio has no integrators; the loop's methods take their tableaus from this simulator's. The
compiled loop is kept beside this simulator's compiled code.
"""

import ctypes
import hashlib
import os
import shutil
import subprocess
import tempfile
import weakref
from collections.abc import Callable, Iterator, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from crane_bench.speed.engine import EngineUnavailable, Run, RunResult
from crane_bench.speed.peers.joints import (
    Joint,
    model_joints,
    payload_position,
    step_sizes,
    tension,
)
from crane_bench.speed.problem import Problem
from crane_sim.integrators import dop853, rk4
from crane_sim.integrators.runge_kutta import to_dense_tableau
from crane_sim.tracing.cache import cache_folder

Array = npt.NDArray[np.float64]
SOURCE = Path(__file__).with_name("pinocchio_loop.cpp")
FLAGS = (
    "-std=c++17 -O3 -march=native -DNDEBUG -shared -fPIC "
    # as Pinocchio's own builds set them
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30 -DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS"
).split()
SWEEPS = {4: (2.7, 0.01), 8: (6.0, 0.03)}
"""The first and last step by order, in units of 1 / highest frequency."""
_POINTER, _REAL, _LONG = ctypes.c_void_p, ctypes.c_double, ctypes.c_long


class Pinocchio:
    """The engine: models every Problem class; `unsupported_scenes` are left out."""

    name = "Pinocchio"
    unsupported_scenes: ClassVar[dict[str, str]] = {
        "overhead_spatial": "a link in space takes two angles, singular where it lies along the "
        "first axis: a ball "
        "joint would spin without inertia, which stops the algorithm",
        "overhead_hoist": "no joint follows a prescribed length: no algorithm takes efforts here, "
        "accelerations there",
        "overhead_coulomb": "no friction and no events: sticking and slipping would be written "
        "around the algorithm",
    }

    def __init__(self) -> None:
        """Find headers and compiler, and compile the loop.

        Raises:
            EngineUnavailable: one of them is missing, or the compiler does not accept the loop.
        """
        include = _headers()
        self.version = _version(include)
        self._library = ctypes.CDLL(str(_compile_loop(include)))
        self._library.crane_new.argtypes, self._library.crane_new.restype = (
            [_POINTER, ctypes.c_int, _REAL],
            _POINTER,
        )
        self._library.crane_delete.argtypes, self._library.crane_delete.restype = [_POINTER], None
        arguments = [_POINTER, ctypes.c_int, _POINTER, _REAL, _LONG, _LONG, _POINTER]
        self._library.crane_pass.argtypes, self._library.crane_pass.restype = arguments, None

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps of steps with the orders 4 and 8."""
        crane = _Crane(self._library, model_joints(problem), problem.gravity)
        settings = [
            (order, step) for order, sweep in SWEEPS.items() for step in step_sizes(problem, *sweep)
        ]
        return [
            Run(
                self.name,
                f"aba, rk{order}",
                step,
                crane.make_run(order, step, round(problem.duration / step)),
            )
            for order, step in settings
        ]


class _Crane:
    """A crane in the C++ library."""

    def __init__(self, library: ctypes.CDLL, joints: list[Joint], gravity: float) -> None:
        self.joints, self._pass = joints, library.crane_pass
        self.start, self.end = np.array([joint.initial for joint in joints]), np.empty(len(joints))
        numbers = pack_joints(joints)  # kept alive through the call by its name
        self.crane = library.crane_new(numbers.ctypes.data, len(joints), gravity)
        weakref.finalize(self, library.crane_delete, self.crane)

    def make_run(self, order: int, step: float, count: int) -> Callable[[int], RunResult]:
        """Return a function that integrates the duration in `count` steps."""
        stages = len({4: rk4, 8: dop853}[order].B)

        def execute(repetitions: int) -> RunResult:
            start, end = self.start.ctypes.data, self.end.ctypes.data
            self._pass(self.crane, order, start, step, count, repetitions, end)
            return RunResult(
                payload_position(self.joints, self.end),
                stages * count,
                count,
                tension(self.joints, self.end),
            )

        return execute


def pack_joints(joints: Sequence[Joint]) -> Array:
    """Return the joints (n, 14) as the C++ struct of that name."""
    numbers = (
        (j.prismatic, j.axis, *j.offset, j.mass, *j.com, *j.inertia, *(j.spring or (0.0, 0.0)))
        for j in joints
    )
    return np.array(list(numbers), float)


def tableaus() -> str:
    """Return the header with the methods' coefficients."""
    text = "#pragma once\n"
    for method in (rk4, dop853):
        a, b = to_dense_tableau(method.A).tolist(), [weight or 0.0 for weight in method.B]
        rows = ", ".join(_format_braces(row) for row in a)
        n = len(b)
        text += f"struct Order{method.ORDER} {{\n    static constexpr int stages = {n};\n"
        text += f"    static constexpr double a[{n}][{n}] = {{{rows}}}, "
        text += f"b[{n}] = {_format_braces(b)};\n}};\n"
    return text


def _format_braces(numbers: Sequence[float]) -> str:
    return "{" + ", ".join(map(repr, numbers)) + "}"


def _parents(package: str) -> Iterator[Path]:
    """Yield the folders around an installed package, from the inside out."""
    spec = find_spec(package)
    if spec and spec.origin:
        yield from Path(spec.origin).parents


def _headers() -> list[Path]:
    """Return the include folders of Pinocchio with Boost, and of Eigen."""
    candidates = [folder / "include" for folder in _parents("pinocchio")]
    include_folder = next(
        (folder for folder in candidates if (folder / "pinocchio").is_dir()), None
    )
    if include_folder is None:
        raise EngineUnavailable("pinocchio is not installed, or without its C++ headers")
    if not (include_folder / "boost").is_dir():
        raise EngineUnavailable(
            f"pinocchio's headers need Boost's, which are not in {include_folder}"
        )
    others = [folder / "include" for folder in _parents("casadi")]
    folders = [folder / "eigen3" for folder in (include_folder, *others, Path("/usr/include"))]
    eigen = next((folder for folder in folders if (folder / "Eigen/Core").is_file()), None)
    if eigen is None:
        raise EngineUnavailable(
            "pinocchio's headers need Eigen's, which are neither beside them nor in casadi nor in "
            "/usr/include"
        )
    return [include_folder, eigen]


def _version(include: list[Path]) -> str:
    lines = (include[0] / "pinocchio/config.hpp").read_text().splitlines()
    return next(
        (line.split('"')[1] for line in lines if "define PINOCCHIO_VERSION " in line), "unknown"
    )


def _compile_loop(include: list[Path]) -> Path:
    """Return the compiled loop; its name is a hash of all that it is compiled from."""
    compiler = shutil.which("g++") or shutil.which("clang++")
    if compiler is None:
        raise EngineUnavailable("pinocchio's loop needs a C++ compiler (g++ or clang++)")
    command, header = [compiler, *FLAGS, *(f"-I{folder}" for folder in include)], tableaus()
    # the predefined macros identify the compiler's version and the processor's features
    predefined = subprocess.run(
        [*command, "-dM", "-E", "-x", "c++", os.devnull], capture_output=True, check=False
    ).stdout
    hash_input = (
        f"{command} {_version(include)} {header}".encode() + predefined + SOURCE.read_bytes()
    )
    target = cache_folder() / f"pinocchio_{hashlib.sha256(hash_input).hexdigest()[:16]}.so"
    if not target.exists():
        target.parent.mkdir(parents=True, exist_ok=True)
        _compile(command, header, target)
    return target


def _compile(command: list[str], header: str, target: Path) -> None:
    with tempfile.TemporaryDirectory(
        dir=target.parent
    ) as folder:  # beside the target: it is moved into place whole
        (compiled := Path(folder, "loop.so")).with_name("tableaus.h").write_text(header)
        result = subprocess.run(
            [*command, f"-I{folder}", str(SOURCE), "-o", str(compiled)],
            capture_output=True,
            text=True,
            check=False,
        )
        if result.returncode != 0:
            why = next(
                (line for line in result.stderr.splitlines() if " error: " in line),
                "it does not say why",
            )
            raise EngineUnavailable(f"{command[0]} does not compile {SOURCE.name}: {why}")
        compiled.replace(target)
