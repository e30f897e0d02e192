"""Derivatives of smooth predictions by forward mode: one integration has those by several unknowns.

A prediction is smooth where nothing switches the equations and drives apply their commands. Steps
are differentiated as they were taken, so these are the derivatives of the numbers that the
simulation gives, to rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim import system
from crane_sim.integrators.rodas import Rodas
from crane_sim.numerics.derivatives import DIRECTIONS
from crane_sim.scenes.hardware_settings import is_nonideal
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.columns import stack_columns
from crane_sim.stepping.excitation import Excitation, differentiate_held
from crane_sim.tracing.trees import rebuilt

Array = npt.NDArray[np.float64]


def is_smooth(scene: Scene) -> bool:
    """Return whether predictions of a scene have derivatives.

    Steps of `Rodas` use derivatives themselves.
    """
    plain = system.switching(scene.model) is None and not is_nonideal(scene.hardware)
    return plain and not isinstance(scene.method, Rodas)


class Start(NamedTuple):
    """The start of a segment, and its derivatives by all unknowns.

    The number of unknowns is a multiple of DIRECTIONS.
    """

    q: Array  # (nq,)
    v: Array  # (nq,)
    q_slopes: Array  # (nq, unknowns)
    v_slopes: Array  # (nq, unknowns)


def slopes_of_models(models: Sequence[Any], weights: Array, unknowns: int) -> Any:
    """Return the derivatives (…, unknowns) of a model's numbers, in its tree's structure.

    It is None where no unknown changes the number.

    A model is made by code that is no function of numbers alone: its numbers have differences.

    Args:
        models: for each of the first unknowns those of which differences are taken.
        weights: of these (k,).
        unknowns: their number; the model depends on the first ones only.

    Raises:
        SceneError: the models are not of one kind.
    """
    return _slopes(stack_columns(models), weights, unknowns)


def _slopes(columns: Any, weights: Array, unknowns: int) -> Any:
    if isinstance(columns, tuple):
        parts = [_slopes(part, weights, unknowns) for part in columns]
        return rebuilt(columns, parts) if any(part is not None for part in parts) else None
    if columns is None or np.all(columns == columns[0]):
        return None
    values = columns.reshape(-1, len(weights), *columns.shape[1:])
    slopes = np.zeros((*columns.shape[1:], unknowns))
    slopes[..., : len(values)] = np.moveaxis(np.tensordot(weights, values, ([0], [1])), 0, -1)
    return slopes


def fill_derivatives(
    method: Any,
    model: Any,
    of_model: Any,
    excitations: Sequence[Excitation],
    starts: Sequence[Start],
    out: Array,
) -> None:
    """Fill `out` (n, nq, unknowns) with derivatives of joint positions at segments' instants.

    Args:
        method, model: settings of the integrator, the crane.
        of_model: of `slopes_of_models`.
        excitations, starts: of each segment.
        out: to fill up to where the integration fails.
    """
    n, nq, unknowns = out.shape
    positions = np.empty((n, nq))
    for first in range(0, unknowns, DIRECTIONS):
        slopes, own = np.full((n, nq, DIRECTIONS), np.nan), _directions(of_model, first)
        for excitation, (*start, of_q, of_v) in zip(excitations, starts, strict=True):
            # as derivatives demand; they may be columns of a larger array
            q, v = map(np.ascontiguousarray, start)
            directions = (own, *(_directions(each, first) for each in (of_q, of_v)), slopes)
            differentiate_held(method, model, excitation, q, v, positions, directions)
        out[..., first : first + DIRECTIONS] = slopes


def _directions(slopes: Any, first: int) -> Any:
    """Return the DIRECTIONS of a tree of derivatives from number `first` on."""
    if isinstance(slopes, tuple):
        return rebuilt(slopes, [_directions(part, first) for part in slopes])
    return None if slopes is None else np.ascontiguousarray(slopes[..., first : first + DIRECTIONS])
