"""The Rosenbrock method on a cable as stiff as steel, against scipy's LSODA on the same compiled equations.

`crane bench stiff` runs both with several tolerances on the scene `overhead_stiff` and prints the cheapest setting of
each that reaches the error: the largest distance of a node from the reference, a DOP853 solution that a Rodas solution
with other small tolerances confirms. Times are processor times, which other programs affect less.
"""

import time
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
import scipy
from scipy.integrate import solve_ivp

from crane_bench.speed.measurement import machine
from crane_sim import system
from crane_sim.integrators import integrate_to, start
from crane_sim.integrators.dop853 import DOP853
from crane_sim.integrators.rodas import Rodas
from crane_sim.numerics.jit import entry_point
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.stepping.periods import begin

SCENE = "overhead_stiff"
ROUNDS = 5
TOLERANCES = (
    (1e-4, 1e-5),
    (1e-5, 1e-5),
    (1e-5, 3e-6),
    (1e-5, 1e-6),
    (1e-6, 1e-6),
    (1e-6, 1e-7),
    (1e-7, 1e-8),
    (1e-8, 1e-9),
)
"""Relative and absolute tolerances of the trials of each method."""


class StiffTrial(NamedTuple):
    """A run with one setting."""

    tolerances: tuple[float, float]
    error: float  # m
    seconds: float  # of processor time for a simulated second, least of the rounds
    evaluations: int  # of the equations, without linear systems


@entry_point
def integrate(method, p, x, u, end):
    """Return the integration from (0, x) to `end`."""
    return integrate_to(method, p, u, start(p, 0.0, x, None), end, end)


@entry_point
def derivative(p, t, x, u):
    """Return the time derivative of the state."""
    return system.rhs(p, t, x, u)


def time_run(run: Callable[[], Any]) -> tuple[Any, float]:
    """Return (result, processor time [s])."""
    start = time.process_time()
    return run(), time.process_time() - start


class StiffCase:
    """The scene and reference solutions of its final state."""

    def __init__(self, scene: Scene) -> None:
        """Integrate the reference."""
        self.p, self.end, self.u = scene.model, scene.duration, (0.0,) * len(scene.actuated)
        integration, q, _ = begin(self.p, np.array(scene.initial_q), np.array(scene.initial_v))
        self.x, self.n = integration.x, len(q)
        self.reference = integrate(DOP853(1e-11, 1e-13), self.p, self.x, self.u, self.end).x
        self.reference_difference = self.error(integrate(Rodas(1e-9, 1e-11), self.p, self.x, self.u, self.end).x)

    def error(self, x: np.ndarray) -> float:
        """Return how far a final state's positions are from the reference's [m]."""
        return float(np.max(np.abs(x[: self.n] - self.reference[: self.n])))

    def rodas(self, tolerances: tuple[float, float]) -> StiffTrial:
        """Run the Rosenbrock method."""
        method = Rodas(*tolerances)
        integration, _ = time_run(lambda: integrate(method, self.p, self.x, self.u, self.end))
        seconds = min(time_run(lambda: integrate(method, self.p, self.x, self.u, self.end))[1] for _ in range(ROUNDS))
        return StiffTrial(tolerances, self.error(integration.x), seconds / self.end, integration.evaluations)

    def lsoda(self, tolerances: tuple[float, float]) -> StiffTrial:
        """Run scipy's LSODA."""
        rtol, atol = tolerances
        solution, seconds = time_run(
            lambda: solve_ivp(
                lambda t, x: derivative(self.p, t, x, self.u), (0.0, self.end), self.x, "LSODA", rtol=rtol, atol=atol
            )
        )
        return StiffTrial(tolerances, self.error(solution.y[:, -1]), seconds / self.end, solution.nfev)


def cheapest_trial(run: Callable[[tuple[float, float]], StiffTrial], error: float) -> StiffTrial | None:
    """Return the fastest of the trials that reach the error, None when none does."""
    return min((trial for trial in map(run, TOLERANCES) if trial.error <= error), key=lambda t: t.seconds, default=None)


def measure_stiff(error: float = 1e-6, dampings: Sequence[float] = (0.0, 1e4)) -> dict[str, Any]:
    """Return the cheapest runs of both that reach an error [m], for each damping of the links [N s/m]."""
    results: dict[str, Any] = {"error_m": error, "scipy": scipy.__version__, "machine": machine(), "dampings": {}}
    for damping in dampings:
        case = StiffCase(load_scene(SCENE, {"cable.damping": damping}))
        trials = {"rodas": cheapest_trial(case.rodas, error), "LSODA": cheapest_trial(case.lsoda, error)}
        rows = {name: trial._asdict() if trial else None for name, trial in trials.items()}
        results["dampings"][f"{damping:g}"] = rows | {"doubt_m": case.reference_difference}
    return results


def format_stiff(results: dict[str, Any]) -> list[str]:
    """Return the comparison in lines."""
    lines = []
    for damping, row in results["dampings"].items():
        lines.append(f"{SCENE}, damping {damping} N s/m; two tight references differ by {row['doubt_m']:.1e} m")
        for name in ("rodas", "LSODA"):
            if (trial := row[name]) is None:
                lines.append(f"  {name:<6} no setting reaches {results['error_m']:g} m")
                continue
            cost = f"{1e3 * trial['seconds']:8.2f} ms per simulated second, {trial['evaluations']} evaluations"
            tolerances = ", ".join(f"{tolerance:g}" for tolerance in trial["tolerances"])
            lines.append(f"  {name:<6} rtol, atol {tolerances}: error {trial['error']:.1e} m, {cost}")
        if row["rodas"] and row["LSODA"]:
            lines.append(f"  LSODA / rodas {row['LSODA']['seconds'] / row['rodas']['seconds']:.0f}")
    return lines
