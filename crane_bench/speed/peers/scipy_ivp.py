"""scipy's `solve_ivp` with right-hand sides in plain numpy: vectors for chains, `math` otherwise."""

from collections.abc import Callable
from math import cos, sin, sqrt
from typing import ClassVar

import numpy as np
import numpy.typing as npt
import scipy
from scipy.integrate import solve_ivp
from scipy.linalg.lapack import get_lapack_funcs

from crane_bench.speed.engine import Run, RunResult, sweep_values
from crane_bench.speed.loops import OutputFunction
from crane_bench.speed.peers.hand_c import c_loop_input
from crane_bench.speed.problem import Chain, KnuckleCrane, Problem, Spring

Array = npt.NDArray[np.float64]
Rhs = Callable[[float, Array], list[float] | Array]
METHODS, TOLERANCES = ("RK45", "DOP853", "LSODA"), sweep_values(1e-2, 1e-12, 2)


class Scipy:
    """`solve_ivp` on numpy."""

    name = "scipy"
    unsupported_scenes: ClassVar[dict[str, str]] = {}
    version = f"{scipy.__version__}, numpy {np.__version__}"

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweep of tolerances with each method."""
        slope, start, outputs = equations(problem)

        def execute(method: str, rtol: float, repeats: int) -> RunResult:
            span = (0.0, problem.duration)
            for _ in range(repeats - 1):
                solve_ivp(slope, span, start, method, (problem.duration,), rtol=rtol, atol=0.01 * rtol)
            solution = solve_ivp(slope, span, start, method, (problem.duration,), rtol=rtol, atol=0.01 * rtol)
            payload, tension = outputs(solution.y[:, -1]) if solution.success else (np.full(3, np.nan), None)
            return RunResult(payload, solution.nfev, None, tension)

        settings = [(method, rtol) for method in METHODS for rtol in TOLERANCES]
        return [
            Run(self.name, m, rtol, lambda repeats, m=m, rtol=rtol: execute(m, rtol, repeats)) for m, rtol in settings
        ]


def equations(problem: Problem) -> tuple[Rhs, Array, OutputFunction]:
    """Return (right-hand side, initial state, output function)."""
    if isinstance(problem, Chain) and len(problem.masses) > 1:
        return _chain_slope(problem)
    c_input = c_loop_input(problem)
    if isinstance(problem, Chain):
        return _single_rhs(problem), c_input.state, c_input.outputs
    slope = _spring_slope(problem) if isinstance(problem, Spring) else _knuckle_slope(problem)
    return slope, c_input.state, c_input.outputs


def _single_rhs(p: Chain) -> Rhs:
    """Return the slope of (trolley, angle, rates)."""
    trolley, mass, length, g = p.trolley, float(p.masses[0]), float(p.lengths[0]), p.gravity

    def slope(t: float, x: Array) -> list[float]:
        _, angle, v, w = x.tolist()
        s, c = sin(angle), cos(angle)
        acceleration = mass * s * (length * w * w + g * c) / (trolley + mass * s * s)
        return [v, w, acceleration, -(g * s + c * acceleration) / length]

    return slope


def _spring_slope(p: Spring) -> Rhs:
    """Return the slope of (trolley, payload x and z, rates)."""

    def slope(t: float, x: Array) -> list[float]:
        trolley, px, pz, v, vx, vz = x.tolist()
        rx = px - trolley
        pull = p.stiffness * (1.0 - p.length / sqrt(rx * rx + pz * pz))
        return [v, vx, vz, pull * rx / p.trolley, -pull * rx / p.payload, -pull * pz / p.payload - p.gravity]

    return slope


def _chain_slope(p: Chain) -> tuple[Rhs, Array, OutputFunction]:
    """Return the slope of (trolley, angles, rates) by its tensions: a positive definite tridiagonal system."""
    n, m, lengths, g = len(p.masses), p.masses, p.lengths, p.gravity
    (solve,) = get_lapack_funcs(("ptsv",))
    diagonal = 1.0 / m + np.array([0.0, *(1.0 / m[:-1])])

    def slope(t: float, x: Array) -> Array:
        w = x[n + 2 :]
        s, c = np.sin(x[1 : n + 1]), np.cos(x[1 : n + 1])
        off_diagonal, pivots = -(c[1:] * c[:-1] + s[1:] * s[:-1]) / m[:-1], diagonal.copy()
        pivots[0] += s[0] * s[0] / p.trolley
        right_side = lengths * w * w
        right_side[0] += g * c[0]
        _, _, tension, _ = solve(pivots, off_diagonal, right_side)
        acceleration = tension[0] * s[0] / p.trolley
        sine = (s[1:] * c[:-1] - c[1:] * s[:-1]) / m[:-1]
        angular_accelerations = np.zeros(n)
        angular_accelerations[:-1] = sine * tension[1:]
        angular_accelerations[1:] -= sine * tension[:-1]
        angular_accelerations[0] -= g * s[0] + c[0] * acceleration
        return np.concatenate((x[n + 1 :], [acceleration], angular_accelerations / lengths))

    def outputs(x: Array) -> tuple[Array, None]:
        angles = x[1 : n + 1]
        return np.array([x[0] + lengths @ np.sin(angles), 0.0, -(lengths @ np.cos(angles))]), None

    return slope, np.array([0.0, *p.angles, *np.zeros(n + 1)]), outputs


def _knuckle_slope(p: KnuckleCrane) -> Rhs:
    """Return the slope of (α, β, γ, payload in the slewing frame, rates)."""
    boom, jib, m, g = p.boom, p.jib, p.payload, p.gravity
    k1, k2 = boom.length**2 * (0.25 * boom.mass + jib.mass), 0.25 * jib.length**2 * jib.mass
    k3, jb, jj = 0.5 * boom.length * jib.length * jib.mass, boom.inertia + k1, jib.inertia + k2

    def slope(t: float, state: Array) -> list[float]:
        _, beta, gamma, x, y, z, wa, wb, wg, vx, vy, vz = state.tolist()
        sb, cb, sg, cg = sin(beta), cos(beta), sin(gamma), cos(gamma)
        r = boom.length * cb + jib.length * cg
        ex, ez = x - r, z - boom.length * sb - jib.length * sg
        pull = p.stiffness[2] * (1.0 - p.neutral[2] / sqrt(ex * ex + y * y + ez * ez))
        fr, ft, fz = pull * ex, pull * y, pull * ez
        p1, p2 = (jb - boom.axial) * cb + k3 * cg, (jj - jib.axial) * cg + k3 * cb
        c, s, hb, hg = k3 * cos(beta - gamma), k3 * sin(beta - gamma), sb * p1, sg * p2
        couple = p.stiffness[1] * (gamma - beta - p.neutral[1])
        b2 = couple - p.stiffness[0] * (beta - p.neutral[0]) - s * wg * wg - hb * wa * wa
        b2 += boom.length * (cb * fz - sb * fr - g * cb * (0.5 * boom.mass + jib.mass))
        b3 = s * wb * wb - couple - hg * wa * wa + jib.length * (cg * fz - sg * fr - 0.5 * g * cg * jib.mass)
        slewing = p.tower + boom.axial + jib.axial + cb * p1 + cg * p2
        wa_dot, det = (r * ft + 2.0 * wa * (hb * wb + hg * wg)) / slewing, jb * jj - c * c
        ax = 2.0 * wa * vy + wa * wa * x + wa_dot * y - fr / m
        ay = wa * wa * y - 2.0 * wa * vx - wa_dot * x - ft / m
        return [wa, wb, wg, vx, vy, vz, wa_dot, (jj * b2 - c * b3) / det, (jb * b3 - c * b2) / det, ax, ay, -fz / m - g]

    return slope
