"""Statistics of paired runs against closed forms and known coverage."""

from math import isnan

import numpy as np
import pytest

from crane_sim.study.statistics import compare_failures, compare_pairs


def test_a_known_offset_is_found() -> None:
    """Differences that do not vary have their value as mean and interval; missing values are left out."""
    first = np.array([1.0, 2.0, np.nan, 4.0, 5.0])
    found = compare_pairs(first, first + np.array([0.5, 0.5, 0.5, np.nan, 0.5]))
    assert (found.pairs, found.mean, found.low, found.high, found.share) == (3, 0.5, 0.5, 0.5, 0.0)
    assert isnan(found.effect_size)
    same = compare_pairs(first, first)
    assert (same.pairs, same.mean, same.p_value, same.share) == (4, 0.0, 1.0, 0.5)
    assert compare_pairs(first[:0], first[:0]).pairs == 0


def test_wilcoxon_of_one_sided_differences_is_its_closed_form() -> None:
    """Of n differences of one sign the exact two-sided test has p = 2 / 2^n: only one assignment is as extreme."""
    n = 10
    found = compare_pairs(np.zeros(n), np.arange(1.0, n + 1.0))
    assert found.p_value == pytest.approx(2.0 / 2**n, rel=1e-12)  # rounding of the sum of ranks' probabilities


def test_effect_size_is_mean_by_deviation() -> None:
    """Cohen's d_z is the differences' mean by their standard deviation."""
    difference = np.array([1.0, 2.0, 3.0, 4.0])
    assert compare_pairs(np.zeros(4), difference).effect_size == pytest.approx(2.5 / (5.0 / 3.0) ** 0.5, rel=1e-12)


def test_the_interval_covers() -> None:
    """Of 200 samples of 40 differences 95 % of intervals have the true mean inside, within four standard errors."""
    rng, trials = np.random.default_rng(5), 200
    inside = 0
    for i in range(trials):
        found = compare_pairs(np.zeros(40), rng.normal(0.3, 1.0, 40), seed=i)
        inside += found.low <= 0.3 <= found.high
    assert abs(inside / trials - 0.95) < 4.0 * (0.95 * 0.05 / trials) ** 0.5


def test_mcnemar_is_the_binomial_test_of_discordant_samples() -> None:
    """Of 6 samples that only one variant fails p = 2 / 2^6; samples in which both fail say nothing."""
    first = np.array([True] * 6 + [True] * 3 + [False] * 3)
    second = np.array([False] * 6 + [True] * 3 + [False] * 3)
    found = compare_failures(first, second)
    assert (found.first_only, found.second_only, found.both) == (6, 0, 3)
    assert found.p_value == pytest.approx(2.0 / 2**6, rel=1e-12)
    assert compare_failures(second, second).p_value == 1.0
