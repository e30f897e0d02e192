"""CasADi: symbolic equations, written to C by CasADi, integrated by the hand-written C's loops.

Coordinates are absolute angles, and Cartesian ones of a payload on a spring. CasADi differentiates
the energies and solves with the mass matrix symbolically; chains are also written with their
tridiagonal system of tensions, and the faster formulation is kept.
"""

import tempfile
from importlib import import_module
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.speed.compiler import C_SOURCES, Compiler
from crane_bench.speed.engine import EngineUnavailable, Run
from crane_bench.speed.loops import CLoopInput, Loops, OutputFunction
from crane_bench.speed.peers.hand_c import c_loop_input
from crane_bench.speed.problem import Chain, KnuckleCrane, Problem, RodParameters, Spring

Array = npt.NDArray[np.float64]
MAX_DENSE_LINKS = 20  # with a mass matrix solved symbolically, whose code grows with their square


class Model(NamedTuple):
    """Symbolic equations of motion."""

    q: Any
    v: Any
    acceleration: Any
    initial: Array  # of q; at rest
    outputs: OutputFunction


class CasadiC:
    """CasADi with its generated C."""

    name = "CasADi C"
    unsupported_scenes: ClassVar[dict[str, str]] = {}

    def __init__(self) -> None:
        """Import CasADi and find a compiler.

        Raises:
            EngineUnavailable: one of them is not installed.
        """
        try:
            self._ca: Any = import_module("casadi")
        except ImportError:
            raise EngineUnavailable("casadi is not installed") from None
        self._folder = tempfile.TemporaryDirectory()
        self._compiler = Compiler(Path(self._folder.name))
        self.version = f"{self._ca.__version__}, {self._compiler.version}"

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweeps with the fastest formulation."""
        loops = [self._loops(model, c_loop_input(problem)) for model in self._models(problem)]
        return min(loops, key=lambda compiled: compiled.trial_time).runs(self.name)

    def _models(self, problem: Problem) -> list[Model]:
        if isinstance(problem, Spring):
            return [self._spring_crane(problem)]
        if isinstance(problem, KnuckleCrane):
            return [self._knuckle_crane(problem)]
        tensions = [self._chain_by_tensions(problem)]
        return (
            [self._chain_by_angles(problem), *tensions]
            if len(problem.masses) <= MAX_DENSE_LINKS
            else tensions
        )

    def _loops(self, model: Model, hand_c: CLoopInput) -> Loops:
        """Write the C and compile loops around it, with frequency and duration of `hand_c`."""
        x = self._ca.vertcat(model.q, model.v)
        rhs = self._ca.Function(
            "rhs", [x], [self._ca.vertcat(model.v, model.acceleration)], {"cse": True}
        )
        generator = self._ca.CodeGenerator("casadi_rhs.c")
        generator.add(rhs)
        (self._compiler.folder / "casadi_rhs.h").write_text(generator.dump())
        state = np.concatenate([model.initial, np.zeros_like(model.initial)])
        methods, define = ("rk4", "rk8"), (f"-DSIZE={len(state)}",)
        source = C_SOURCES / "casadi.c"
        c_input = CLoopInput(
            source,
            np.zeros(1),
            state,
            model.outputs,
            hand_c.max_frequency,
            hand_c.duration,
            methods,
            define,
        )
        return Loops(self._compiler, c_input)

    def _lagrange(self, kinetic: Any, potential: Any, q: Any, v: Any) -> Any:
        """Return the accelerations of a conservative system."""
        ca, momentum = self._ca, self._ca.gradient(kinetic, v)
        force = ca.gradient(kinetic - potential, q) - ca.jtimes(momentum, q, v)
        return ca.ldl_solve(force, *ca.ldl(ca.jacobian(momentum, v)))

    def _chain_coordinates(self, p: Chain) -> tuple[Any, Any, Array, OutputFunction]:
        """Return (coordinates, rates, initial coordinates, outputs): trolley first, then angles."""
        n = len(p.masses)

        def outputs(x: Array) -> tuple[Array, None]:
            angles = x[1 : n + 1]
            return np.array(
                [x[0] + p.lengths @ np.sin(angles), 0.0, -(p.lengths @ np.cos(angles))]
            ), None

        return (
            self._ca.SX.sym("q", n + 1),
            self._ca.SX.sym("v", n + 1),
            np.array([0.0, *p.angles]),
            outputs,
        )

    def _chain_by_angles(self, p: Chain) -> Model:
        ca, (q, v, initial, outputs) = self._ca, self._chain_coordinates(p)
        x, z = q[0], 0.0
        kinetic, potential = 0.5 * p.trolley * v[0] ** 2, 0.0
        for k, (mass, length) in enumerate(zip(p.masses, p.lengths, strict=True), 1):
            x, z = x + length * ca.sin(q[k]), z - length * ca.cos(q[k])
            kinetic += 0.5 * mass * (ca.jtimes(x, q, v) ** 2 + ca.jtimes(z, q, v) ** 2)
            potential += mass * p.gravity * z
        return Model(q, v, self._lagrange(kinetic, potential, q, v), initial, outputs)

    def _chain_by_tensions(self, p: Chain) -> Model:
        """Return the chain by its tensions, a tridiagonal system."""
        ca, (q, v, initial, outputs) = self._ca, self._chain_coordinates(p)
        n, s, c, inverse_masses = len(p.masses), ca.sin(q[1:]), ca.cos(q[1:]), 1.0 / p.masses
        cosines = [c[k] * c[k + 1] + s[k] * s[k + 1] for k in range(n - 1)]
        sines = [c[k] * s[k + 1] - s[k] * c[k + 1] for k in range(n - 1)]
        upper_pivot = inverse_masses[0] + s[0] ** 2 / p.trolley
        pivot = [upper_pivot, *(inverse_masses[:-1] + inverse_masses[1:])]
        t = [p.lengths[k] * v[k + 1] ** 2 for k in range(n)]
        t[0] += p.gravity * c[0]
        _solve_tensions(cosines, inverse_masses, pivot, t)
        trolley_acceleration = t[0] * s[0] / p.trolley
        angular_accelerations = [0.0 for _ in range(n)]
        angular_accelerations[0] = -p.gravity * s[0] - c[0] * trolley_acceleration
        for k in range(n - 1):
            angular_accelerations[k] += sines[k] * t[k + 1] * inverse_masses[k]
            angular_accelerations[k + 1] -= sines[k] * t[k] * inverse_masses[k]
        angular_accelerations = [
            a / length for a, length in zip(angular_accelerations, p.lengths, strict=True)
        ]
        return Model(
            q, v, ca.vertcat(trolley_acceleration, *angular_accelerations), initial, outputs
        )

    def _spring_crane(self, p: Spring) -> Model:
        """Return the spring's crane: trolley, payload x and z."""
        ca = self._ca
        q, v = ca.SX.sym("q", 3), ca.SX.sym("v", 3)
        rope = ca.norm_2(ca.vertcat(q[1] - q[0], q[2]))
        kinetic = 0.5 * (p.trolley * v[0] ** 2 + p.payload * (v[1] ** 2 + v[2] ** 2))
        potential = p.payload * p.gravity * q[2] + 0.5 * p.stiffness * (rope - p.length) ** 2

        def outputs(x: Array) -> tuple[Array, float]:
            stretch = float(np.hypot(x[1] - x[0], x[2])) - p.length
            return np.array([x[1], 0.0, x[2]]), p.stiffness * stretch

        return Model(
            q, v, self._lagrange(kinetic, potential, q, v), np.array([0.0, *p.start]), outputs
        )

    def _knuckle_crane(self, p: KnuckleCrane) -> Model:
        """Return the knuckle crane: α, β, γ and the payload in the world."""
        ca = self._ca
        q, v = ca.SX.sym("q", 6), ca.SX.sym("v", 6)
        kinetic, potential = 0.5 * p.tower * v[0] ** 2, 0.0
        end = ca.SX.zeros(3)
        for angle, rate, rod in ((q[1], v[1], p.boom), (q[2], v[2], p.jib)):
            direction = ca.vertcat(
                ca.cos(q[0]) * ca.cos(angle), ca.sin(q[0]) * ca.cos(angle), ca.sin(angle)
            )
            com, end = end + 0.5 * rod.length * direction, end + rod.length * direction
            kinetic += 0.5 * rod.mass * ca.sumsqr(ca.jtimes(com, q, v)) + self._rotational_energy(
                rod, angle, rate, v[0]
            )
            potential += rod.mass * p.gravity * com[2]
        rope = ca.norm_2(q[3:] - end)
        deflections = (q[1] - p.neutral[0], q[2] - q[1] - p.neutral[1], rope - p.neutral[2])
        potential += sum(0.5 * k * e**2 for k, e in zip(p.stiffness, deflections, strict=True))
        kinetic, potential = (
            kinetic + 0.5 * p.payload * ca.sumsqr(v[3:]),
            potential + p.payload * p.gravity * q[5],
        )
        initial = np.array([*p.q, *p.start])
        return Model(
            q, v, self._lagrange(kinetic, potential, q, v), initial, lambda x: (x[3:6].copy(), None)
        )

    def _rotational_energy(self, rod: RodParameters, angle: Any, rate: Any, slew: Any) -> Any:
        """Return the kinetic energy of a rod's rotation about its centre of mass."""
        perpendicular = rate**2 + (slew * self._ca.cos(angle)) ** 2
        return 0.5 * (rod.inertia * perpendicular + rod.axial * (slew * self._ca.sin(angle)) ** 2)


def _solve_tensions(
    cosines: list[Any], inverse_masses: Any, pivot: list[Any], t: list[Any]
) -> None:
    """Solve the tridiagonal system of a chain's tensions: `t` is its right side, then they."""
    for k in range(1, len(t)):
        ratio = cosines[k - 1] * inverse_masses[k - 1] / pivot[k - 1]
        pivot[k] -= ratio * cosines[k - 1] * inverse_masses[k - 1]
        t[k] += ratio * t[k - 1]
    t[-1] /= pivot[-1]
    for k in range(len(t) - 2, -1, -1):
        t[k] = (t[k] + cosines[k] * inverse_masses[k] * t[k + 1]) / pivot[k]
