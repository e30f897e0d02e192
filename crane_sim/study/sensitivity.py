"""Sensitivity of metrics to the parameters of a study, by SALib.

Morris' design gives mean and spread of a metric's changes by one parameter, for few runs, Saltelli's first-order
and total indices of Sobol, shares of the metric's variance. Both vary probabilities of the parameters' distributions.
"""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.files.errors import SceneError
from crane_sim.study.designs import LEVELS, draw_design, load_salib, salib_problem
from crane_sim.study.result import StudyResult
from crane_sim.study.schema import MORRIS, SALTELLI

CONFIDENCE = 0.95
COLUMN_HEADINGS = {MORRIS: ("μ*", "± 95 %", "σ"), SALTELLI: ("total index", "± 95 %", "of it interaction")}
"""Headings of the columns strength, interval and interaction, by design of sensitivity."""


class Sensitivity(NamedTuple):
    """How a metric depends on a parameter. Intervals are bootstrapped, and are half-widths at 95 %.

    Morris: `strength` is μ*, the mean magnitude of the elementary effects, `interaction` σ, their standard deviation,
    both in the metric's unit. Saltelli: `strength` is the total index, `interaction` what of it is not first-order.
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
        raise SceneError(f"study: design = {study.design}: sensitivities need {MORRIS} or {SALTELLI}")
    if missing := int(np.isnan(y).sum()):
        raise SceneError(f"{metric}: {missing} of {len(y)} runs have none; sensitivities need it of all")
    options = {"conf_level": CONFIDENCE, "seed": study.seed}
    if np.ptp(y) == 0.0:
        return [Sensitivity(key, 0.0, 0.0, 0.0) for key in study.parameters]
    if study.design == MORRIS:
        analysis: Any = load_salib("analyze.morris")
        found = analysis.analyze(salib_problem(study), draw_design(study), y, num_levels=LEVELS, **options)
        columns = found["mu_star"], found["mu_star_conf"], found["sigma"]
    else:
        found = load_salib("analyze.sobol").analyze(salib_problem(study), y, calc_second_order=False, **options)
        columns = found["ST"], found["ST_conf"], np.asarray(found["ST"]) - np.asarray(found["S1"])
    rows = zip(study.parameters, *(np.asarray(column, float).tolist() for column in columns), strict=True)
    return sorted((Sensitivity(*row) for row in rows), key=lambda row: -row.strength)
