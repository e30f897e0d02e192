"""Replanning: waypoints for a running law, joined to the trajectory that it follows."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crane_sim.trajectories.joint_trajectory import Point, Waypoints
from crane_sim.trajectories.polynomials import (
    MIN_INTERVAL,
    PiecewisePolynomial,
    evaluate,
    reorder,
    with_rest_at_ends,
)
from crane_sim.trajectories.trajectory import Trajectory, compile_trajectory


def trajectory_of_law(law: Any) -> Trajectory | None:
    """Return the trajectory within a law, None where it follows none."""
    if isinstance(law, Trajectory):
        return law
    fields = law if isinstance(law, tuple) else ()
    return next(
        (trajectory for trajectory in map(trajectory_of_law, fields) if trajectory is not None),
        None,
    )


def with_trajectory(law: Any, trajectory: Trajectory) -> Any:
    """Return the law with the trajectory within it replaced; its state is kept."""
    if isinstance(law, Trajectory):
        return trajectory
    if not (isinstance(law, tuple) and hasattr(law, "_fields")):
        return law
    return type(law)(*(with_trajectory(value, trajectory) for value in law))


def join_trajectory(
    waypoints: Waypoints, trajectory: Trajectory, names: Sequence[str], t: float
) -> Trajectory:
    """Return a trajectory that continues `trajectory` at time t [s] through the waypoints after t.

    Args:
        waypoints: their `start` is on the clock of t.
        trajectory: of the same coordinates.
        names: of the coordinates, in the trajectory's order.
        t: time from which the new trajectory is followed.

    Raises:
        ValueError: one line on why the waypoints cannot be followed.
    """
    if sorted(waypoints.joint_names) != sorted(names):
        raise ValueError(
            f"joint_names = {', '.join(waypoints.joint_names)}: must be {', '.join(names)}, in any "
            "order"
        )
    error = waypoints.describe_mismatch() or waypoints.describe_end_velocity()
    if error:
        raise ValueError(error)
    order = [waypoints.joint_names.index(name) for name in names]
    ahead = [waypoints.start + point.time_from_start - t for point in waypoints.points]
    points = [
        point._replace(time_from_start=remaining)
        for point, remaining in zip(waypoints.points, ahead, strict=True)
        if remaining > MIN_INTERVAL
    ]
    if not points:
        raise ValueError(f"its last point is {-ahead[-1]:g} s ago")
    old = reorder(to_piecewise_polynomial(trajectory), np.argsort(order).tolist())
    x, v, a = (tuple(evaluate(old, np.array([t]), k)[0].tolist()) for k in range(3))
    begin = Point(x, 0.0, v if points[0].velocities else (), a if points[0].accelerations else ())
    polynomials = waypoints._replace(points=(begin, *points), start=t).to_polynomials()
    return compile_trajectory(reorder(polynomials, order), trajectory.of_joints)


def stop_trajectory(trajectory: Trajectory, t: float, duration: float) -> Trajectory:
    """Return a trajectory that leaves `trajectory` at t [s] and rests within `duration` [s].

    The velocity is the cubic from (v, a) to rest: v (1 - 3 s² + 2 s³) + a T (s - 2 s² + s³) at t +
    s T.
    """
    old = to_piecewise_polynomial(trajectory)
    x, v, a = (evaluate(old, np.array([t]), k)[0] for k in range(3))
    quadratic = -3.0 * v / duration**2 - 2.0 * a / duration
    cubic = 2.0 * v / duration**3 + a / duration**2
    coefficients = np.stack([x, v, a / 2.0, quadratic / 3.0, cubic / 4.0], axis=1)
    pieces = with_rest_at_ends(np.array([t, t + duration]), coefficients[None])
    return compile_trajectory(pieces, trajectory.of_joints)


def to_piecewise_polynomial(trajectory: Trajectory) -> PiecewisePolynomial:
    """Return the piecewise polynomial that a trajectory was compiled from."""
    return PiecewisePolynomial(trajectory.starts, np.stack(trajectory.coordinates, axis=1))
