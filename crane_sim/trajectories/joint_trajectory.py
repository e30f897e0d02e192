"""A table of points with times, as in trajectory_msgs/JointTrajectory, and its reader for files.

Between points the motion is what ros2_control's joint_trajectory_controller makes of them: linear
where only positions are given, cubic with velocities, quintic with accelerations as well.

A file holds the message as YAML, or as CSV a head line
`time,x,y,x_velocity,y_velocity,x_acceleration,...` and a line of numbers for every point.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import BeforeValidator, Field

from crane_sim.files.catalogue import config_folder
from crane_sim.files.csv_table import Row, read_table
from crane_sim.files.errors import join_lines
from crane_sim.files.types import NonNegative, Real
from crane_sim.files.yaml_text import YAML_ERRORS, read_yaml
from crane_sim.trajectories.polynomials import MIN_INTERVAL, PiecewisePolynomial, with_rest_at_ends

NS_PER_S = 1e9
ZERO_VELOCITY = 1e-9  # velocities at the ends below this count as zero, for rounding in files
_RATES = ("_velocity", "_acceleration")


def _seconds(value: Any) -> Any:
    """Return seconds for a duration message {sec, nanosec}, anything else as it is.

    Raises:
        ValueError: a group of other keys, or of no numbers.
    """
    if not isinstance(value, Mapping):
        return value
    parts = [value.get(key, 0) for key in ("sec", "nanosec")]
    if set(value) - {"sec", "nanosec"} or not all(type(part) in (int, float) for part in parts):
        raise ValueError(
            f"must be seconds, or sec and nanosec, which are numbers, here are {dict(value)}"
        )
    return parts[0] + parts[1] / NS_PER_S


class Point(NamedTuple):
    """Position and its derivatives at one time."""

    positions: tuple[Real, ...]  # coordinate's unit, of each
    time_from_start: Annotated[NonNegative, BeforeValidator(_seconds)]  # s, or `{sec, nanosec}`
    velocities: tuple[Real, ...] = ()  # coordinate's unit/s, of each; left out: linear between
    # points
    accelerations: tuple[Real, ...] = ()  # coordinate's unit/s², of each; left out: cubic with
    # velocities, quintic with both
    effort: tuple[Real, ...] = ()  # effort's unit, of the message; not used by a path


class Waypoints(NamedTuple):
    """Points of named coordinates, as in trajectory_msgs/JointTrajectory, at rest at both ends.

    The coordinates rest before the first point and after the last one.

    A key `file` in place of joint_names and points names a YAML file with the message, or a CSV
    file.
    """

    joint_names: Annotated[tuple[str, ...], Field(min_length=1)]  # names of the coordinates: the
    # actuated joints', or x, y, z
    points: Annotated[tuple[Point, ...], Field(min_length=1)]  # in the order of time
    start: Real = 0.0  # s, from which the points' times count

    def find_error(self) -> str:
        """Return one line on points that make no path from rest to rest, empty when they do."""
        return (
            self.describe_mismatch()
            or self.describe_end_velocity(0)
            or self.describe_end_velocity()
        )

    def describe_mismatch(self) -> str:
        """Return one line on points that do not fit together, empty when all do."""
        first = self.points[0]
        if first.accelerations and not first.velocities:
            return "points: accelerations need velocities as well"
        for i, point in enumerate(self.points):
            for name in ("positions", "velocities", "accelerations"):
                size = len(self.joint_names) if name == "positions" or getattr(first, name) else 0
                if len(getattr(point, name)) != size:
                    return (
                        f"points[{i}].{name} has {len(getattr(point, name))} values, not {size} as "
                        "the others"
                    )
            if i and point.time_from_start - self.points[i - 1].time_from_start < MIN_INTERVAL:
                return (
                    f"points[{i}].time_from_start = {point.time_from_start:g}: times must increase"
                )
        return ""

    def describe_end_velocity(self, i: int = -1) -> str:
        """Return one line on point i if it is not at rest, else empty text."""
        if max(map(abs, self.points[i].velocities), default=0.0) <= ZERO_VELOCITY:
            return ""
        return (
            f"points[{i}].velocities = {list(self.points[i].velocities)}: a path is at rest at "
            "both ends"
        )

    def to_polynomials(self) -> PiecewisePolynomial:
        """Return the motion."""
        # here: few scenes have one, and it takes long to import
        from scipy.interpolate import BPoly, PPoly

        times = self.start + np.array([point.time_from_start for point in self.points])
        derivatives = [np.array([point.positions for point in self.points])]
        derivatives += [
            np.array([getattr(point, name) for point in self.points])
            for name in ("velocities", "accelerations")
        ]
        if len(times) == 1:
            return with_rest_at_ends(
                times + np.array([0.0, MIN_INTERVAL]), derivatives[0][:, :, None]
            )
        known = np.stack([rows for rows in derivatives if rows.size], axis=1)  # (K, orders, n)
        rows = PPoly.from_bernstein_basis(BPoly.from_derivatives(times - times[0], list(known))).c
        return with_rest_at_ends(times, np.ascontiguousarray(rows[::-1].transpose(1, 2, 0)))


def read_trajectory(name: str) -> dict[str, Any]:
    """Return {joint_names, points} of a file in the working directory or the catalogue.

    `name` is relative to either folder.

    Raises:
        ValueError: one line on why it cannot be read.
    """
    path = Path(name) if Path(name).is_file() else config_folder() / name
    if not path.is_file():
        raise ValueError(f"file {name}: does not exist, here or in {config_folder()}")
    try:
        if path.suffix == ".csv":
            return _from_rows(*read_table(path))
        message = read_yaml(path, several=True)  # an echo of messages puts a line after each
    except YAML_ERRORS as error:
        raise ValueError(f"file {path}: is no trajectory: {join_lines(error)}") from None
    for key in ("joint_names", "points"):
        if not isinstance(message, Mapping) or key not in message:
            raise ValueError(f"file {path}: is no trajectory: has no key {key}")
    return {key: message[key] for key in ("joint_names", "points")}


def _from_rows(head: Sequence[str], rows: Sequence[Row]) -> dict[str, Any]:
    """Return {joint_names, points} of a table with these columns."""
    if not head or head[0] != "time":
        raise ValueError("its head line begins with time")
    names = [name for name in head[1:] if not name.endswith(_RATES)]
    columns = {"positions": names}
    for key, ending in zip(("velocities", "accelerations"), _RATES, strict=True):
        columns[key] = [name + ending for name in names if name + ending in head]
    if sum(map(len, columns.values())) != len(head) - 1:
        raise ValueError(f"its head line has rates of no coordinate: {', '.join(head)}")
    points = []
    for row in rows:
        numbers = dict(zip(head, row.numbers, strict=True))
        points.append({key: [numbers[name] for name in names] for key, names in columns.items()})
        points[-1]["time_from_start"] = numbers["time"]
    return {"joint_names": names, "points": points}
