"""Parameters of a scene from a measured run: estimates, covariance, intervals and warnings."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, NoReturn

import numpy as np
import numpy.typing as npt
import scipy  # which imports `scipy.stats` where it is used

from crane_sim.files.errors import SceneError
from crane_sim.identification.least_squares import (
    ITERATIONS,
    Linear,
    estimate_noise,
    evaluate_cost,
    linearise,
    minimise,
    refine,
)
from crane_sim.identification.measurements import (
    Measurements,
    Source,
    choose_joints,
    measurements_of,
)
from crane_sim.identification.shooting import ORDER_6, Shooting, Unknowns
from crane_sim.scenes.scene import Scene, SceneSource, load_scene

Array = npt.NDArray[np.float64]
SEGMENT = 5.0  # s
LEVEL = 0.95  # of the intervals
# by which segments are shorter than asked, in fits that lead to its first guess
RUNGS = (16.0, 4.0, 2.0, 1.0)
ROUGHLY = 1e-3  # relative decrease of the cost that ends those
# condition number of the sensitivities from which the information matrix counts as singular
ILL_CONDITIONED = 1e8
INVOLVED = 0.1  # least entry of its null vector, of the largest one, of a parameter that is named
SILENT = 12.0  # range of a joint by its noise up to which it rests: that of 10^8 samples of noise
# standard deviation of a parameter by its value from which it counts as without influence
UNDETERMINED = 1.0
ROUNDING = 1e-12  # of a value: what is smaller is rounding of the simulation, not of the data
CORRELATED = 0.2  # of successive residuals, from which they are not noise


class Estimate(NamedTuple):
    """One parameter."""

    key: str  # dotted, of the scene
    start: float  # the scene's value
    value: float
    deviation: float  # standard deviation of the value
    low: float  # the interval in which the true value lies at a confidence of 95 %
    high: float


@dataclass(frozen=True)
class Identification:
    """The parameters with which a scene repeats a measured run best."""

    guess: Scene  # the one with the first guess
    estimates: tuple[Estimate, ...]  # (p,) key, start, value, deviation, low, high of each
    # parameter
    covariance: Array  # (p, p) of the values
    correlation: Array  # (p, p) -
    condition: float  # condition number of the sensitivities, their columns scaled to length 1
    residual: dict[str, float]  # m or rad, root mean square of data less fit, by joint
    warnings: tuple[str, ...]  # lines on what speaks against the result
    iterations: int  # of the last fit
    data: Measurements  # what was fitted
    fit: Array  # (K, m) m or rad, the positions with the estimated parameters
    segments: tuple[int, ...]  # first samples of the segments, each with an initial state of its
    # own

    def overrides(self) -> dict[str, float]:
        """Return the estimates as changes of the scene, by dotted key."""
        return {each.key: each.value for each in self.estimates}

    @property
    def scene(self) -> Scene:
        """The scene with the estimates, law and all."""
        return load_scene(self.guess, self.overrides())

    def to_dict(self) -> dict[str, Any]:
        """Return all but the curves, for JSON."""
        return {
            "parameters": {each.key: each._asdict() for each in self.estimates},
            "covariance": self.covariance.tolist(),
            "correlation": self.correlation.tolist(),
            "condition": self.condition,
            "residual": self.residual,
            "segments": len(self.segments),
            "iterations": self.iterations,
            "warnings": list(self.warnings),
        }


class Minimum(NamedTuple):
    """The point of least cost of one division into segments."""

    length: float  # s, of the segments
    shooting: Shooting
    deviation: Array  # (m,) standard deviation of each joint's residuals
    point: Unknowns


def identify(
    scene: SceneSource,
    data: Source,
    parameters: Sequence[str],
    *,
    joints: Sequence[str] = (),
    segment: float = SEGMENT,
) -> Identification:
    """Fit parameters of a scene to a run's positions: multiple shooting, 95 % intervals.

    The fit is by least squares.

    Args:
        scene: the crane, whose values are the first guess; what `load_scene` reads.
        data: the run: a recording FILE.rrd, a ROS bag FILE.mcap, what `read_recording` or
            `simulate` returns, or `crane_sim.identification.Measurements`. Only positions and
            commands count.
        parameters: dotted keys (p,) of numbers in the scene, such as `cable.lengths.0`; each keeps
            its sign.
        joints: whose positions count, all measured ones when empty.
        segment: longest part [s] of the run that begins with an unknown state of its own.

    Returns:
        `estimates` with `key`, `value`, `deviation`, `low`, `high`; `overrides()` for `load_scene`;
        `warnings`.

    Raises:
        SceneError: a key, a joint or the run is invalid, the scene cannot repeat the run at all, or
            the run does not determine a parameter.
    """
    for what, names in (("parameters", parameters), ("joints", joints)):
        if isinstance(names, str):
            raise SceneError(f"{what} = {names!r}: must be a list, as [{names!r}]")
    if not parameters or len(set(parameters)) < len(parameters):
        raise SceneError(
            f"parameters = {list(parameters)}: must be one key of the scene or more, each once"
        )
    if not segment > 0.0:
        raise SceneError(f"segment = {segment}: must be greater than 0")
    guess = load_scene(scene)
    chosen = choose_joints(measurements_of(data, guess), tuple(joints))
    _check_motion(chosen)
    asked = min(segment, float(np.ptp(chosen.t)))
    rough = _fit(guess, chosen, parameters, asked)
    deviation, point, counts = refine(rough.shooting, rough.deviation, rough.point)
    found = rough._replace(deviation=deviation, point=point)
    return _judge(guess, found, counts, _shortened(rough.length, asked))


def _check_motion(data: Measurements) -> None:
    """Raise a SceneError where no joint moves beyond its noise, as nothing is identifiable."""
    moved = np.nanmax(data.q, axis=0) - np.nanmin(data.q, axis=0)
    if np.all(moved <= SILENT * estimate_noise(data.q)):
        raise SceneError(
            f"run: {', '.join(data.joints)}: no motion stands out of the noise, nothing is "
            "identifiable"
        )


def _fit(scene: Scene, data: Measurements, parameters: Sequence[str], segment: float) -> Minimum:
    """Return the rough minimum for segments of a length [s], reached over shorter ones.

    Without such a length the segments are the longest possible.

    A long segment forgives no wrong parameter: over it the simulation may fail, or end in a minimum
    far from the data. Each length begins with the states of the shorter one, and where the cost is
    least: at the scene's values, or at those that shorter segments led to.

    Raises:
        SceneError: the run is too short, or the simulation fails over every length.
    """
    found, states, failure, deviation = None, {}, SceneError(""), estimate_noise(data.q)
    guesses = [np.zeros(len(parameters))]
    for length in (segment / rung for rung in RUNGS):
        try:
            shooting = Shooting(scene, data, parameters, length, states)
            starts = [Unknowns(guess, shooting.start.deviations) for guess in guesses]
            costs = [evaluate_cost(shooting, deviation, start) for start in starts]
            point, _ = minimise(shooting, deviation, starts[int(np.argmin(costs))], ROUGHLY)
        except SceneError as error:
            # segments are too short for their samples, or too long for the first guess
            failure = error
            continue
        found, states = Minimum(length, shooting, deviation, point), shooting.states(point)
        guesses.append(point.logarithms)
    if found is None:
        raise failure
    return found


def _judge(
    guess: Scene, found: Minimum, counts: Sequence[int], notes: Sequence[str]
) -> Identification:
    """Return the result at the point of least cost.

    The covariance is from the sensitivities without the states' share.
    """
    _, shooting, deviation, point = found
    linear = linearise(shooting, deviation, point, ORDER_6)
    relative, freedom, condition = _covariance(linear, shooting)
    values = shooting.values(point.logarithms)
    covariance = relative * np.outer(values, values)
    deviations = np.sqrt(np.diag(covariance))
    estimates = _estimates(shooting, values, deviations, freedom)
    error, there = linear.residual * deviation, np.isfinite(shooting.data.q)
    errors = np.sqrt(np.sum(error**2, axis=0) / there.sum(axis=0))
    doubts = *_weak(estimates), *_correlated(shooting, linear.residual, errors)
    return Identification(
        guess=guess,
        estimates=estimates,
        covariance=covariance,
        correlation=covariance / np.outer(deviations, deviations),
        condition=condition,
        residual=dict(zip(shooting.data.joints, errors.tolist(), strict=True)),
        warnings=(*notes, *doubts, *_unfinished(counts)),
        iterations=sum(counts),
        data=shooting.data,
        fit=shooting.predict(point),
        segments=tuple(each.first for each in shooting.segments),
    )


def _estimates(
    shooting: Shooting, values: Array, deviations: Array, freedom: int
) -> tuple[Estimate, ...]:
    """Return the parameters with their intervals, of Student's t of these degrees of freedom."""
    quantile = float(scipy.stats.t.ppf(0.5 + LEVEL / 2.0, freedom))
    reach = np.maximum(quantile * deviations, ROUNDING * np.abs(values))
    low, high = values - reach, values + reach
    columns = (shooting.parameters, shooting.nominal, values, deviations, low, high)
    return tuple(
        Estimate(key, *map(float, numbers)) for key, *numbers in zip(*columns, strict=True)
    )


def _covariance(linear: Linear, shooting: Shooting) -> tuple[Array, int, float]:
    """Return (covariance (p, p) of logarithms, degrees of freedom, condition number).

    The condition number is that of the sensitivities.

    Raises:
        SceneError: the information matrix is singular, a parameter has no influence, or a run near
            the estimates fails.
    """
    if not linear.finite:
        raise SceneError("run: near the estimates the simulation fails; give a shorter segment")
    reduced, rank, squares = _reduce(linear, shooting)
    norms = np.linalg.norm(reduced, axis=0)
    _, singular, rotation = np.linalg.svd(
        reduced / np.where(norms > 0.0, norms, 1.0), full_matrices=False
    )
    if not singular[-1] * ILL_CONDITIONED > singular[0]:
        weights = np.abs(rotation[-1])
        _refuse(shooting, weights > INVOLVED * weights.max())
    freedom = max(1, int(np.isfinite(shooting.data.q).sum()) - rank - len(norms))
    spread = rotation.T / singular
    covariance = squares / freedom * (spread @ spread.T) / np.outer(norms, norms)
    if np.any(weak := np.sqrt(np.diag(covariance)) > UNDETERMINED):
        _refuse(shooting, weak)
    return covariance, freedom, float(singular[0] / singular[-1])


def _refuse(shooting: Shooting, involved: npt.NDArray[np.bool_]) -> NoReturn:
    """Raise the line on parameters (p,) that are not identifiable."""
    names = [key for key, named in zip(shooting.parameters, involved, strict=True) if named]
    why = (
        "has no influence that stands out of the noise"
        if len(names) == 1
        else "cannot be told apart: leave one of them out"
    )
    raise SceneError(f"{', '.join(names)}: not identifiable from this run, {why}")


def _reduce(linear: Linear, shooting: Shooting) -> tuple[Array, int, float]:
    """Return (by_parameter without the share of initial states (r, p), rank, squares).

    Squares are of residuals, the rank is that of the initial states' sensitivities.
    """
    rows, rank, squares = [], 0, 0.0
    for r, p, x in linear.parts(shooting):
        left, singular, _ = np.linalg.svd(
            x / np.maximum(np.linalg.norm(x, axis=0), 1e-9), full_matrices=False
        )
        left = left[:, singular > 1e-10 * singular[0]]
        rows.append(p - left @ (left.T @ p))
        rank, squares = rank + left.shape[1], squares + float(r @ r)
    return np.vstack(rows), rank, squares


def _weak(estimates: Sequence[Estimate]) -> list[str]:
    """Return lines on parameters that the run hardly determines."""
    return [
        f"{each.key}: the interval is wider than the value itself: this run hardly determines it"
        for each in estimates
        if not each.high - each.low < 2.0 * abs(each.value)
    ]


def _correlated(shooting: Shooting, residual: Array, errors: Array) -> list[str]:
    """Return lines on joints whose residuals are neither noise nor rounding.

    `errors` (m,) are their root mean squares.
    """
    lines, ranges = [], np.nanmax(shooting.data.q, axis=0) - np.nanmin(shooting.data.q, axis=0)
    for name, column, error, travel in zip(
        shooting.data.joints, residual.T, errors, ranges, strict=True
    ):
        power = float(column @ column)  # 0 stands where nothing was measured
        correlation = float(column[1:] @ column[:-1]) / power if error > ROUNDING * travel else 0.0
        if correlation > CORRELATED:
            lines.append(
                f"{name}: residuals are correlated ({correlation:.2f}): something is not in the "
                "model, "
                "and the intervals are too narrow"
            )
    return lines


def _unfinished(counts: Sequence[int]) -> list[str]:
    return ["the fit has not converged"] if counts[-1] >= ITERATIONS else []


def _shortened(length: float, asked: float) -> list[str]:
    """Return the line on segments that had to be shorter than asked."""
    line = (
        f"over segments of {asked:g} s the simulation fails: those that were fitted have "
        f"{length:g} s"
    )
    return [line] if length < asked else []
