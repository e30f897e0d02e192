"""Hand-written C of the benchmark's cranes, as fast as possible: the baseline of all engines."""

import tempfile
from pathlib import Path
from typing import ClassVar

import numpy as np
import numpy.typing as npt

from crane_bench.speed.compiler import C_SOURCES, Compiler
from crane_bench.speed.engine import Run
from crane_bench.speed.loops import CLoopInput, Loops
from crane_bench.speed.problem import Chain, KnuckleCrane, Problem, Spring

Array = npt.NDArray[np.float64]
PLAIN, ALL = ("rk4", "rk8"), ("leapfrog", "rk4", "rk8")


class HandC:
    """Hand-written C, compiled in a temporary folder."""

    name = "hand C"
    unsupported_scenes: ClassVar[dict[str, str]] = {}

    def __init__(self) -> None:
        """Find the compiler.

        Raises:
            EngineUnavailable: there is none.
        """
        self._folder = tempfile.TemporaryDirectory()
        self._compiler = Compiler(Path(self._folder.name))
        self.version = f"{self._compiler.version}, -O3, -march=native where it is faster"

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps of the fixed-step methods and of the adaptive one."""
        return Loops(self._compiler, c_loop_input(problem)).runs(self.name)


def c_loop_input(problem: Problem) -> CLoopInput:
    """Return the problem as the input of its C loop."""
    if isinstance(problem, Spring):
        return _spring(problem)
    if isinstance(problem, KnuckleCrane):
        return _knuckle(problem)
    return _single(problem) if len(problem.masses) == 1 else _chain(problem)


def _single(p: Chain) -> CLoopInput:
    mass, length, angle = p.masses[0], p.lengths[0], p.angles[0]
    max_frequency = float(np.sqrt(p.gravity / length * (1.0 + mass / p.trolley)))
    parameters = np.array([1.0 / p.trolley, 1.0 / mass, length, p.gravity, 1.0 / length])

    def outputs(x: Array) -> tuple[Array, None]:
        return np.array([x[0] + length * np.sin(x[1]), 0.0, -length * np.cos(x[1])]), None

    start = np.array([0.0, angle, 0.0, 0.0])
    return CLoopInput(
        C_SOURCES / "single.c", parameters, start, outputs, max_frequency, p.duration, PLAIN
    )


def _chain(p: Chain) -> CLoopInput:
    n, m, lengths = len(p.masses), p.masses, p.lengths
    padded = (n + 8) // 8 * 8
    x = np.zeros(2 * padded)
    x[:n] = np.diff(p.angles, prepend=0.0)
    max_frequency = 2.0 * float(np.sqrt(np.sum(m) * p.gravity / np.min(m * lengths)))

    def outputs(x: Array) -> tuple[Array, None]:
        angles = np.cumsum(x[:n])
        return np.array([x[n] + lengths @ np.sin(angles), 0.0, -(lengths @ np.cos(angles))]), None

    parameters, links = _chain_parameters(p, padded), (f"-DLINKS={n}",)
    return CLoopInput(
        C_SOURCES / "chain.c", parameters, x, outputs, max_frequency, p.duration, ALL, links
    )


def _chain_parameters(p: Chain, padded: int) -> Array:
    """Return the parameters of chain.c, its rows of `padded` numbers."""
    n, m, lengths, g = len(p.masses), p.masses, p.lengths, p.gravity
    # diagonal of the system: 1
    scale = np.array([np.sqrt(m[0]), *(1.0 / np.sqrt(1.0 / m[:-1] + 1.0 / m[1:]))])
    rows = np.zeros((4, padded))
    rows[0, 1:n] = scale[:-1] * scale[1:] / m[:-1]
    rows[1, :n] = lengths * scale
    rows[2, : n - 1] = scale[1:] / (m[:-1] * lengths[:-1])
    rows[3, 1:n] = scale[:-1] / (m[:-1] * lengths[1:])
    top = [m[0] / p.trolley, g * scale[0], g / lengths[0], scale[0] / p.trolley, 1.0 / lengths[0]]
    return np.array([*rows.ravel(), *top])


def _spring(p: Spring) -> CLoopInput:
    parameters = np.array([1.0 / p.trolley, 1.0 / p.payload, p.stiffness, p.length, p.gravity])
    max_frequency = float(np.sqrt(p.stiffness * (1.0 / p.trolley + 1.0 / p.payload)))

    def outputs(x: Array) -> tuple[Array, float]:
        stretch = float(np.hypot(x[1] - x[0], x[2])) - p.length
        return np.array([x[1], 0.0, x[2]]), p.stiffness * stretch

    start = np.array([0.0, *p.start, 0.0, 0.0, 0.0])
    return CLoopInput(
        C_SOURCES / "spring.c", parameters, start, outputs, max_frequency, p.duration, ALL
    )


def _knuckle(p: KnuckleCrane) -> CLoopInput:
    boom, jib, g = p.boom, p.jib, p.gravity
    k1, k2 = boom.length**2 * (0.25 * boom.mass + jib.mass), 0.25 * jib.length**2 * jib.mass
    parameters = [boom.length, jib.length, p.tower + boom.axial + jib.axial, 1.0 / p.payload, g]
    coupling = 0.5 * boom.length * jib.length * jib.mass
    parameters += [k1, k2, coupling, boom.inertia + k1, jib.inertia + k2]
    parameters += [boom.inertia - boom.axial, jib.inertia - jib.axial]
    parameters += [g * boom.length * (0.5 * boom.mass + jib.mass), 0.5 * g * jib.length * jib.mass]
    max_frequency = float(np.sqrt(p.stiffness[2] / p.payload))

    def outputs(x: Array) -> tuple[Array, None]:
        s, c = np.sin(x[0]), np.cos(x[0])
        return np.array([c * x[3] - s * x[4], s * x[3] + c * x[4], x[5]]), None

    s, c = np.sin(p.q[0]), np.cos(p.q[0])
    x, y, z = p.start
    in_slewing_frame = [c * x + s * y, c * y - s * x, z]
    state = np.array([*p.q, *in_slewing_frame, *np.zeros(6)])
    parameters += [*p.stiffness, *p.neutral]
    constants = np.array(parameters)
    return CLoopInput(
        C_SOURCES / "knuckle.c", constants, state, outputs, max_frequency, p.duration, PLAIN
    )
