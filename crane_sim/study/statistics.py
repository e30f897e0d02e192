"""Statistics of runs: intervals of a metric, and paired differences of two variants.

Pairs are runs on the same samples.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt
import scipy  # which imports `scipy.stats` where it is used: that takes a second

CONFIDENCE = 0.95
_RESAMPLES = 9999
_DRAWN = 2**19  # indices of a bootstrap that are in memory at a time, 8 bytes each
# pairs, below which the bootstrap's intervals of the mean are too short: Student's hold them
FEW = 20
MANY = 2000  # pairs, above which the mean is as good as normally distributed
ROUNDING = 1e-12
"""Changes of a metric, by its size, that are not more than rounding."""

Array = npt.NDArray[np.float64]


class PairedDifference(NamedTuple):
    """The paired difference of a metric between two variants, second minus first.

    It is over the samples in which both have the metric.
    """

    pairs: int
    mean: float  # in the metric's unit
    low: float  # ends of the 95 % interval of the mean: Student's of fewer than FEW pairs, normal
    # of more than MANY,
    high: float  # else bootstrapped, bias-corrected and accelerated; the mean where differences do
    # not vary
    effect_size: float  # mean by standard deviation of the differences (Cohen's d_z); NaN where
    # they do not vary
    p_value: float  # Wilcoxon's signed-rank test, two-sided; 1 where no pair differs
    share: float  # of pairs in which the second variant has the smaller metric, ties count half


class FailureDifference(NamedTuple):
    """In which samples runs of two variants fail."""

    first_only: int
    second_only: int
    both: int
    p_value: float  # McNemar's exact test: both variants fail as often; 1 where no sample tells
    # them apart


class IntervalEstimate(NamedTuple):
    """A number with the ends of its 95 % interval."""

    value: float
    low: float
    high: float


def estimate_median(values: Array, seed: int = 0) -> IntervalEstimate:
    """Return the median of values (n,) and its percentiles by bootstrap; values may be infinite.

    Args:
        values: at least one; infinity stands for a run without the metric, which is worse than any
            other.
        seed: of the bootstrap's random numbers.
    """
    n, rng, tail = len(values), np.random.default_rng(seed), (1.0 - CONFIDENCE) / 2.0
    ordered, middles, medians = np.sort(values), ((n - 1) // 2, n // 2), np.empty(_RESAMPLES)
    rows = max(1, _DRAWN // n)
    for start in range(0, _RESAMPLES, rows):
        block = medians[start : start + rows]
        chosen = np.partition(rng.integers(0, n, (len(block), n)), middles, axis=1)
        block[:] = ordered[chosen[:, middles[0]]] / 2.0 + ordered[chosen[:, middles[1]]] / 2.0
    medians.sort()
    k = round(tail * (_RESAMPLES + 1))
    return IntervalEstimate(float(np.median(values)), float(medians[k - 1]), float(medians[-k]))


def estimate_share(count: int, of: int) -> IntervalEstimate:
    """Return the share `count` / `of` with Wilson's score interval (Wilson 1927)."""
    found = scipy.stats.binomtest(count, of).proportion_ci(CONFIDENCE, method="wilson")
    return IntervalEstimate(count / of, float(found.low), float(found.high))


def adjust_p_values(p_values: Sequence[float]) -> list[float]:
    """Return p-values of m tests adjusted by Holm (1979).

    The chance of any false rejection stays at the level.
    """
    adjusted, largest, m = [1.0] * len(p_values), 0.0, len(p_values)
    for rank, i in enumerate(sorted(range(m), key=p_values.__getitem__)):
        largest = max(largest, min(1.0, (m - rank) * p_values[i]))
        adjusted[i] = largest
    return adjusted


def rank_pairs(difference: Array) -> tuple[float, float]:
    """Return (two-sided p of Wilcoxon's signed-rank test, share of negative ones) of (n,) pairs.

    Zeros count half in the share.

    The p-value is 1 where no pair differs.
    """
    p = float(np.asarray(scipy.stats.wilcoxon(difference))[1]) if np.any(difference != 0.0) else 1.0
    return p, float(np.mean(difference < 0.0) + 0.5 * np.mean(difference == 0.0))


def sum_signed_ranks(difference: Array) -> float:
    """Return Wilcoxon's W+ - W- of (n,) differences, without zeros: the sum of signed ranks."""
    some = difference[difference != 0.0]
    return float(np.sum(np.sign(some) * scipy.stats.rankdata(np.abs(some))))


def is_constant(values: Array) -> bool:
    """Return whether numbers (n,) differ by no more than rounding."""
    return bool(np.ptp(values) <= ROUNDING * np.max(np.abs(values)))


def equate_rounded(values: Array, tolerance: float) -> Array:
    """Return numbers (n,), magnitudes within `tolerance` made equal, those as near to 0 zero."""
    order = np.argsort(np.abs(values), kind="stable")
    ordered = np.abs(values)[order]
    first = np.diff(ordered, prepend=0.0) > tolerance  # of equal magnitudes
    magnitudes = np.append(0.0, ordered[first])[np.cumsum(first)]
    equated = np.empty_like(values)
    equated[order] = np.copysign(magnitudes, values[order])
    return equated


def compare_pairs(first: Array, second: Array, seed: int = 0, few: int = FEW) -> PairedDifference:
    """Return the paired difference of a metric (n,) of two variants.

    Samples in which one has no finite value are left out.

    Args:
        first: the metric under the first variant.
        second: the same samples under the second one.
        seed: of the bootstrap's random numbers.
        few: number of pairs below which the interval is Student's.
    """
    both = np.isfinite(first) & np.isfinite(second)
    first, second = first[both], second[both]
    difference, n = second - first, len(first)
    if n == 0:
        return PairedDifference(0, *[np.nan] * 6)
    tolerance = ROUNDING * float(max(np.max(np.abs(first)), np.max(np.abs(second))))
    mean, spread = (
        float(np.mean(difference)),
        float(np.std(difference, ddof=1)) if n > 1 else np.nan,
    )
    varies, equated = spread > tolerance, equate_rounded(difference, tolerance)
    mean = mean if varies else float(np.mean(equated))
    low, high = (
        _interval(difference, seed, few) if varies else (mean, mean) if n > 1 else (np.nan, np.nan)
    )
    effect = mean / spread if varies else np.nan
    return PairedDifference(n, mean, low, high, effect, *rank_pairs(equated))


def _interval(difference: Array, seed: int, few: int) -> tuple[float, float]:
    """Return the ends of the interval of the mean of differences (n,) that vary.

    The bootstrap's time and memory grow with the square of their number; of many differences the
    mean is normal.
    """
    n = len(difference)
    if n > MANY or n < few:
        upper = 0.5 + CONFIDENCE / 2
        quantile = scipy.stats.norm.ppf(upper) if n > MANY else scipy.stats.t.ppf(upper, n - 1)
        half = quantile * np.std(difference, ddof=1) / np.sqrt(n)
        return float(np.mean(difference) - half), float(np.mean(difference) + half)
    rng = np.random.default_rng(seed)
    found = scipy.stats.bootstrap(
        (difference,),
        np.mean,
        n_resamples=_RESAMPLES,
        confidence_level=CONFIDENCE,
        rng=rng,
        batch=100,
    ).confidence_interval
    return float(found.low), float(found.high)


def compare_failures(
    first: npt.NDArray[np.bool_], second: npt.NDArray[np.bool_]
) -> FailureDifference:
    """Return in which of the samples (n,) the runs of two variants fail."""
    only, other = int(np.sum(first & ~second)), int(np.sum(second & ~first))
    p = float(scipy.stats.binomtest(only, only + other, 0.5).pvalue) if only + other else 1.0
    return FailureDifference(only, other, int(np.sum(first & second)), p)
