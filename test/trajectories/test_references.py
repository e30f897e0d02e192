"""References: where their formulas say, within their limits and smooth."""

from math import pi
from typing import Any

import numpy as np
import pytest

from crane_sim.numerics.jit import entry_point
from crane_sim.trajectories.line_arc import Arc, Line
from crane_sim.trajectories.minimum_jerk import MinimumJerk
from crane_sim.trajectories.obstacle import ObstacleDetour, Side, min_distance
from crane_sim.trajectories.point_to_point import PointToPoint
from crane_sim.trajectories.polynomials import PiecewisePolynomial, evaluate, max_derivatives
from crane_sim.trajectories.trajectory import (
    compile_trajectory,
    higher_derivatives_at,
    sample_trajectory,
)

POINTS = ((1.35, 0.0), (1.0922, -0.7935), (0.7425, -0.7425), (0.7935, -1.0922), (0.0, -1.35))
TIMES = (10.0, 26.0, 30.0, 34.0, 50.0)
ROUNDING = 1e-12  # of numbers of the size of one


def way(profile: str, tau: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return (s, ds/dtau, d²s/dtau²) of a profile as its formula is printed."""
    if profile == "sine":
        turn = 2.0 * pi * tau
        return tau - np.sin(turn) / (2.0 * pi), 1.0 - np.cos(turn), 2.0 * pi * np.sin(turn)
    return (
        10.0 * tau**3 - 15.0 * tau**4 + 6.0 * tau**5,
        30.0 * tau**2 - 60.0 * tau**3 + 30.0 * tau**4,
        60.0 * tau - 180.0 * tau**2 + 120.0 * tau**3,
    )


@pytest.mark.parametrize("profile", ["sine", "smooth"])
@pytest.mark.parametrize("turn", [-0.5 * pi, 9.0])
def test_arcs_are_their_formulas(profile: Any, turn: float) -> None:
    """Motion on an arc, up to acceleration, is that of R e^(i a(t)), with rest before and after."""
    arc = Arc((0.2, -0.1), 1.35, 0.3, 0.3 + turn, 40.0, 10.0, profile)
    t = np.linspace(0.0, 60.0, 1201)
    actual = sample_trajectory(compile_trajectory(arc.to_polynomials()), t)
    s, ds, dds = way(profile, np.clip((t - 10.0) / 40.0, 0.0, 1.0))
    rate, second = turn * ds / 40.0, turn * dds / 1600.0
    spot = 1.35 * np.exp(1j * (0.3 + turn * s))
    expected = (0.2 - 0.1j + spot, 1j * rate * spot, (1j * second - rate**2) * spot)
    for k, exact in enumerate(expected):
        assert np.max(np.abs(actual[:, k] - np.stack([exact.real, exact.imag], axis=1))) < ROUNDING


@pytest.mark.parametrize("profile", ["sine", "smooth"])
def test_lines_are_their_formulas(profile: Any) -> None:
    """A straight line has the profile's position, velocity, acceleration in every coordinate."""
    t, ends = np.linspace(0.0, 6.0, 301), np.array([[1.0, 2.0, 3.0], [0.0, 5.0, 3.0]])
    polynomials = Line(tuple(ends[0]), tuple(ends[1]), 4.0, 1.0, profile).to_polynomials()
    s, ds, dds = way(profile, np.clip((t - 1.0) / 4.0, 0.0, 1.0))
    for k, exact in enumerate((ends[0] + np.outer(s, ends[1] - ends[0]), ds / 4.0, dds / 16.0)):
        wanted = exact if k == 0 else np.outer(exact, ends[1] - ends[0])
        assert np.max(np.abs(evaluate(polynomials, t, k) - wanted)) < ROUNDING


@entry_point
def further(path, t):
    """Compiled `higher_derivatives_at`."""
    return higher_derivatives_at(path, t)


def test_higher_derivatives() -> None:
    """Jerk and snap of the compiled path are the derivatives of its acceleration."""
    polynomials = MinimumJerk(POINTS, TIMES).to_polynomials()
    path = compile_trajectory(polynomials)
    for t in (12.3, 27.0, 33.9, 55.0):
        for k, actual in enumerate(further(path, t)):
            assert (
                np.max(np.abs(np.array(actual) - evaluate(polynomials, np.array([t]), 3 + k)))
                < ROUNDING
            )


LIMITS = [
    (1.0, 2.0, None),  # velocity and acceleration are both reached
    (10.0, 2.0, None),  # the velocity is not
    (1.0, 2.0, 5.0),  # all three are reached
    (10.0, 2.0, 50.0),  # the velocity is not
    (10.0, 20.0, 5.0),  # only the jerk is
    (0.1, 2.0, 5.0),  # the acceleration is not
]


@pytest.mark.parametrize("limits", LIMITS)
def test_point_to_point_keeps_its_limits_and_wastes_none(
    limits: tuple[float, float, float | None],
) -> None:
    """No coordinate exceeds a limit, all arrive together, and at every time a limit is reached."""
    velocity, acceleration, jerk = limits
    of_axes = (acceleration, 0.9 * acceleration, acceleration)
    polynomials = PointToPoint(
        (0.0, 1.0, 2.0), (3.0, 0.0, 2.0), velocity, of_axes, jerk, 0.5
    ).to_polynomials()
    t = np.linspace(0.5, polynomials.starts[-1], 2001)[1:-1]
    reached = np.zeros(len(t), dtype=bool)
    for order, limit in enumerate((velocity, acceleration, jerk), start=1):
        if limit is not None:
            size = np.abs(evaluate(polynomials, t, order)[:, 0]) / limit
            assert size.max() <= 1.0 + 1e-12 and np.all(
                max_derivatives(polynomials, order) <= limit * (1.0 + 1e-12)
            )  # rounding
            reached |= size > 1.0 - 1e-9
    assert np.mean(reached) > 0.99  # all but instants next to a change of phase
    assert evaluate(polynomials, np.array([0.0, 1e3])) == pytest.approx(
        np.array([[0, 1, 2], [3, 0, 2]]), abs=ROUNDING
    )
    assert smoothness(polynomials) >= (1 if jerk is None else 2)


@pytest.mark.parametrize("jerk", [None, 1.0])
def test_a_displacement_of_rounding_is_none(jerk: float | None) -> None:
    """A path from 0.3 to 0.1 + 0.2 rests; rounding beside a moving coordinate changes nothing."""
    end = 0.1 + 0.2
    assert end != 0.3
    polynomials = PointToPoint((0.3, 1e6), (end, 1e6 + 1e-9), 1.0, 1.0, jerk).to_polynomials()
    assert np.array_equal(evaluate(polynomials, np.array([-1.0, 0.0, 5.0])), [[0.3, 1e6]] * 3)
    alone = PointToPoint((2.0,), (3.0,), 1.0, 1.0, jerk).to_polynomials()
    beside = PointToPoint((2.0, 0.3), (3.0, end), 1.0, 1.0, jerk).to_polynomials()
    assert np.array_equal(beside.coefficients[:, :1], alone.coefficients)
    # rounding of the sums of the profile
    assert beside.coefficients[-1, 1, 0] == pytest.approx(end, abs=1e-15)


def smoothness(polynomials: PiecewisePolynomial, tolerance: float = 1e-8) -> int:
    """Return how many derivatives are continuous; smaller jumps than the tolerance are none.

    The tolerance is relative to the derivative's size.
    """
    inner = polynomials.starts[1:]
    for k in range(5):
        row = evaluate(polynomials, inner, k)
        before = evaluate(polynomials, np.nextafter(inner, -np.inf), k)
        if np.max(np.abs(row - before)) > tolerance * max(
            1e-3, float(max_derivatives(polynomials, k).max())
        ):
            return k - 1
    return 4


def inside(polynomials: PiecewisePolynomial) -> PiecewisePolynomial:
    """Return the pieces without the rest before and after."""
    return PiecewisePolynomial(polynomials.starts[1:-1], polynomials.coefficients[1:-1])


def test_minimum_jerk_of_two_points_is_the_quintic() -> None:
    """Two waypoints give 10 tau³ - 15 tau⁴ + 6 tau⁵."""
    polynomials = MinimumJerk(((1.0, 2.0), (4.0, 0.0)), (2.0, 7.0)).to_polynomials()
    t = np.linspace(0.0, 9.0, 91)
    s, _, _ = way("smooth", np.clip((t - 2.0) / 5.0, 0.0, 1.0))
    assert (
        np.max(np.abs(evaluate(polynomials, t) - (np.array([1.0, 2.0]) + np.outer(s, [3.0, -2.0]))))
        < ROUNDING
    )


def test_minimum_jerk_passes_its_waypoints_smoothly() -> None:
    """Four derivatives are continuous at inner waypoints; velocity, acceleration end at zero."""
    polynomials = MinimumJerk(POINTS, TIMES).to_polynomials()
    assert np.max(np.abs(evaluate(polynomials, np.array(TIMES)) - POINTS)) < ROUNDING
    assert smoothness(polynomials) == 2  # rest begins and ends with a jump of the jerk
    inner = inside(polynomials)
    knots = np.array(TIMES[1:-1])
    for k in range(5):
        jump = evaluate(inner, knots, k) - evaluate(inner, np.nextafter(knots, 0.0), k)
        # rounding, times how fast the pieces of 4 to 16 s change
        assert np.max(np.abs(jump)) < 1e-13 * 16.0**2


def test_minimum_jerk_cannot_be_improved() -> None:
    """No admissible variation changes the squared jerk to first order.

    Its inner product with the jerk vanishes.
    """
    polynomials, t0 = MinimumJerk(POINTS, TIMES).to_polynomials(), TIMES[0]
    vanishing = np.polynomial.Polynomial.fromroots([(t - t0) / 40.0 for t in TIMES])
    at_rest = np.polynomial.Polynomial.fromroots([0.0, 0.0, 1.0, 1.0])
    x, weights = np.polynomial.legendre.leggauss(12)
    for more in ([1.0], [0.0, 1.0], [1.0, -3.0, 2.0]):
        bump = (vanishing * at_rest * np.polynomial.Polynomial(more)).deriv(3)
        total, size = np.zeros(2), np.zeros(2)
        for first, last in zip(TIMES[:-1], TIMES[1:], strict=True):
            t = 0.5 * (first + last) + 0.5 * (last - first) * x
            terms = (
                evaluate(polynomials, t, 3)
                * (bump((t - t0) / 40.0) * weights * 0.5 * (last - first))[:, None]
            )
            total, size = total + terms.sum(axis=0), size + np.abs(terms).sum(axis=0)
        assert np.all(np.abs(total) < 1e-10 * size)  # rounding of sums that cancel


def test_minimum_jerk_takes_the_time_that_limits_ask() -> None:
    """Without times, the motion is as fast as its tightest limit allows."""
    limits = {"velocity": (0.1, 0.08), "acceleration": 0.05, "jerk": 0.02}
    polynomials = MinimumJerk(POINTS, **limits, start=3.0).to_polynomials()
    ratios = [
        np.max(max_derivatives(polynomials, k) / np.array(limit))
        for k, limit in enumerate(limits.values(), start=1)
    ]
    assert max(ratios) == pytest.approx(1.0, abs=1e-9)  # peaks are found as roots of quartics
    assert polynomials.starts[1] == 3.0


SIDES: tuple[Side, ...] = ("shorter", "left", "right")


@pytest.mark.parametrize("side", SIDES)
def test_the_way_around_an_obstacle_keeps_its_distance(side: Any) -> None:
    """The motion from A to B stays clear of the circle on the side asked for, and not by much."""
    obstacle = ObstacleDetour(
        (1.35, 0.0), (0.0, -1.35), (0.8, -0.8), 0.3, 0.1, 40.0, start=10.0, side=side
    )
    polynomials = obstacle.to_polynomials()
    t = np.linspace(10.0, 50.0, 4001)
    place = evaluate(polynomials, t)
    gap = np.linalg.norm(place - (0.8, -0.8), axis=1)
    assert gap.min() > 0.4 - ROUNDING
    assert gap.min() < 0.41
    # A to B, B is clockwise of A
    assert (np.linalg.norm(place[2000]) > np.hypot(0.8, 0.8)) == (side == "left")
    assert evaluate(polynomials, np.array([0.0, 60.0])) == pytest.approx(
        np.array([[1.35, 0.0], [0.0, -1.35]]), abs=ROUNDING
    )


@pytest.mark.parametrize(("side", "is_straight"), [("left", False), ("right", True)])
def test_the_side_holds_where_the_straight_way_is_free(side: Side, is_straight: bool) -> None:
    """An obstacle left of the straight way is passed on the right by it, on the left by detour."""
    polynomials = ObstacleDetour(
        (0.0, 0.0), (2.0, 0.0), (1.0, 1.0), 0.5, 0.4, 5.0, side=side
    ).to_polynomials()
    y = evaluate(polynomials, np.linspace(0.0, 5.0, 51))[:, 1]
    assert np.max(np.abs(y)) < ROUNDING if is_straight else y.max() > 1.9
    assert min_distance(polynomials, np.array([1.0, 1.0])) >= 0.9


@pytest.mark.parametrize("side", SIDES)
def test_distances_are_kept_at_every_instant(side: Side) -> None:
    """Motions around random obstacles are never within radius + clearance.

    One in ten has an end near the circle.
    """
    rng = np.random.default_rng(0)
    for i in range(60):
        ends, (radius, clearance) = (
            rng.uniform(-5.0, 5.0, (2, 2)),
            rng.uniform((0.2, 0.0), (2.0, 0.5)),
        )
        ends[0] *= (radius + clearance) * 1.01 / np.hypot(*ends[0]) if i % 10 == 0 else 1.0
        (a, b), (x, y) = ends.tolist()
        detour = ObstacleDetour((a, b), (x, y), (0.0, 0.0), radius, clearance, 10.0, side=side)
        if not detour.find_error():
            gap = np.linalg.norm(
                evaluate(detour.to_polynomials(), np.linspace(0.0, 10.0, 4001)), axis=1
            )
            assert gap.min() >= (radius + clearance) * (1.0 - ROUNDING)


DETOURS: dict[str, tuple[tuple[float, ...], float, float]] = {
    "the straight way misses by millimetres": (
        (-4.87494, -2.56157, -0.190668, 1.702322),
        0.983961,
        0.479962,
    ),
    "an end almost on the circle": (
        (-1.0017023, -1.6624166, 2.698846, 0.216292),
        1.4723816,
        0.4530062,
    ),
}


@pytest.mark.parametrize("case", DETOURS)
def test_a_way_is_found_beside_the_circle(case: str) -> None:
    """Closer waypoints keep clearance and a moderate speed beside the circle.

    Here the spline overshoots more the larger the circle.
    """
    (a, b, x, y), radius, clearance = DETOURS[case]
    for side in SIDES:
        detour = ObstacleDetour((a, b), (x, y), (0.0, 0.0), radius, clearance, 10.0, side=side)
        polynomials = detour.to_polynomials()
        assert min_distance(polynomials, np.zeros(2)) >= (radius + clearance) * (1.0 - ROUNDING)
        length = np.sum(np.linalg.norm(np.diff(detour.waypoints()[0], axis=0), axis=1))
        # at rest at both ends: 15 / 8 of the mean speed in one piece, about 1 in many; tiny pieces
        # would give hundreds
        assert max_derivatives(polynomials, 1).max() < 2.5 * length / 10.0


def test_a_detour_that_is_not_possible_says_why() -> None:
    """An end too near for any path, and a duration too short for its pieces, are named.

    Limits are not named where none are given.
    """
    near = ObstacleDetour((1.0, 0.0), (-3.0, 0.0), (0.0, 0.0), 0.9, 0.1, 10.0)
    with pytest.raises(
        ValueError,
        match=r"no path was found that keeps clearance = 0.1 m: take less of it, or from",
    ):
        near.to_polynomials()
    with pytest.raises(
        ValueError,
        match=r"duration = 2e-06 at start = 0: so short that the motion, or a part of it",
    ):
        near._replace(begin=(3.0, 0.0), duration=2e-6).to_polynomials()
