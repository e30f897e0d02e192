"""This simulator as an engine of the benchmark: its methods, each over steps or tolerances."""

import time
from collections.abc import Callable, Sequence
from importlib.metadata import version
from typing import Any

import numpy as np

from crane_bench.speed.engine import Run, RunResult, sweep_values
from crane_bench.speed.peers.mechanism import attitude_of
from crane_sim import system
from crane_sim.integrators import (
    apply_pending_events,
    dense_output,
    latest_step_end,
    make_event_log,
    start,
)
from crane_sim.integrators.dop853 import DOP853, RK8
from crane_sim.integrators.dopri5 import DOPRI5
from crane_sim.integrators.gauss import Gauss
from crane_sim.integrators.gauss16 import Gauss16
from crane_sim.integrators.leapfrog import Leapfrog
from crane_sim.integrators.rk4 import RK4
from crane_sim.integrators.rodas import Rodas
from crane_sim.models.loads import RigidLoad
from crane_sim.numerics.jit import entry_point
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.derived import world_points
from crane_sim.stepping.periods import begin, integrate_source_to
from crane_sim.trajectories.breakpoints import unwrap, with_breakpoints

NAME, VERSION = "crane_sim", version("crane_sim")
STEPS = sweep_values(1.0, 1e-5, 8)  # s
TOLERANCES = sweep_values(1e-1, 1e-13, 8)  # relative; the absolute one is a hundredth of it
FIXED: dict[str, Any] = {"rk4": RK4, "rk8": RK8, "gauss": Gauss, "leapfrog": Leapfrog}
ADAPTIVE: dict[str, Any] = {"dopri5": DOPRI5, "dop853": DOP853, "gauss16": Gauss16, "rodas": Rodas}
METHODS = (*FIXED, *ADAPTIVE)


@entry_point
def integrate(method, p, source, q, v, end, repetitions):
    """Integrate `repetitions` times from joints q and v; return (integration, state at `end`)."""
    x = system.project(p, system.state(p, 0.0, q, v))
    integration = start(p, 0.0, x, make_event_log(system.switching(p)))
    for _ in range(repetitions):
        initial = start(p, 0.0, x, make_event_log(system.switching(p)))
        initial = apply_pending_events(system.switching(p), p, source, initial)
        integration = integrate_source_to(
            source, method, p, initial, end, latest_step_end(method, 0, 1, end)
        )
    return integration, dense_output(method, p, source, integration, end)


@entry_point
def read_outputs(p, t, x, source):
    """Return (q, v, tensions (L,)) at a state."""
    q, v = system.joints(p, x)
    tensions = np.empty((1, system.link_count(p)))
    system.tensions(p, t, x, source, tensions, 0, 0)
    return q, v, tensions[0]


class CraneSimEngine:
    """This simulator as the engine of one scene."""

    def __init__(self, scene: Scene) -> None:
        """Take the scene's crane, source and duration; the benchmark has its own methods."""
        self.scene, self.p, self.source = scene, scene.model, unwrap(scene.source)
        self.q, self.v = np.array(scene.initial_q), np.array(scene.initial_v)
        self.compile_times: dict[str, float] = {}

    def methods(self) -> list[str]:
        """Return the methods that fit the scene.

        rodas and leapfrog need array states, gauss needs a crane without events.
        """
        has_array_state = system.rhs_into.has_implementation(type(self.p))
        smooth = begin(self.p, self.q, self.v)[0].event_log is None
        fits = {
            "rodas": has_array_state,
            "leapfrog": system.position_count.has_implementation(type(self.p)),
            "gauss": smooth,
        }
        return [method for method in METHODS if fits.get(method, True)]

    def runs(self, method: str, steps: Sequence[float] = STEPS) -> list[Run]:
        """Return the sweep of one method, coarsest first; compiles it and records that time [s].

        Args:
            method: one of `methods`.
            steps: sizes [s] of a method with fixed steps.
        """
        method_class = FIXED.get(method) or ADAPTIVE[method]
        values = steps if method in FIXED else TOLERANCES
        configured = [
            (value, method_class(value) if method in FIXED else method_class(value, 0.01 * value))
            for value in values
        ]
        start = time.perf_counter()
        self.make_run(configured[0][1])(1)
        self.compile_times[method] = time.perf_counter() - start
        return [Run(NAME, method, value, self.make_run(settings)) for value, settings in configured]

    def make_run(self, method: Any) -> Callable[[int], RunResult]:
        """Return a function that integrates the whole duration repeatedly with `method`."""
        end = self.scene.duration
        source = with_breakpoints(self.source, self.p) if hasattr(method, "rtol") else self.source

        def execute(repetitions: int) -> RunResult:
            integration, x = integrate(method, self.p, source, self.q, self.v, end, repetitions)
            q, v, tensions = read_outputs(self.p, end, x, self.source)
            points, _ = world_points(self.p, end, np.array(q), np.array(v))
            attitude = (
                attitude_of(q) if isinstance(getattr(self.p, "load", None), RigidLoad) else None
            )
            return RunResult(
                points[-1],
                integration.evaluations,
                integration.steps,
                float(tensions[-1]),
                attitude,
            )

        return execute
