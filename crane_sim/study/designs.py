"""Designs of a study: the probabilities at which the parameters' values are quantiles.

Morris' design changes one parameter at a time along paths through a grid of four levels, Saltelli's
crosses two Sobol sequences: from them `sensitivity` finds how metrics depend on the parameters.
"""

from math import prod
from typing import Any

import numpy as np
import numpy.typing as npt
import scipy  # which imports `scipy.stats` where it is used

from crane_sim.files.installation import import_optional
from crane_sim.study.schema import MORRIS, SALTELLI, Study, Values

LEVELS = 4
"""Levels of Morris' grid, with steps of 2/3 of it, as Morris (1991) has them."""

Array = npt.NDArray[np.float64]


def sample_count(study: Study) -> int:
    """Return how many samples of the parameters the study's design has."""
    d, n = len(study.parameters), study.samples
    if n is None:
        return prod(
            len(each.values) for each in study.parameters.values() if isinstance(each, Values)
        )
    return n * {MORRIS: d + 1, SALTELLI: d + 2}.get(study.design, 1)


def draw_probabilities(study: Study) -> Array:
    """Return the probabilities (samples, parameters) in (0, 1) of every design but the grid.

    Raises:
        SceneError: the design needs a package that is not installed.
    """
    d, n, seed = len(study.parameters), study.samples or 1, study.seed
    match study.design:
        case "monte_carlo":
            p = np.random.default_rng(seed).random((n, d))
        case "latin_hypercube":
            p = scipy.stats.qmc.LatinHypercube(d, rng=seed).random(n)
        case "sobol":
            p = scipy.stats.qmc.Sobol(d, rng=seed).random(n)
        case "morris":  # the middles of quarters, finite values of unbounded distributions, too
            p = (draw_design(study) * (LEVELS - 1) + 0.5) / LEVELS
        case _:
            p = draw_design(study)
    return np.clip(p, 2.0**-53, 1.0 - 2.0**-53)


def draw_design(study: Study) -> Array:
    """Return a design of sensitivity (samples, parameters) in 0 .. 1.

    Raises:
        SceneError: SALib is not installed.
    """
    if study.design == MORRIS:
        return load_salib("sample.morris").sample(
            salib_problem(study), study.samples, LEVELS, seed=study.seed
        )
    return load_salib("sample.sobol").sample(
        salib_problem(study), study.samples, calc_second_order=False, seed=study.seed
    )


def salib_problem(study: Study) -> dict[str, Any]:
    """Return the parameters of a study as SALib names them."""
    d = len(study.parameters)
    return {"num_vars": d, "names": list(study.parameters), "bounds": [[0.0, 1.0]] * d}


def load_salib(module: str) -> Any:
    """Return a module of SALib, which only designs of sensitivity need.

    Raises:
        SceneError: it is not installed.
    """
    return import_optional(f"SALib.{module}", "a design of sensitivity")
