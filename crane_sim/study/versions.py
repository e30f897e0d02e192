"""Versions of what computes the numbers of a study."""

import hashlib
from functools import cache
from pathlib import Path

from crane_sim.recording.provenance import of_this_process
from crane_sim.simulation import (
    batch_metrics,
    derived,
    energy_balance,
    flat_summary,
    metrics,
    rollout,
    settling,
    totals,
)

MODULES = (batch_metrics, derived, energy_balance, flat_summary, metrics, rollout, settling, totals)
"""Modules of `crane_sim.simulation` that compute the metrics of a run."""


@cache
def versions() -> dict[str, str]:
    """Return versions of packages, system and processor, and the hash of the source of the metrics."""
    source = b"".join(Path(str(module.__file__)).read_bytes() for module in MODULES)
    return of_this_process() | {"metrics_sha256": hashlib.sha256(source).hexdigest()}


def deciding_versions() -> dict[str, str]:
    """Return the versions that a study's processes have to share; the processor may differ, as in a cluster."""
    return {key: value for key, value in versions().items() if key not in ("cpu", "system")}
