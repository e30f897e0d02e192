"""Resident memory and rate over a long lockstep run: `crane soak memory`."""

from typing import Any

import numpy as np

from crane_sim.bench import memory
from crane_sim.soak.figures import Figure, at_most

GROWTH = 5.0  # MB that a process may grow after the warm-up
_WARM_UP = 60.0  # s, in short soaks a third of the time


def soak(seconds: float = 1800.0) -> tuple[list[Figure], dict[str, Any]]:
    """Run for so long; return figures, and the data behind them."""
    found = memory.measure(seconds=seconds, warm_up=min(_WARM_UP, seconds / 3.0))
    figures = [Figure("wall time", seconds, "s"), Figure("steps", found["steps"])]
    for node, resident in found["resident"].items():
        figures += [
            Figure(f"{node}, after the warm-up", resident["after_warm_up_MB"], "MB"),
            at_most(f"{node}, growth since", resident["growth_MB"], GROWTH, "MB"),
        ]
    figures += [
        Figure(f"rate in the {name} third", rate, "steps/s")
        for name, rate in zip(("first", "second", "last"), _rates(found), strict=True)
    ]
    return figures, found


def _rates(found: dict[str, Any]) -> list[float]:
    """Return the steps per second of each third of the run."""
    times, steps = np.array(found["sample_times_s"]), np.array(found["sample_steps"])
    edges = np.interp(np.linspace(times[0], times[-1], 4), times, steps)
    return list(np.diff(edges) / max((times[-1] - times[0]) / 3.0, 1e-9))
