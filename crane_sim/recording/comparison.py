"""Runs of one crane side by side: metrics, and differences of all quantities on common time."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.recording.read import as_recorded, read_recording
from crane_sim.recording.run import RecordedRun

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from crane_sim.recording.layout import Array
    from crane_sim.simulation.rollout import Rollout

COMPUTATION_METRICS = (
    "wall_time",
    "compile_time",
    "steps_per_second",
    "real_time_factor",
    "rhs_evaluations",
    "recorded_steps",
)
"""Entries of a summary on how it was computed, which are not compared."""
HELD_PREFIXES = ("u.", "command.", "reference.")
"""Prefixes of the quantities that hold over a control period; the others are interpolated
linearly."""
TIME_TOLERANCE = 1e-9
"""Seconds by which rounding may separate two equal times."""


class Difference(NamedTuple):
    """How far a quantity of a run is from the first run's, at the steps of the common time."""

    unit: str
    largest: float  # absolute value, unit
    at: float  # s, when that is
    rms: float  # unit, root of the mean square


@dataclass(frozen=True, repr=False)
class Comparison:
    """Runs of one crane, compared with the first of them."""

    runs: tuple[RecordedRun, ...]  # n
    names: tuple[str, ...]  # (n,)
    t: Array  # (K,) s, steps of the first run within the time that all runs have; others are
    # interpolated linearly
    metrics: dict[str, tuple[float | None, ...]]  # (n,) values by name, None where a run has no
    # such metric
    differences: tuple[dict[str, Difference], ...]  # (n - 1,) by quantity, see RecordedRun.columns,
    # and of `payload`
    not_compared: tuple[tuple[str, ...], ...]  # (n - 1,) quantities that only one of two runs has
    # as finite numbers

    def __repr__(self) -> str:
        """Return names and common time in one line."""
        return (
            f"<Comparison of {', '.join(self.names)}: {len(self.t)} steps, {self.t[0]:g} .. "
            f"{self.t[-1]:g} s>"
        )

    def metric_differences(self, i: int) -> dict[str, float]:
        """Return the metrics of run i minus those of the first run, where both have them."""
        pairs = {name: (values[0], values[i]) for name, values in self.metrics.items()}
        return {name: b - a for name, (a, b) in pairs.items() if a is not None and b is not None}

    def to_dict(self) -> dict[str, Any]:
        """Return all of it but the runs, as plain data."""
        return {
            "runs": list(self.names),
            "status": [run.status for run in self.runs],
            "real_time_violation": [run.real_time_violation for run in self.runs],
            "interval": [float(self.t[0]), float(self.t[-1])],
            "metrics": {name: list(values) for name, values in self.metrics.items()},
            "metric_differences": [self.metric_differences(i) for i in range(1, len(self.runs))],
            "differences": [
                {name: each._asdict() for name, each in one.items()} for one in self.differences
            ],
            "not_compared": [list(names) for names in self.not_compared],
        }


def compare(*runs: RecordedRun | Rollout | Path | str, names: Sequence[str] = ()) -> Comparison:
    """Return the comparison of two or more runs of one crane with the first of them.

    Args:
        runs: recorded runs, runs of `simulate`, or paths of recordings.
        names: of the runs; default: those of their files, or scenes.

    Raises:
        SceneError: there are fewer than two, a file is no recording, the cranes are different, or
            no time is common.
    """
    if len(runs) < 2:
        raise SceneError(
            f"compare: needs two runs or more, here {'is one' if runs else 'are none'}"
        )
    read = tuple(_read_run(run) for run in runs)
    if names and len(names) != len(runs):
        raise SceneError(f"names = {list(names)}: must be one for each of {len(runs)} runs")
    labels = tuple(names) or _label_runs(read)
    for run, name in zip(read[1:], labels[1:], strict=True):
        _check_same_crane(read[0], labels[0], run, name)
    t = _common_time(read)
    differences = tuple(_compare_columns(read[0], run, t) for run in read[1:])
    not_compared = tuple(
        _not_compared(read[0], *pair) for pair in zip(read[1:], differences, strict=True)
    )
    return Comparison(read, labels, t, _collect_metrics(read), differences, not_compared)


def _read_run(run: RecordedRun | Rollout | Path | str) -> RecordedRun:
    if isinstance(run, RecordedRun):
        return run
    if isinstance(run, Path | str):
        return read_recording(Path(run))
    if not run.summary["steps"]:
        raise SceneError(
            f"compare: a run of {run.scene.name} has no steps: "
            f"{run.summary.get('error', 'none was taken')}"
        )
    return as_recorded(run)


def _label_runs(runs: Sequence[RecordedRun]) -> tuple[str, ...]:
    """Return the names of files or scenes; equal names get the files' suffixes, or numbers."""
    names = [run.path.stem if run.path else run.name for run in runs]
    files = [run.path.name if run.path else run.name for run in runs]
    pairs = zip(names, files, strict=True)
    labels = [
        file if names.count(name) > 1 and files.count(file) == 1 else name for name, file in pairs
    ]
    return tuple(
        f"{label} ({i + 1})" if labels.count(label) > 1 else label for i, label in enumerate(labels)
    )


def _check_same_crane(first: RecordedRun, first_name: str, run: RecordedRun, name: str) -> None:
    """Raise SceneError where two runs are of different cranes."""
    for a, b in (
        (first.crane.kind, run.crane.kind),
        (first.crane.joint_names, run.crane.joint_names),
    ):
        if a != b:
            what = [x if isinstance(x, str) else ", ".join(x) for x in (b, a)]
            raise SceneError(
                f"{name} is of {what[0]}, {first_name} of {what[1]}: only runs of one crane are "
                "compared"
            )


def _common_time(runs: Sequence[RecordedRun]) -> Array:
    """Return the steps (K,) [s] of the first run within the time that all runs have."""
    if not all(len(run.t) for run in runs):
        raise SceneError("compare: a run without steps; there is nothing to compare")
    begin, end = max(run.t[0] for run in runs), min(run.t[-1] for run in runs)
    t = runs[0].t[(runs[0].t >= begin) & (runs[0].t <= end)]
    if not len(t):
        raise SceneError(
            f"compare: the runs have no common time, all have begun at {begin:g} s, one ends at "
            f"{end:g} s"
        )
    return t


def _compare_columns(first: RecordedRun, run: RecordedRun, t: Array) -> dict[str, Difference]:
    """Return the differences of all quantities that are finite in both runs.

    That of `payload` is a distance.
    """
    reference, other = first.columns(), run.columns()
    columns = {}
    for name in (name for name in reference if name in other):
        (a, unit), (b, _) = reference[name], other[name]
        sample = _hold if name.startswith(HELD_PREFIXES) else np.interp
        columns[name] = unit, sample(t, run.t, b) - sample(t, first.t, a)
    distance = np.sqrt(sum(np.square(columns[f"payload.{axis}"][1]) for axis in "xyz"))
    columns = {"payload": ("m", distance)} | columns
    return {
        name: _difference(unit, t, values)
        for name, (unit, values) in columns.items()
        if np.isfinite(values).all()
    }


def _difference(unit: str, t: Array, values: Array) -> Difference:
    k = int(np.argmax(np.abs(values)))
    return Difference(
        unit, float(abs(values[k])), float(t[k]), float(np.sqrt(np.mean(values * values)))
    )


def _not_compared(
    first: RecordedRun, run: RecordedRun, differences: Mapping[str, Difference]
) -> tuple[str, ...]:
    """Return the quantities of either run that are not among the differences."""
    return tuple(name for name in first.columns() | run.columns() if name not in differences)


def _hold(t: Array, steps: Array, values: Array) -> Array:
    """Return values at times t (K,), each held from its step on, with tolerance for rounding."""
    return values[np.searchsorted(steps, t + TIME_TOLERANCE, side="right") - 1]


def _collect_metrics(runs: Sequence[RecordedRun]) -> dict[str, tuple[float | None, ...]]:
    flat = [dict(_numbers_of(run.summary)) for run in runs]
    names = dict.fromkeys(name for each in flat for name in each)
    return {name: tuple(each.get(name) for each in flat) for name in names}


def _numbers_of(summary: Mapping[str, Any]) -> list[tuple[str, float]]:
    """Return (name, value) of all numbers of a summary, those of joints as NAME.JOINT."""
    numbers = []
    for key, value in summary.items():
        inner = value.items() if isinstance(value, dict) else [("", value)]
        for part, number in inner:
            if (
                key not in COMPUTATION_METRICS
                and isinstance(number, int | float)
                and not isinstance(number, bool)
            ):
                numbers.append((f"{key}.{part}" if part else key, float(number)))
    return numbers
