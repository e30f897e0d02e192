"""What the benchmark asks of an engine, this one and its peers alike."""

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from crane_sim.evaluation.bench.problem import Problem

Array = npt.NDArray[np.float64]


class Outcome(NamedTuple):
    """Where a run ended, and what it took."""

    payload: Array  # (3,) m, world, z up
    evaluations: int | None  # of the equations; None where the engine does not count them
    steps: int | None
    tension: float | None = None  # N, of an elastic cable at the end; None where it is not requested or not available


class Run(NamedTuple):
    """One way to pass the whole time of a problem."""

    engine: str
    method: str  # of integration, as the engine calls it
    setting: float  # step [s] or relative tolerance: what is swept
    go: Callable[[int], Outcome]  # do it so many times over from the start, as fast as the engine can


class Engine(Protocol):
    """An engine; its constructor raises Missing when it is not there."""

    name: str
    version: str

    def refuses(self, problem: Problem) -> str | None:
        """Return why the engine cannot model the problem, None when it can."""
        ...

    def runs(self, problem: Problem) -> list[Run]:
        """Return the runs of a sweep over the engine's best methods and their settings, coarsest first.

        What needs building (a model, generated C) is built here, once: it is not timed.
        """
        ...


class Missing(Exception):
    """The engine is not installed, or lacks what it needs; one line."""


def sweep_values(first: float, last: float, per_decade: int) -> list[float]:
    """Return settings from `first` down to `last`, so many per decade."""
    count = round(per_decade * np.log10(first / last))
    return [float(setting) for setting in first * (last / first) ** (np.arange(count + 1) / max(count, 1))]
