"""CasADi: the equations derived symbolically, written to C by CasADi, and integrated by the same loops as the floor's.

Coordinates are absolute angles, and the payload's Cartesian ones where it hangs on a spring. CasADi differentiates the
energies and solves with the mass matrix symbolically; chains are also written with their tridiagonal system of
tensions, and whichever runs faster is kept.
"""

import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.evaluation.bench.compiler import FLOOR, Compiler
from crane_sim.evaluation.bench.engine import Missing, Run
from crane_sim.evaluation.bench.loops import Form, Loops, Reading
from crane_sim.evaluation.bench.peers.floor import form_of
from crane_sim.evaluation.bench.problem import Boom, Chain, KnuckleCrane, Problem, Spring

Array = npt.NDArray[np.float64]
DENSE = 20  # links, up to which the mass matrix is solved symbolically: the code grows with their square


class Model(NamedTuple):
    """Symbolic equations of motion."""

    q: Any
    v: Any
    acceleration: Any
    start: Array  # of q; at rest
    outcome: Reading


class CasadiC:
    """CasADi with its generated C."""

    name = "CasADi C"

    def __init__(self) -> None:
        """Import CasADi and find a compiler.

        Raises:
            Missing: one of them is not there.
        """
        try:
            self._ca: Any = import_module("casadi")
        except ImportError:
            raise Missing("casadi is not installed") from None
        self._folder = tempfile.TemporaryDirectory()
        self._compiler = Compiler(Path(self._folder.name))
        self.version = f"{self._ca.__version__}, {self._compiler.version}"

    def refuses(self, problem: Problem) -> str | None:
        """Refuse nothing."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps with the fastest formulation."""
        loops = [self._loops(model, form_of(problem)) for model in self._models(problem)]
        return min(loops, key=lambda made: made.seconds).runs(self.name)

    def _models(self, problem: Problem) -> list[Model]:
        if isinstance(problem, Spring):
            return [self._spring(problem)]
        if isinstance(problem, KnuckleCrane):
            return [self._knuckle(problem)]
        tensions = [self._tensions(problem)]
        return [self._angles(problem), *tensions] if len(problem.masses) <= DENSE else tensions

    def _loops(self, model: Model, floor: Form) -> Loops:
        """Write the C and compile the loops around it; `floor` tells the pace and the time to pass."""
        x = self._ca.vertcat(model.q, model.v)
        rhs = self._ca.Function("rhs", [x], [self._ca.vertcat(model.v, model.acceleration)], {"cse": True})
        written = self._ca.CodeGenerator("casadi_rhs.c")
        written.add(rhs)
        (self._compiler.folder / "casadi_rhs.h").write_text(written.dump())
        state = np.concatenate([model.start, np.zeros_like(model.start)])
        methods, define = ("rk4", "rk8"), (f"-DSIZE={len(state)}",)
        source = FLOOR / "casadi.c"
        form = Form(source, np.zeros(1), state, model.outcome, floor.pace, floor.duration, methods, define)
        return Loops(self._compiler, form)

    def _lagrange(self, kinetic: Any, potential: Any, q: Any, v: Any) -> Any:
        """Return the accelerations of a conservative system."""
        ca, momentum = self._ca, self._ca.gradient(kinetic, v)
        force = ca.gradient(kinetic - potential, q) - ca.jtimes(momentum, q, v)
        return ca.ldl_solve(force, *ca.ldl(ca.jacobian(momentum, v)))

    def _hanging(self, p: Chain) -> tuple[Any, Any, Array, Reading]:
        """Return coordinates, rates, their start and where the payload is; trolley first, then angles."""
        n = len(p.masses)

        def outcome(x: Array) -> tuple[Array, None]:
            angles = x[1 : n + 1]
            return np.array([x[0] + p.lengths @ np.sin(angles), 0.0, -(p.lengths @ np.cos(angles))]), None

        return self._ca.SX.sym("q", n + 1), self._ca.SX.sym("v", n + 1), np.array([0.0, *p.angles]), outcome

    def _angles(self, p: Chain) -> Model:
        ca, (q, v, start, outcome) = self._ca, self._hanging(p)
        x, z = q[0], 0.0
        kinetic, potential = 0.5 * p.trolley * v[0] ** 2, 0.0
        for k, (mass, length) in enumerate(zip(p.masses, p.lengths, strict=True), 1):
            x, z = x + length * ca.sin(q[k]), z - length * ca.cos(q[k])
            kinetic += 0.5 * mass * (ca.jtimes(x, q, v) ** 2 + ca.jtimes(z, q, v) ** 2)
            potential += mass * p.gravity * z
        return Model(q, v, self._lagrange(kinetic, potential, q, v), start, outcome)

    def _tensions(self, p: Chain) -> Model:
        """Return the chain by its tensions: tridiagonal, as the links stay rigid."""
        ca, (q, v, start, outcome) = self._ca, self._hanging(p)
        n, s, c, give = len(p.masses), ca.sin(q[1:]), ca.cos(q[1:]), 1.0 / p.masses
        bends = [(c[k] * c[k + 1] + s[k] * s[k + 1], c[k] * s[k + 1] - s[k] * c[k + 1]) for k in range(n - 1)]
        pivot = [give[0] + s[0] ** 2 / p.trolley, *(give[:-1] + give[1:])]
        t = [p.lengths[k] * v[k + 1] ** 2 for k in range(n)]
        t[0] += p.gravity * c[0]
        for k in range(1, n):
            ratio = bends[k - 1][0] * give[k - 1] / pivot[k - 1]
            pivot[k] -= ratio * bends[k - 1][0] * give[k - 1]
            t[k] += ratio * t[k - 1]
        t[-1] /= pivot[-1]
        for k in range(n - 2, -1, -1):
            t[k] = (t[k] + bends[k][0] * give[k] * t[k + 1]) / pivot[k]
        pushed = t[0] * s[0] / p.trolley
        turning = [0.0 for _ in range(n)]
        turning[0] = -p.gravity * s[0] - c[0] * pushed
        for k in range(n - 1):
            turning[k] += bends[k][1] * t[k + 1] * give[k]
            turning[k + 1] -= bends[k][1] * t[k] * give[k]
        turning = [a / length for a, length in zip(turning, p.lengths, strict=True)]
        return Model(q, v, ca.vertcat(pushed, *turning), start, outcome)

    def _spring(self, p: Spring) -> Model:
        """Return the spring's crane: trolley, payload x and z."""
        ca = self._ca
        q, v = ca.SX.sym("q", 3), ca.SX.sym("v", 3)
        rope = ca.norm_2(ca.vertcat(q[1] - q[0], q[2]))
        kinetic = 0.5 * (p.trolley * v[0] ** 2 + p.payload * (v[1] ** 2 + v[2] ** 2))
        potential = p.payload * p.gravity * q[2] + 0.5 * p.stiffness * (rope - p.length) ** 2

        def outcome(x: Array) -> tuple[Array, float]:
            stretch = float(np.hypot(x[1] - x[0], x[2])) - p.length
            return np.array([x[1], 0.0, x[2]]), p.stiffness * stretch

        return Model(q, v, self._lagrange(kinetic, potential, q, v), np.array([0.0, *p.start]), outcome)

    def _knuckle(self, p: KnuckleCrane) -> Model:
        """Return the knuckle crane: α, β, γ and the payload in the world."""
        ca = self._ca
        q, v = ca.SX.sym("q", 6), ca.SX.sym("v", 6)
        kinetic, potential = 0.5 * p.tower * v[0] ** 2, 0.0
        end = ca.SX.zeros(3)
        for angle, rate, rod in ((q[1], v[1], p.boom), (q[2], v[2], p.jib)):
            along = ca.vertcat(ca.cos(q[0]) * ca.cos(angle), ca.sin(q[0]) * ca.cos(angle), ca.sin(angle))
            middle, end = end + 0.5 * rod.length * along, end + rod.length * along
            kinetic += 0.5 * rod.mass * ca.sumsqr(ca.jtimes(middle, q, v)) + self._turning(rod, angle, rate, v[0])
            potential += rod.mass * p.gravity * middle[2]
        rope = ca.norm_2(q[3:] - end)
        stretched = (q[1] - p.rest[0], q[2] - q[1] - p.rest[1], rope - p.rest[2])
        potential += sum(0.5 * k * e**2 for k, e in zip(p.stiffness, stretched, strict=True))
        kinetic, potential = kinetic + 0.5 * p.payload * ca.sumsqr(v[3:]), potential + p.payload * p.gravity * q[5]
        start = np.array([*p.q, *p.start])
        return Model(q, v, self._lagrange(kinetic, potential, q, v), start, lambda x: (x[3:6].copy(), None))

    def _turning(self, rod: Boom, angle: Any, rate: Any, slew: Any) -> Any:
        """Return the kinetic energy of a rod's turning about its centre of mass."""
        across = rate**2 + (slew * self._ca.cos(angle)) ** 2
        return 0.5 * (rod.inertia * across + rod.axial * (slew * self._ca.sin(angle)) ** 2)
