"""Sensitivity of metrics to the parameters of a study, by SALib.

Morris' design gives mean and spread of a metric's changes by one parameter, for few runs,
Saltelli's first-order and total indices of Sobol, shares of the metric's variance. Both vary
probabilities of the parameters' distributions.
"""

import warnings
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.files.errors import SceneError
from crane_sim.study.designs import LEVELS, draw_design, load_salib, salib_problem
from crane_sim.study.result import StudyResult
from crane_sim.study.schema import MORRIS, SALTELLI, Study
from crane_sim.study.statistics import is_constant

CONFIDENCE = 0.95
COLUMN_HEADINGS = {
    MORRIS: ("μ*", "± 95 %", "σ"),
    SALTELLI: ("total index", "± 95 %", "of it interaction"),
}
"""Headings of the columns strength, interval and interaction, by design of sensitivity."""


class Sensitivity(NamedTuple):
    """How a metric depends on a parameter. Intervals are bootstrapped, and are half-widths at 95 %.

    Morris: `strength` is μ*, the mean magnitude of the elementary effects, `interaction` σ, their
    standard deviation, both of changes over the whole range of a probability, in the metric's unit;
    of one path, interval and σ are NaN.
    Saltelli: `strength` is the total index, `interaction` what of it is not first-order.
    """

    parameter: str
    strength: float
    interval: float
    interaction: float


def sensitivities(result: StudyResult, metric: str, variant: str) -> list[Sensitivity]:
    """Return how a metric depends on each parameter under a variant, the strongest first.

    Raises:
        SceneError: the study has another design, there is no such metric, or runs without it.
    """
    study, y = result.study, result.metric(metric, variant)
    if study.design not in (MORRIS, SALTELLI):
        raise SceneError(
            f"study: design = {study.design}: sensitivities need {MORRIS} or {SALTELLI}"
        )
    if missing := int(np.sum(~np.isfinite(y))):
        raise SceneError(
            f"{metric}: {missing} of {len(y)} runs have none; sensitivities need it of all"
        )
    options = {"conf_level": CONFIDENCE, "seed": study.seed}
    if is_constant(y):
        return [Sensitivity(key, 0.0, 0.0, 0.0) for key in study.parameters]
    if study.design == MORRIS:
        columns = _analyse_elementary_effects(study, y, options)
    else:
        found = load_salib("analyze.sobol").analyze(
            salib_problem(study), y, calc_second_order=False, **options
        )
        columns = found["ST"], found["ST_conf"], np.asarray(found["ST"]) - np.asarray(found["S1"])
    rows = zip(
        study.parameters, *(np.asarray(column, float).tolist() for column in columns), strict=True
    )
    return sorted((Sensitivity(*row) for row in rows), key=lambda row: -row.strength)


def _analyse_elementary_effects(
    study: Study, y: npt.NDArray[np.float64], options: dict[str, Any]
) -> Any:
    """Return (μ*, half-widths of its intervals, σ) of a metric (runs,) by Morris' method.

    SALib takes the levels as 0 … 1, where probabilities are from 1 / (2 LEVELS) to 1 - 1 / (2
    LEVELS).
    """
    scale = LEVELS / (LEVELS - 1)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # of one path, which has no spread
        found = load_salib("analyze.morris").analyze(
            salib_problem(study), draw_design(study), y, num_levels=LEVELS, **options
        )
    spread = scale if study.samples != 1 else np.nan
    factors = {"mu_star": scale, "mu_star_conf": spread, "sigma": spread}
    return [factor * np.asarray(found[key], float) for key, factor in factors.items()]
