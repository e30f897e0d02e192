"""Interface of a benchmark engine: this simulator and its peers."""

from collections.abc import Callable
from typing import ClassVar, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from crane_bench.speed.problem import Problem

Array = npt.NDArray[np.float64]


class RunResult(NamedTuple):
    """Final payload position of a run, and its cost."""

    payload: Array  # (3,) m, world, z up
    evaluations: int | None  # of the equations; None: not counted by the engine
    steps: int | None
    tension: float | None = None  # N, of an elastic cable at the end; None: not requested or not
    # available
    attitude: Array | None = None  # (3, 3) rotation from a rigid load's axes to the world's, at the
    # end


class Run(NamedTuple):
    """One integration of a problem over its whole duration: an engine, a method and a setting."""

    engine: str
    method: str  # of integration, as the engine calls it
    setting: float  # step [s] or relative tolerance: what is swept
    execute: Callable[[int], RunResult]  # repeats the integration from the start, as fast as the
    # engine can


class Engine(Protocol):
    """An engine; its constructor raises EngineUnavailable when it is not installed."""

    name: str
    version: str
    unsupported_scenes: ClassVar[dict[str, str]]  # reason by scene that is not compared with this
    # engine

    def unsupported_reason(self, problem: Problem) -> str | None:
        """Return why the engine cannot model the problem, None when it can."""
        ...

    def runs(self, problem: Problem) -> list[Run]:
        """Return the runs of a sweep over the engine's best methods' settings, coarsest first.

        What needs building (a model, generated C) is built here, once: it is not timed.
        """
        ...


class EngineUnavailable(Exception):
    """The engine is not installed, or lacks what it needs; the message is one line."""


def sweep_values(first: float, last: float, per_decade: int) -> list[float]:
    """Return settings from `first` down to `last`, `per_decade` to a decade."""
    count = round(per_decade * np.log10(first / last))
    return [
        float(setting)
        for setting in first * (last / first) ** (np.arange(count + 1) / max(count, 1))
    ]
