"""C integration loops around hand-written or generated equations: compilation and sweeps."""

import ctypes
import time
from collections.abc import Callable
from math import ceil
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.speed.compiler import NATIVE, Compiler
from crane_bench.speed.engine import Run, RunResult, sweep_values
from crane_sim.integrators import dop853

Array = npt.NDArray[np.float64]
FLAGS = (("-O3",), NATIVE)
"""Both are tried on every problem; the faster is kept."""
SWEEPS = {"leapfrog": (2.0, 0.2), "rk4": (4.0, 0.04), "rk8": (6.0, 0.03)}
"""The first and last step as multiples of one over the problem's highest frequency."""
TOLERANCES = sweep_values(1e-2, 1e-14, 8)
TRIAL = 2000  # steps, to compare flags
ADDRESS, REAL, COUNT = ctypes.c_void_p, ctypes.c_double, ctypes.c_long


OutputFunction = Callable[[Array], tuple[Array, float | None]]
"""Returns (payload position (3,) [m], tension [N]) of a state."""


class CLoopInput(NamedTuple):
    """A problem as the input of a C loop."""

    source: Path
    parameters: Array  # the struct
    state: Array  # at the start
    outputs: OutputFunction
    max_frequency: float  # rad/s, approximate
    duration: float  # s
    methods: tuple[str, ...]  # of fixed step
    defines: tuple[str, ...] = ()


def coefficients() -> str:
    """Return C macros of the order 8 tableau: sums over stages k[j][i] of nonzero weight."""

    def weighted_sum(row: tuple[float | None, ...]) -> str:
        return " + ".join(
            f"{weight!r} * k[{j}][i]" for j, weight in enumerate(row) if weight is not None
        )

    sums = {f"COMBINE_{n}": row for n, row in enumerate((*dop853.A, dop853.B), 1)}
    sums |= {"ERROR_5": dop853.E5, "ERROR_3": dop853.E3}
    return "".join(f"#define {name}(k, i) ({weighted_sum(row)})\n" for name, row in sums.items())


class Loops:
    """The compiled loops of one problem; vectors live as long as this does."""

    def __init__(self, compiler: Compiler, problem: CLoopInput) -> None:
        """Compile with each of the flags and keep the fastest.

        Raises:
            EngineUnavailable: the compiler fails.
        """
        (compiler.folder / "dop853.h").write_text(coefficients())
        self.problem, self.end = problem, np.empty_like(problem.state)
        self.counts = np.zeros(2, np.dtype(ctypes.c_long))
        libraries = [
            compiler.library(problem.source, (*flags, *problem.defines)) for flags in FLAGS
        ]
        self.trial_time, fastest = min(
            (self._trial(library), n) for n, library in enumerate(libraries)
        )
        self.library, self.flags = libraries[fastest], FLAGS[fastest]

    def _trial(self, library: Any) -> float:
        """Return the least time of a few steps [s]."""
        times = []
        for _ in range(10):
            start = time.perf_counter()
            self._call(library.run_rk8, 0.1 / self.problem.max_frequency, TRIAL, 1)
            times.append(time.perf_counter() - start)
        return min(times)

    def _call(self, function: Any, *arguments: float) -> None:
        """Call a loop with a step and two counts, or with a tolerance, a duration and a count."""
        last = (COUNT,) if isinstance(arguments[1], int) else (REAL,)
        function.argtypes, function.restype = [ADDRESS] * 3 + [REAL, *last, COUNT] + [ADDRESS], None
        addresses = (
            array.ctypes.data for array in (self.problem.parameters, self.problem.state, self.end)
        )
        function(*addresses, *arguments, self.counts.ctypes.data)

    def fixed(self, method: str, steps: int, repeats: int) -> RunResult:
        """Integrate over the whole duration in `steps` equal steps."""
        self._call(
            getattr(self.library, f"run_{method}"), self.problem.duration / steps, steps, repeats
        )
        return self._result()

    def adaptive(self, rtol: float, repeats: int) -> RunResult:
        """Integrate the whole duration with error control.

        The absolute tolerance is a hundredth of the relative one.
        """
        self._call(self.library.run_dop853, rtol, self.problem.duration, repeats)
        return self._result()

    def _result(self) -> RunResult:
        (payload, tension), (steps, evaluations) = self.problem.outputs(self.end), self.counts
        return RunResult(payload, int(evaluations), int(steps), tension)

    def runs(self, engine: str) -> list[Run]:
        """Return the sweeps of all methods."""
        runs, duration = [], self.problem.duration
        for method in self.problem.methods:
            multiples = sweep_values(*SWEEPS[method], 8)
            counts = [
                ceil(duration * self.problem.max_frequency / multiple) for multiple in multiples
            ]
            runs += [
                Run(engine, method, duration / n, lambda r, m=method, n=n: self.fixed(m, n, r))
                for n in counts
            ]
        return runs + [
            Run(engine, "dop853", tol, lambda r, tol=tol: self.adaptive(tol, r))
            for tol in TOLERANCES
        ]
