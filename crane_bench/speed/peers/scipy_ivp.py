"""scipy's `solve_ivp`: vectors of numpy for chains, heyoka's equations on floats otherwise."""

from collections.abc import Callable
from math import cos, sin, sqrt
from types import SimpleNamespace
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt
import scipy
from scipy.integrate import solve_ivp
from scipy.linalg.lapack import get_lapack_funcs

from crane_bench.speed.engine import Run, RunResult, sweep_values
from crane_bench.speed.peers.heyoka_taylor import start_and_outputs, state_equations
from crane_bench.speed.problem import Chain, Problem

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
        slope = _slope(problem)
        if isinstance(problem, Chain) and len(problem.masses) > 1:
            slope = _chain_slope(problem)
        start, outputs = start_and_outputs(problem)

        def execute(method: str, rtol: float, repeats: int) -> RunResult:
            span = (0.0, problem.duration)
            options: dict[str, Any] = {"rtol": rtol, "atol": 0.01 * rtol}
            (*_, solution) = [
                solve_ivp(slope, span, start, method, span[1:], **options) for _ in range(repeats)
            ]
            payload, tension = (
                outputs(solution.y[:, -1]) if solution.success else (np.full(3, np.nan), None)
            )
            return RunResult(payload, solution.nfev, None, tension)

        settings = [(method, rtol) for method in METHODS for rtol in TOLERANCES]
        return [
            Run(self.name, m, rtol, lambda repeats, m=m, rtol=rtol: execute(m, rtol, repeats))
            for m, rtol in settings
        ]


def _slope(problem: Problem) -> Rhs:
    """Return the slope of the state by heyoka's equations, evaluated on floats."""

    def slope(t: float, x: Array) -> list[float]:
        numbers = SimpleNamespace(sin=sin, cos=cos, sqrt=sqrt, make_vars=lambda *_: x.tolist())
        return [rate for _, rate in state_equations(numbers, problem, float)]

    return slope


def _chain_slope(p: Chain) -> Rhs:
    """Return the slope of (trolley, angles, rates) by tensions.

    Their system is tridiagonal and positive definite.
    """
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

    return slope
