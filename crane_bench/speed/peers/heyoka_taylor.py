"""heyoka: Taylor's method of an order that the tolerance sets, its recurrences compiled by LLVM.

Each crane by hand in the form that is cheapest for it: one link in closed form, the knuckle crane
in its slewing frame, the spring's crane in Cartesian coordinates, chains by their tensions.
`state_equations` takes a function that makes its numbers, so that `test/reference/taylor.py` can
solve the same equations in quadruple precision.
"""

from collections.abc import Callable
from importlib import import_module
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from crane_bench.speed.engine import EngineUnavailable, Run, RunResult, sweep_values
from crane_bench.speed.loops import OutputFunction
from crane_bench.speed.peers.hand_c import c_loop_input
from crane_bench.speed.problem import Chain, KnuckleCrane, Problem, Spring

Array = npt.NDArray[np.float64]
Equations = list[tuple[Any, Any]]  # (variable, its derivative)
Number = Callable[[float], Any]
TOLERANCES = sweep_values(1e-2, 1e-16, 4)
COARSE_TOLERANCES = sweep_values(1e-2, 1e-16, 1)  # of chains, which are slow to compile
MAX_UNROLLED = 10  # links of a chain whose recurrences are written out one by one
_KNUCKLE_STATE = ("alpha", "beta", "gamma", "x", "y", "z", "wa", "wb", "wg", "vx", "vy", "vz")


def load_heyoka() -> Any:
    """Return the module.

    Raises:
        EngineUnavailable: it is not installed.
    """
    try:
        return import_module("heyoka")
    except ImportError:
        raise EngineUnavailable("heyoka is not installed") from None


class Heyoka:
    """heyoka's adaptive integrator."""

    name = "heyoka"
    unsupported_scenes: ClassVar[dict[str, str]] = {}

    def __init__(self) -> None:
        """Import heyoka.

        Raises:
            EngineUnavailable: it is not installed.
        """
        self._hy = load_heyoka()
        self.version = str(self._hy.__version__)

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return None: every problem is supported."""
        return None

    def runs(self, problem: Problem) -> list[Run]:
        """Return the sweep of tolerances, recurrences written out; chains in compact mode."""
        equations, (start, outputs) = (
            state_equations(self._hy, problem, float),
            start_and_outputs(problem),
        )
        links = len(problem.masses) if isinstance(problem, Chain) else 1
        modes = [False] * (links <= MAX_UNROLLED) + [True] * (links > 1)
        runs = []
        for compact in modes:
            for tol in COARSE_TOLERANCES if links > 1 else TOLERANCES:
                integrator = self._hy.taylor_adaptive(
                    equations, start.tolist(), tol=tol, compact_mode=compact
                )
                execute = make_execute(integrator, start, problem.duration, outputs)
                runs.append(
                    Run(self.name, "taylor, compact" if compact else "taylor", tol, execute)
                )
        return runs


def make_execute(
    integrator: Any, start: Array, duration: float, outputs: OutputFunction
) -> Callable[[int], RunResult]:
    """Return the function that integrates the whole duration a number of times."""
    state = integrator.state  # a view

    def execute(repetitions: int) -> RunResult:
        outcome: tuple[Any, ...] = ()
        for _ in range(repetitions):
            integrator.time = 0.0
            state[:] = start
            outcome = integrator.propagate_until(duration)
        payload, tension = outputs(state.copy())
        return RunResult(payload, None, int(outcome[3]), tension)

    return execute


def start_and_outputs(problem: Problem) -> tuple[Array, OutputFunction]:
    """Return (state at the start, output function)."""
    if not isinstance(problem, Chain):
        c_input = c_loop_input(problem)
        return c_input.state, c_input.outputs
    lengths, n = problem.lengths, len(problem.masses)

    def outputs(state: Array) -> tuple[Array, None]:
        angles = state[1 : n + 1]
        return np.array(
            [state[0] + lengths @ np.sin(angles), 0.0, -(lengths @ np.cos(angles))]
        ), None

    return np.array([0.0, *problem.angles, *np.zeros(n + 1)]), outputs


def state_equations(hy: Any, problem: Problem, number: Number) -> Equations:
    """Return the equations of the state; `number` makes parameters of floats."""
    if isinstance(problem, Spring):
        return _spring(hy, problem, number)
    if isinstance(problem, KnuckleCrane):
        return _knuckle(hy, problem, number)
    return _single(hy, problem, number) if len(problem.masses) == 1 else _chain(hy, problem, number)


def _single(hy: Any, p: Chain, number: Number) -> Equations:
    x, angle, v, w = hy.make_vars("x", "angle", "v", "w")
    trolley, mass, length, g = (
        number(value) for value in (p.trolley, p.masses[0], p.lengths[0], p.gravity)
    )
    s, c = hy.sin(angle), hy.cos(angle)
    acceleration = mass * s * (length * w * w + g * c) / (trolley + mass * s * s)
    turning = -(g * s + c * acceleration) / length
    return [(x, v), (angle, w), (v, acceleration), (w, turning)]


def _spring(hy: Any, p: Spring, number: Number) -> Equations:
    x, px, pz, v, vx, vz = hy.make_vars("x", "px", "pz", "v", "vx", "vz")
    trolley, mass, rest, stiffness, g = map(
        number, (p.trolley, p.payload, p.length, p.stiffness, p.gravity)
    )
    rx = px - x
    pull = stiffness - stiffness * rest / hy.sqrt(rx * rx + pz * pz)
    accelerations = (pull * rx / trolley, -pull * rx / mass, -pull * pz / mass - g)
    return list(zip((x, px, pz, v, vx, vz), (v, vx, vz, *accelerations), strict=True))


def _chain(hy: Any, p: Chain, number: Number) -> Equations:
    """Return the chain by its tensions, a tridiagonal system solved from the trolley down."""
    n = len(p.masses)
    x, v = hy.make_vars("x", "v")
    angles = hy.make_vars(*(f"a{k}" for k in range(n)))
    rates = hy.make_vars(*(f"w{k}" for k in range(n)))
    m, lengths = (
        [number(mass) for mass in p.masses.tolist()],
        [number(length) for length in p.lengths.tolist()],
    )
    trolley, g, one = number(p.trolley), number(p.gravity), number(1.0)
    inverse = [one / mass for mass in m]
    s, c = hy.sin(angles[0]), hy.cos(angles[0])
    bends = [(hy.cos(b - a), hy.sin(b - a)) for a, b in zip(angles[:-1], angles[1:], strict=True)]
    pivots = [inverse[0] + s * s / trolley, *(inverse[k] + inverse[k + 1] for k in range(n - 1))]
    right_side = [length * w * w for length, w in zip(lengths, rates, strict=True)]
    right_side[0] += g * c
    t = _solve(pivots, [-cosine * inverse[k] for k, (cosine, _) in enumerate(bends)], right_side)
    acceleration = t[0] * s / trolley
    across = [-g * s - c * acceleration, *[None] * (n - 1)]
    for k in range(n - 1):
        across[k] = across[k] + bends[k][1] * inverse[k] * t[k + 1]
        across[k + 1] = -(bends[k][1] * inverse[k] * t[k])
    turning = [a / length for a, length in zip(across, lengths, strict=True)]
    return list(zip((x, *angles, v, *rates), (v, *rates, acceleration, *turning), strict=True))


def _solve(pivots: list[Any], off_diagonal: list[Any], right_side: list[Any]) -> list[Any]:
    """Return the solution of a symmetric tridiagonal system."""
    pivots, t = list(pivots), list(right_side)
    for k, off in enumerate(off_diagonal):
        ratio = off / pivots[k]
        pivots[k + 1] = pivots[k + 1] - ratio * off
        t[k + 1] = t[k + 1] - ratio * t[k]
    t[-1] = t[-1] / pivots[-1]
    for k in range(len(off_diagonal) - 1, -1, -1):
        t[k] = (t[k] - off_diagonal[k] * t[k + 1]) / pivots[k]
    return t


def _luffing_inertias(p: KnuckleCrane, number: Number) -> tuple[Any, Any, Any]:
    """Return (coupling of boom and jib, inertia of the boom with the jib's mass, of the jib)."""
    lb, mb, ib, _ = map(number, p.boom)
    lj, mj, ij, _ = map(number, p.jib)
    half, quarter = number(0.5), number(0.25)
    coupling = half * lb * lj * mj
    return coupling, ib + lb * lb * (quarter * mb + mj), ij + quarter * lj * lj * mj


def _rope_force(
    hy: Any, rope: tuple[Any, Any, Any], stiffness: Any, length: Any
) -> tuple[Any, Any, Any]:
    """Return the force of an elastic rope along its vector."""
    x, y, z = rope
    pull = stiffness - stiffness * length / hy.sqrt(x * x + y * y + z * z)
    return pull * x, pull * y, pull * z


def _knuckle(hy: Any, p: KnuckleCrane, number: Number) -> Equations:
    """Return the knuckle crane, its payload in the slewing frame."""
    variables = hy.make_vars(*_KNUCKLE_STATE)
    _, beta, gamma, x, y, z, wa, wb, wg, vx, vy, vz = variables
    lb, mb, _, axial_b = map(number, p.boom)
    lj, mj, _, axial_j = map(number, p.jib)
    tower, m, g = map(number, (p.tower, p.payload, p.gravity))
    (kb, kg, kr), (b0, g0, r0) = map(number, p.stiffness), map(number, p.neutral)
    half, two = number(0.5), number(2.0)
    k3, jb, jj = _luffing_inertias(p, number)
    sb, cb, sg, cg = hy.sin(beta), hy.cos(beta), hy.sin(gamma), hy.cos(gamma)
    r, ez = lb * cb + lj * cg, z - lb * sb - lj * sg
    fr, ft, fz = _rope_force(hy, (x - r, y, ez), kr, r0)
    p1, p2 = (jb - axial_b) * cb + k3 * cg, (jj - axial_j) * cg + k3 * cb
    c, s = k3 * (cb * cg + sb * sg), k3 * (sb * cg - cb * sg)
    hb, hg, couple = sb * p1, sg * p2, kg * (gamma - beta - g0)
    b2 = couple - kb * (beta - b0) - s * wg * wg - hb * wa * wa
    b2 += lb * (cb * fz - sb * fr) - g * lb * (half * mb + mj) * cb
    b3 = s * wb * wb - couple - hg * wa * wa + lj * (cg * fz - sg * fr) - half * g * lj * mj * cg
    ja = tower + axial_b + axial_j + cb * p1 + cg * p2
    wa_dot = (r * ft + two * wa * (hb * wb + hg * wg)) / ja
    det = jb * jj - c * c
    ax = two * wa * vy + wa * wa * x + wa_dot * y - fr / m
    ay = wa * wa * y - two * wa * vx - wa_dot * x - ft / m
    wb_dot, wg_dot = (jj * b2 - c * b3) / det, (jb * b3 - c * b2) / det
    accelerations = (wa_dot, wb_dot, wg_dot, ax, ay, -fz / m - g)
    return list(zip(variables, (wa, wb, wg, vx, vy, vz, *accelerations), strict=True))
