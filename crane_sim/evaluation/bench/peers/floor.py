"""The floor: the benchmark's cranes written by hand in C, as fast as we can make them."""

import tempfile
from pathlib import Path

import numpy as np
import numpy.typing as npt

from crane_sim.evaluation.bench.compiler import FLOOR, Compiler
from crane_sim.evaluation.bench.engine import Run
from crane_sim.evaluation.bench.loops import Form, Loops
from crane_sim.evaluation.bench.problem import Chain, KnuckleCrane, Problem, Spring

Array = npt.NDArray[np.float64]
PLAIN, ALL = ("rk4", "rk8"), ("leapfrog", "rk4", "rk8")


class Floor:
    """Hand-written C, compiled in a temporary folder."""

    name = "hand C"

    def __init__(self) -> None:
        """Find the compiler.

        Raises:
            Missing: there is none.
        """
        self._folder = tempfile.TemporaryDirectory()
        self._compiler = Compiler(Path(self._folder.name))
        self.version = f"{self._compiler.version}, -O3, -march=native where it is faster"

    def refuses(self, problem: Problem) -> str | None:
        """Refuse nothing."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps of the fixed-step methods and of the adaptive one."""
        return Loops(self._compiler, form_of(problem)).runs(self.name)


def form_of(problem: Problem) -> Form:
    """Return the problem as its C file wants it."""
    if isinstance(problem, Spring):
        return _spring(problem)
    if isinstance(problem, KnuckleCrane):
        return _knuckle(problem)
    return _single(problem) if len(problem.masses) == 1 else _chain(problem)


def _single(p: Chain) -> Form:
    mass, length, angle = p.masses[0], p.lengths[0], p.angles[0]
    pace = float(np.sqrt(p.gravity / length * (1.0 + mass / p.trolley)))
    numbers = np.array([1.0 / p.trolley, 1.0 / mass, length, p.gravity, 1.0 / length])

    def outcome(x: Array) -> tuple[Array, None]:
        return np.array([x[0] + length * np.sin(x[1]), 0.0, -length * np.cos(x[1])]), None

    start = np.array([0.0, angle, 0.0, 0.0])
    return Form(FLOOR / "single.c", numbers, start, outcome, pace, p.duration, PLAIN)


def _chain(p: Chain) -> Form:
    n, m, lengths = len(p.masses), p.masses, p.lengths
    wide = (n + 8) // 8 * 8
    scale = np.array([np.sqrt(m[0]), *(1.0 / np.sqrt(1.0 / m[:-1] + 1.0 / m[1:]))])  # diagonal of the system: 1
    rows, x = np.zeros((4, wide)), np.zeros(2 * wide)
    rows[0, 1:n] = scale[:-1] * scale[1:] / m[:-1]
    rows[1, :n] = lengths * scale
    rows[2, : n - 1] = scale[1:] / (m[:-1] * lengths[:-1])
    rows[3, 1:n] = scale[:-1] / (m[:-1] * lengths[1:])
    top = [m[0] / p.trolley, p.gravity * scale[0], p.gravity / lengths[0], scale[0] / p.trolley, 1.0 / lengths[0]]
    x[:n] = np.diff(p.angles, prepend=0.0)
    pace = 2.0 * float(np.sqrt(np.sum(m) * p.gravity / np.min(m * lengths)))

    def outcome(x: Array) -> tuple[Array, None]:
        angles = np.cumsum(x[:n])
        return np.array([x[n] + lengths @ np.sin(angles), 0.0, -(lengths @ np.cos(angles))]), None

    numbers = np.array([*rows.ravel(), *top])
    return Form(FLOOR / "chain.c", numbers, x, outcome, pace, p.duration, ALL, (f"-DLINKS={n}",))


def _spring(p: Spring) -> Form:
    numbers = np.array([1.0 / p.trolley, 1.0 / p.payload, p.stiffness, p.length, p.gravity])
    pace = float(np.sqrt(p.stiffness * (1.0 / p.trolley + 1.0 / p.payload)))

    def outcome(x: Array) -> tuple[Array, float]:
        stretch = float(np.hypot(x[1] - x[0], x[2])) - p.length
        return np.array([x[1], 0.0, x[2]]), p.stiffness * stretch

    start = np.array([0.0, *p.start, 0.0, 0.0, 0.0])
    return Form(FLOOR / "spring.c", numbers, start, outcome, pace, p.duration, ALL)


def _knuckle(p: KnuckleCrane) -> Form:
    boom, jib, g = p.boom, p.jib, p.gravity
    k1, k2 = boom.length**2 * (0.25 * boom.mass + jib.mass), 0.25 * jib.length**2 * jib.mass
    numbers = [boom.length, jib.length, p.tower + boom.axial + jib.axial, 1.0 / p.payload, g]
    numbers += [k1, k2, 0.5 * boom.length * jib.length * jib.mass, boom.inertia + k1, jib.inertia + k2]
    numbers += [boom.inertia - boom.axial, jib.inertia - jib.axial]
    numbers += [g * boom.length * (0.5 * boom.mass + jib.mass), 0.5 * g * jib.length * jib.mass]
    pace = float(np.sqrt(p.stiffness[2] / p.payload))

    def outcome(x: Array) -> tuple[Array, None]:
        s, c = np.sin(x[0]), np.cos(x[0])
        return np.array([c * x[3] - s * x[4], s * x[3] + c * x[4], x[5]]), None

    s, c = np.sin(p.q[0]), np.cos(p.q[0])
    turned = [c * p.start[0] + s * p.start[1], c * p.start[1] - s * p.start[0], p.start[2]]
    state = np.array([*p.q, *turned, *np.zeros(6)])
    parameters = np.array([*numbers, *p.stiffness, *p.rest])
    return Form(FLOOR / "knuckle.c", parameters, state, outcome, pace, p.duration, PLAIN)
