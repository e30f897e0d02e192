"""A new path for a law that is at work: a trajectory, joined to where the old path is."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crane_sim.trajectories.joint_trajectory import Point, Trajectory
from crane_sim.trajectories.path import Path, path_of
from crane_sim.trajectories.polynomials import MIN_INTERVAL, Pieces, reorder, values


def path_of_law(law: Any) -> Path | None:
    """Return the path within a law, None where it follows none."""
    if isinstance(law, Path):
        return law
    fields = law if isinstance(law, tuple) else ()
    return next((path for path in map(path_of_law, fields) if path is not None), None)


def with_path(law: Any, path: Path) -> Any:
    """Return the law with the path within it replaced; what it has learnt stays."""
    if isinstance(law, Path):
        return path
    if not (isinstance(law, tuple) and hasattr(law, "_fields")):
        return law
    return type(law)(*(with_path(value, path) for value in law))


def join_path(trajectory: Trajectory, path: Path, names: Sequence[str], t: float) -> Path:
    """Return a path that goes on from `path` at time t [s] to what is still to come of the trajectory.

    Args:
        trajectory: its `start` is on the clock of t.
        path: of the same coordinates.
        names: of the coordinates, in the path's order.
        t: from when on the new path is followed.

    Raises:
        ValueError: one line on why the trajectory cannot be followed.
    """
    if sorted(trajectory.joint_names) != sorted(names):
        raise ValueError(f"joint_names = {', '.join(trajectory.joint_names)}: must be {', '.join(names)}, in any order")
    complaint = trajectory.describe_mismatch() or trajectory.describe_end_velocity()
    if complaint:
        raise ValueError(complaint)
    order = [trajectory.joint_names.index(name) for name in names]
    ahead = [trajectory.start + point.time_from_start - t for point in trajectory.points]
    points = [
        point._replace(time_from_start=remaining)
        for point, remaining in zip(trajectory.points, ahead, strict=True)
        if remaining > MIN_INTERVAL
    ]
    if not points:
        raise ValueError(f"its last point is {-ahead[-1]:g} s ago")
    old = reorder(pieces_of(path), np.argsort(order).tolist())
    x, v, a = (tuple(values(old, np.array([t]), k)[0].tolist()) for k in range(3))
    begin = Point(x, 0.0, v if points[0].velocities else (), a if points[0].accelerations else ())
    pieces = trajectory._replace(points=(begin, *points), start=t).pieces()
    return path_of(reorder(pieces, order), path.of_joints)


def pieces_of(path: Path) -> Pieces:
    """Return the pieces that a path was compiled from."""
    rows, rest = [], path.coordinates
    while rest is not None:
        rows.append(rest.coefficients)
        rest = rest.rest
    return Pieces(path.starts, np.stack(rows, axis=1))
