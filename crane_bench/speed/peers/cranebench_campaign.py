"""cranebench: its paired design, its records of the wind, and its campaigns of the planar plant by its fast path."""

import time
from collections.abc import Mapping
from importlib import import_module
from importlib.metadata import version
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_bench.speed.engine import EngineUnavailable

Array = npt.NDArray[np.float64]


def find_cranebench_version() -> str:
    """Return the version.

    Raises:
        EngineUnavailable: it is not installed.
    """
    try:
        import_module("cranebench")
    except ImportError as error:
        raise EngineUnavailable(f"cranebench is not installed: {error}") from None
    return version("cranebench")


def make_design(count: int) -> Any:
    """Return its Latin hypercube of so many samples: factors of the plant and the wind, and seeds of the wind."""
    return import_module("cranebench.uncertainty").lhs_design(count)


def wind_records(design: Any, mean: float, duration: float) -> list[Array]:
    """Return the turbulence [m/s] of all samples on its grid, about `mean` [m/s] times the sample's factor."""
    wind, factors = import_module("cranebench.wind"), design.as_dicts()
    records = list[Array]()
    for seed, factor in zip(design.wind_seeds, factors, strict=True):
        parameters = wind.KaimalParams(u_mean=mean * factor["u_mean"])
        records.append(wind.KaimalWind(duration, parameters, np.random.default_rng(int(seed))).turb)
    return records


def run_campaign(design: Any, wind: str, step: float) -> tuple[Mapping[str, Mapping[str, Array]], float]:
    """Return (metrics (n,) by law and name, seconds of the processor) of a campaign, with a step of integration [s]."""
    campaign = import_module("cranebench.runner").Campaign(wind=wind, dt=step).build()
    run = import_module("cranebench.batch").run_campaign_batch
    start = time.process_time()
    metrics = run(campaign, design, progress=False)
    return metrics, time.process_time() - start
