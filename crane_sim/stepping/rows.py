"""Rows of results: the layout of an instant's results, which loops over control periods write."""

from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system

Array = npt.NDArray[np.float64]


class Rows(NamedTuple):
    """Parts of K rows."""

    q: Array  # (K, nq)
    v: Array  # (K, nq)
    u: Array  # (K, nu), efforts applied
    supplied: Array  # (K,) J, energy supplied since the start by the model's meter, 0 without one
    tensions: Array  # (K, L) N, of the links from the top to the payload


def row_width(model: Any, nq: int, nu: int) -> int:
    """Return the number of floats in a row of a model with nq joint coordinates, nu actuated."""
    return 2 * nq + nu + 1 + system.link_count(model)


def split(rows: Array, nq: int, nu: int) -> Rows:
    """Return the parts of rows (K, width); they are views."""
    after = 2 * nq + nu
    return Rows(
        rows[:, :nq],
        rows[:, nq : 2 * nq],
        rows[:, 2 * nq : after],
        rows[:, after],
        rows[:, after + 1 :],
    )
