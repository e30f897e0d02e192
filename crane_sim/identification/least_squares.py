"""Least squares of a measured run: Levenberg and Marquardt's method, and weights of joints."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from crane_sim.files.errors import SceneError
from crane_sim.identification.shooting import ORDER_2, Shooting, Unknowns

Array = npt.NDArray[np.float64]
ITERATIONS = 60
LARGEST_STEP = 1.0  # of a logarithm
LARGEST_DAMPING = 1e12
CONVERGED = 1e-9  # relative decrease of the cost, from which on a step is the last one
WEIGHTINGS = 4  # rounds in which the deviations of joints' residuals are estimated
SAME_WEIGHTS = 0.01  # relative change of those deviations that asks for no further round
LEAST_DEVIATION = 1e-9  # of a joint's range: of residuals that are not noise but rounding


class Linear(NamedTuple):
    """Residuals and derivatives at a point over each joint's deviation, 0 where unmeasured."""

    residual: Array  # (K, m), data less prediction
    by_parameter: Array  # (K, m, p), of the prediction
    by_state: Array  # (K, m, 2 n)

    @property
    def cost(self) -> float:
        """Half the sum of squared residuals."""
        return 0.5 * float(np.sum(self.residual**2))

    @property
    def finite(self) -> bool:
        """Whether all runs came to their ends."""
        return all(np.isfinite(table).all() for table in self)

    def parts(self, shooting: Shooting) -> list[tuple[Array, Array, Array]]:
        """Return (residual (r,), by_parameter (r, p), by_state (r, 2 n)) of every segment."""
        p, n = self.by_parameter.shape[2], self.by_state.shape[2]
        spans = [slice(each.first, each.end) for each in shooting.segments]
        tables = [(self.residual[s], self.by_parameter[s], self.by_state[s]) for s in spans]
        return [(r.reshape(-1), a.reshape(-1, p), b.reshape(-1, n)) for r, a, b in tables]


def estimate_noise(q: Array) -> Array:
    """Return the noise (m,) of positions (K, m), from their third differences.

    Third differences of noise have 20 times its variance.
    """
    columns = [column[np.isfinite(column)] for column in q.T]
    return np.maximum(
        [np.std(np.diff(column, 3)) / 20.0**0.5 for column in columns], _least_deviation(q)
    )


def _least_deviation(q: Array) -> Array:
    return np.maximum(LEAST_DEVIATION * (np.nanmax(q, axis=0) - np.nanmin(q, axis=0)), 1e-12)


def subtract_prediction(shooting: Shooting, point: Unknowns) -> Array:
    """Return data less prediction (K, m), 0 where not measured.

    Raises SceneError where the parameters are impossible.
    """
    q = shooting.data.q
    return np.where(np.isfinite(q), q - shooting.predict(point), 0.0)


def estimate_deviation(shooting: Shooting, point: Unknowns) -> Array:
    """Return the standard deviations (m,) of residuals, corrected for the share of unknowns."""
    q = shooting.data.q
    unknowns = (len(point.logarithms) + point.deviations.size) / q.shape[1]
    squares, counts = (
        np.sum(subtract_prediction(shooting, point) ** 2, axis=0),
        np.isfinite(q).sum(axis=0),
    )
    return np.maximum(np.sqrt(squares / np.maximum(1.0, counts - unknowns)), _least_deviation(q))


def evaluate_cost(shooting: Shooting, deviation: Array, point: Unknowns) -> float:
    """Return half the sum of squared residuals; infinite if the scene or its run fails."""
    try:
        residual = subtract_prediction(shooting, point) / deviation
    except SceneError:
        return np.inf
    with np.errstate(over="ignore"):
        squares = float(np.sum(residual**2))
    return 0.5 * squares if np.isfinite(squares) else np.inf


def linearise(
    shooting: Shooting, deviation: Array, point: Unknowns, weights: Mapping[int, float]
) -> Linear:
    """Return residuals and derivatives by differences at a point.

    Raises SceneError where parameters near it are not possible.
    """
    tables = shooting.sensitivities(point, weights)
    there = np.isfinite(shooting.data.q)[:, :, None]
    by_parameter, by_state = (
        np.where(there, table, 0.0) / deviation[None, :, None] for table in tables
    )
    return Linear(subtract_prediction(shooting, point) / deviation, by_parameter, by_state)


def refine(
    shooting: Shooting, deviation: Array, point: Unknowns
) -> tuple[Array, Unknowns, list[int]]:
    """Return (deviations (m,), point, iterations by round) of the reweighted minimum.

    Its weights are from its own residuals.
    """
    counts = list[int]()
    for _ in range(WEIGHTINGS):
        point, count = minimise(shooting, deviation, point, CONVERGED)
        counts.append(count)
        before, deviation = deviation, estimate_deviation(shooting, point)
        if np.all(np.abs(deviation - before) <= SAME_WEIGHTS * before):
            break
    return deviation, point, counts


def minimise(
    shooting: Shooting, deviation: Array, point: Unknowns, converged: float
) -> tuple[Unknowns, int]:
    """Return (the point of least cost, number of iterations), from a point on whose cost is finite.

    Raises:
        SceneError: values near those of the point are not possible.
    """
    at, damping = linearise(shooting, deviation, point, ORDER_2), 1e-3
    if not at.finite:
        raise SceneError(
            "run: near the first guess the simulation fails; give a shorter segment or other values"
        )
    for iteration in range(1, ITERATIONS + 1):
        cost = at.cost
        while damping < LARGEST_DAMPING:
            candidate = _step(shooting, at, point, damping)
            if (there := _improve(shooting, deviation, candidate, cost)) is not None:
                point, at, damping = candidate, there, max(damping / 10.0, 1e-12)
                break
            damping *= 10.0
        if cost - at.cost <= converged * at.cost:
            return point, iteration
    return point, ITERATIONS


def _improve(shooting: Shooting, deviation: Array, point: Unknowns, cost: float) -> Linear | None:
    """Return the derivatives at a point, None if its cost is not less or a run near it fails."""
    if not evaluate_cost(shooting, deviation, point) < cost:
        return None
    try:
        linear = linearise(shooting, deviation, point, ORDER_2)
    except SceneError:
        return None
    return linear if linear.finite else None


def _step(shooting: Shooting, linear: Linear, point: Unknowns, damping: float) -> Unknowns:
    """Return the next point; a QR factorisation per segment eliminates its initial state."""
    parts = linear.parts(shooting)
    norms = np.sqrt(sum(np.sum(p**2, axis=0) for _, p, _ in parts)) + 1e-300
    rows, values, states = [damping**0.5 * np.diag(norms)], [np.zeros(len(norms))], []
    for r, p, x in parts:
        scale = np.maximum(np.linalg.norm(x, axis=0), 1e-9)
        n = len(scale)
        factor, triangle = np.linalg.qr(np.vstack([x, damping**0.5 * np.diag(scale)]))
        p_all, r_all = np.vstack([p, np.zeros((n, p.shape[1]))]), np.concatenate([r, np.zeros(n)])
        rows.append(p_all - factor @ (factor.T @ p_all))
        values.append(r_all - factor @ (factor.T @ r_all))
        states.append((triangle, factor.T @ r_all, factor.T @ p_all))
    step = np.clip(
        np.linalg.lstsq(np.vstack(rows), np.concatenate(values))[0], -LARGEST_STEP, LARGEST_STEP
    )
    moved = [np.linalg.solve(triangle, r - p @ step) for triangle, r, p in states]
    return Unknowns(point.logarithms + step, point.deviations + np.array(moved))
