"""Statistics of runs against closed forms and known coverage."""

from math import isnan

import numpy as np
import pytest

from crane_sim.study.statistics import (
    adjust_p_values,
    compare_failures,
    compare_pairs,
    estimate_median,
    estimate_share,
)


def test_a_known_offset_is_found() -> None:
    """Constant differences are their own mean and interval; missing values are left out."""
    first = np.array([1.0, 2.0, np.nan, 4.0, 5.0])
    found = compare_pairs(first, first + np.array([0.5, 0.5, 0.5, np.nan, 0.5]))
    assert (found.pairs, found.mean, found.low, found.high, found.share) == (3, 0.5, 0.5, 0.5, 0.0)
    assert isnan(found.effect_size)
    same = compare_pairs(first, first)
    assert (same.pairs, same.mean, same.p_value, same.share) == (4, 0.0, 1.0, 0.5)
    assert compare_pairs(first[:0], first[:0]).pairs == 0


@pytest.mark.filterwarnings("error")
def test_differences_that_vary_by_rounding_do_not_vary() -> None:
    """An offset of 0.05 but for the last bits is its own interval.

    The p-value is that of equal differences.
    """
    first = np.linspace(0.1, 0.5, 12)
    found, exact = (
        compare_pairs(first, first + 0.05),
        compare_pairs(np.zeros(12), np.full(12, 0.05)),
    )
    assert np.ptp(first + 0.05 - first) > 0.0
    assert found.low == found.mean == found.high == pytest.approx(0.05, abs=1e-15) and isnan(
        found.effect_size
    )
    assert found.p_value == exact.p_value
    assert compare_pairs(np.zeros(4), np.arange(1.0, 5.0)).effect_size == pytest.approx(
        2.5 / (5.0 / 3.0) ** 0.5
    )
    noise = compare_pairs(first, first * (1.0 + np.finfo(float).eps * np.arange(-6.0, 6.0)))
    assert (noise.p_value, noise.share) == (1.0, 0.5)


def test_wilcoxon_of_one_sided_differences_is_its_closed_form() -> None:
    """Of n differences of one sign the exact two-sided test has p = 2 / 2^n.

    Only one assignment is as extreme.
    """
    n = 10
    found = compare_pairs(np.zeros(n), np.arange(1.0, n + 1.0))
    # rounding of the sum of ranks' probabilities
    assert found.p_value == pytest.approx(2.0 / 2**n, rel=1e-12)


def test_the_interval_covers() -> None:
    """95 % of intervals hold the true mean, within four standard errors.

    There are 100 samples of 40 differences.
    """
    rng, trials = np.random.default_rng(5), 100
    inside = 0
    for i in range(trials):
        found = compare_pairs(np.zeros(40), rng.normal(0.3, 1.0, 40), seed=i)
        inside += found.low <= 0.3 <= found.high
    assert abs(inside / trials - 0.95) < 4.0 * (0.95 * 0.05 / trials) ** 0.5


@pytest.mark.parametrize("n", [2, 8])
def test_the_interval_of_few_pairs_covers(n: int) -> None:
    """95 % of intervals of few pairs hold the true mean, within four standard errors.

    There are 400 samples of normal differences.
    """
    rng, trials = np.random.default_rng(n), 400
    found = [compare_pairs(np.zeros(n), rng.normal(0.3, 1.0, n)) for _ in range(trials)]
    inside = sum(each.low <= 0.3 <= each.high for each in found)
    assert abs(inside / trials - 0.95) < 4.0 * (0.95 * 0.05 / trials) ** 0.5


def test_mcnemar_is_the_binomial_test_of_discordant_samples() -> None:
    """Of 6 samples that only one variant fails p = 2 / 2^6.

    Samples in which both fail say nothing.
    """
    first = np.array([True] * 6 + [True] * 3 + [False] * 3)
    second = np.array([False] * 6 + [True] * 3 + [False] * 3)
    found = compare_failures(first, second)
    assert (found.first_only, found.second_only, found.both) == (6, 0, 3)
    assert found.p_value == pytest.approx(2.0 / 2**6, rel=1e-12)
    assert compare_failures(second, second).p_value == 1.0


def test_the_interval_of_a_median_covers() -> None:
    """About 95 % of the intervals hold the true median; infinite values count.

    There are 200 samples of 41 normal values.

    The percentiles' own error is about 1 % at this size; four standard errors of the count beside
    it.
    """
    rng, trials = np.random.default_rng(8), 200
    inside = sum(
        (found := estimate_median(rng.normal(0.3, 1.0, 41), seed=i)).low <= 0.3 <= found.high
        for i in range(trials)
    )
    assert abs(inside / trials - 0.95) < 0.01 + 4.0 * (0.95 * 0.05 / trials) ** 0.5
    found = estimate_median(np.array([1.0, 2.0, 3.0, np.inf]))
    assert found.value == 2.5 and found.low >= 1.0 and found.high == np.inf


def test_the_bootstrap_of_a_median_of_three_is_its_closed_form() -> None:
    """The bootstrapped median of three values is the least one with probability 7/27.

    So both ends of the interval are extremes.
    """
    assert estimate_median(np.array([1.0, 2.0, 5.0])) == (2.0, 1.0, 5.0)
    assert estimate_median(np.array([4.0])) == (4.0, 4.0, 4.0)


def test_shares_have_wilsons_interval() -> None:
    """The score interval of 8 of 10 is 0.4902 to 0.9433.

    Without a success it begins at 0 and ends at z² / (n + z²).
    """
    # digits that are written
    assert estimate_share(8, 10) == pytest.approx((0.8, 0.490162, 0.943318), abs=1e-6)
    z2 = 1.959963984540054**2
    assert estimate_share(0, 10) == pytest.approx((0.0, 0.0, z2 / (10.0 + z2)), abs=1e-12)


def test_p_values_are_adjusted_by_holm() -> None:
    """The least of m p-values is multiplied by m, the next by m - 1, and so on (Holm 1979).

    None falls below the one before.
    """
    assert adjust_p_values([0.01, 0.04, 0.03, 0.005]) == pytest.approx(
        [0.03, 0.06, 0.06, 0.02], rel=1e-12
    )
    assert adjust_p_values([]) == []
