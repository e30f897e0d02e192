"""Cells of the league over samples: metrics with intervals, and which laws a law is better than."""

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_bench.league.cases import GROUPS, Group
from crane_bench.league.cells import LEVEL
from crane_bench.league.samples import TrialStudy, study_of
from crane_sim.study.cases import cases
from crane_sim.study.execution import run
from crane_sim.study.result import StudyResult
from crane_sim.study.runs import FAILED, REFUSED
from crane_sim.study.statistics import (
    IntervalEstimate,
    PairedDifference,
    adjust_p_values,
    compare_pairs,
    estimate_median,
    estimate_share,
    rank_pairs,
    sum_signed_ranks,
)
from crane_sim.study.workers import start_workers

METRICS = ("payload_mae", "payload_residual_error", "residual_swing_deg", "payload_settling")
"""Metrics of a cell; the first one decides which law is better."""
SIGNIFICANCE = 0.05


class SampledCell(NamedTuple):
    """A law in a trial, over samples."""

    crane: str
    law: str
    trial: str
    samples: int
    refused: str  # why the law does not apply to the scene; then there is no metric
    controlled: IntervalEstimate | None = None  # share of samples in which the payload was brought
    # to its goal
    metrics: dict[str, IntervalEstimate] = {}  # medians; infinite where half of the samples have
    # none
    from_best: PairedDifference | None = None  # mean error less that of the law with the least
    # median
    better_than: tuple[str, ...] = ()  # laws of the same trial whose mean error is larger,
    # significantly
    failed: str = ""  # the first reason why a run ended before its time, or why its scene is not
    # possible
    refused_runs: int = 0  # whose scenes are not possible
    failed_runs: int = 0  # that ended before their time


def evaluate_samples(
    samples: int,
    folder: Path,
    groups: Sequence[Group] = GROUPS,
    workers: int | None = None,
    on_progress: Callable[[int, int], None] = lambda *_: None,
) -> Iterator[SampledCell]:
    """Yield the cells of these groups, in order; rows in the folder are not run again.

    Args:
        samples: of each trial.
        folder: where the rows of all trials are.
        groups: cranes, with their laws and trials.
        workers: processes; None: one for each core.
        on_progress: called with (runs that are done, all runs).

    Raises:
        SceneError: the folder holds another league.
    """
    trials = [study_of(group, trial, samples) for group in groups for trial in group.trials]
    count, done = sum(0 if trial.study is None else len(cases(trial.study)) for trial in trials), 0
    with start_workers(workers, None) as pool:
        for trial in trials:
            if trial.study is None:
                yield from (_refused_cell(trial, law, samples) for law in trial.refused)
                continue
            before = done
            result = run(
                trial.study,
                folder / trial.folder,
                workers,
                pool=pool,
                check_first=False,
                on_progress=lambda n, _, before=before: on_progress(before + n, count),
            )
            done += len(result)
            yield from cells_of(trial, result)


def _refused_cell(trial: TrialStudy, law: str, samples: int) -> SampledCell:
    return SampledCell(trial.crane, law, trial.trial, samples, trial.refused[law])


def cells_of(trial: TrialStudy, result: StudyResult) -> list[SampledCell]:
    """Return the cells of a trial's laws from its rows."""
    laws, seed = list(result.study.variant_changes), result.study.seed
    samples = len(result) // len(laws)
    errors = {law: _with_failures(metric_of(result, METRICS[0], law)) for law in laws}
    best = min(laws, key=lambda law: np.median(errors[law]))
    better = better_laws(errors)
    found = [_refused_cell(trial, law, samples) for law in trial.refused]
    for law in laws:
        metrics = {
            name: estimate_median(_with_failures(metric_of(result, name, law)), seed)
            for name in METRICS
        }
        pairs = compare_pairs(
            metric_of(result, METRICS[0], best), metric_of(result, METRICS[0], law), seed, few=0
        )
        controlled = estimate_share(int(is_controlled(result, law).sum()), samples)
        cell = SampledCell(trial.crane, law, trial.trial, samples, "", controlled, metrics)
        difference = None if law == best and np.isfinite(np.median(errors[law])) else pairs
        status = _of_law(result, "status", law)
        refused_runs, failed_runs = int(np.sum(status == REFUSED)), int(np.sum(status == FAILED))
        cell = cell._replace(
            failed=_first_error(result, law), refused_runs=refused_runs, failed_runs=failed_runs
        )
        found.append(cell._replace(from_best=difference, better_than=better[law]))
    return found


def metric_of(result: StudyResult, name: str, law: str) -> npt.NDArray[np.float64]:
    """Return a metric (n,) of a law's runs, NaN of failed ones.

    A table of failed runs only has no such column.
    """
    n = len(result) // len(result.study.variant_changes)
    return result.metric(name, law) if name in result.types else np.full(n, np.nan)


def _with_failures(values: npt.NDArray[np.float64]) -> npt.NDArray[np.float64]:
    """Return a metric (n,) with infinity for runs that have none."""
    return np.where(np.isnan(values), np.inf, values)


def is_controlled(result: StudyResult, law: str) -> npt.NDArray[np.bool_]:
    """Return in which samples (n,) a law brought the payload to its goal.

    The run reached its end, its rope never swung to the horizontal, and its payload settled.
    """
    settled = ~np.isnan(metric_of(result, "payload_settling", law))
    # NaN, of a run that failed, is not less
    return settled & (metric_of(result, "peak_swing_deg", law) < LEVEL)


def _first_error(result: StudyResult, law: str) -> str:
    return next((str(error) for error in _of_law(result, "error", law) if error), "")


def _of_law(result: StudyResult, column: str, law: str) -> npt.NDArray[Any]:
    """Return the entries (n,) of a column for the runs of a law."""
    return result.column(column)[result.column("variant") == law]


def better_laws(errors: dict[str, npt.NDArray[np.float64]]) -> dict[str, tuple[str, ...]]:
    """Return which laws each law is better than.

    Each pair of laws has Wilcoxon's test, adjusted by Holm for all pairs.

    Args:
        errors: of each law in the same samples (n,), infinite where a run failed, which is worse
            than any number.
    """
    pairs = list(combinations(errors, 2))
    differences = [_paired_differences(errors[first], errors[second]) for first, second in pairs]
    p_values = adjust_p_values([rank_pairs(difference)[0] for difference in differences])
    better: dict[str, tuple[str, ...]] = dict.fromkeys(errors, ())
    for (first, second), p, difference in zip(pairs, p_values, differences, strict=True):
        excess = sum_signed_ranks(difference)
        if p < SIGNIFICANCE and excess != 0.0:
            ahead, behind = (second, first) if excess < 0.0 else (first, second)
            better[ahead] = (*better[ahead], behind)
    return better


def _paired_differences(
    first: npt.NDArray[np.float64], second: npt.NDArray[np.float64]
) -> npt.NDArray[np.float64]:
    """Return second less first (n,), for ranks.

    A failure counts more than any number; two failures are equal.
    """
    finite = [*first[np.isfinite(first)], *second[np.isfinite(second)]]
    worst = 10.0 * max(np.abs(finite), default=1.0) + 1.0
    return np.where(np.isinf(second), worst, second) - np.where(np.isinf(first), worst, first)
