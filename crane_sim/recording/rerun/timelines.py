"""The two timelines of a recording: scene time and the number of the control step."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import rerun as rr

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.recording.layout import Layout


def times(layout: Layout, step: NDArray[np.int64]) -> list[rr.TimeColumn]:
    """Return the instants at which these steps begin; the scene time is exact, in nanoseconds."""
    return times_at(layout, (step - 1) * layout.period_ns)


def times_at(layout: Layout, instants: NDArray[np.int64]) -> list[rr.TimeColumn]:
    """Return instants [ns] of scene time, with the steps in which they are."""
    elapsed = instants.astype("timedelta64[ns]")
    return [
        rr.TimeColumn("sim_time", duration=elapsed),
        rr.TimeColumn("step", sequence=1 + instants // layout.period_ns),
    ]


def time_columns(t: NDArray[np.float64]) -> list[rr.TimeColumn]:
    """Return times (K,) [s] of scene time alone, for runs whose steps differ."""
    return [rr.TimeColumn("sim_time", duration=np.rint(1e9 * t).astype("timedelta64[ns]"))]


def set_time(rec: rr.RecordingStream, layout: Layout, step: int) -> None:
    """Let what is logged next belong to the beginning of a step."""
    rec.set_time("sim_time", duration=(step - 1) * layout.period_ns * 1e-9)
    rec.set_time("step", sequence=step)
