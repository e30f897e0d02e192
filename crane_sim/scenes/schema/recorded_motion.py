"""A recorded base motion: read from a CSV file, filtered on request, smoothed by a spline."""

from math import factorial
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from crane_sim.files.csv_table import read_table
from crane_sim.files.errors import PATH, SceneError, shorten, unknown_key
from crane_sim.files.types import EIGHTH_TURN, HALF_TURN, RADIANS
from crane_sim.scenes.schema.base_smoothing import MAX_ROWS, smooth
from crane_sim.trajectories.base_motion import AXES, SplineBase

Array = npt.NDArray[np.float64]


FEWEST = 6  # rows, of a quintic spline


MIN_INTERVAL = 1e-6  # s, between two rows: its powers stay in the range of doubles


LIVELY, LIVELY_TURN = 4.9, 0.5
"""m/s² (half of free fall) and rad/s², beyond which a base moves as no ship does, and rows are
likely to be noisy."""


UNITS = dict.fromkeys(("time", *AXES), 1.0) | {
    f"{axis}_{unit}": factor
    for axis in AXES[3:]
    for unit, factor in (("deg", RADIANS["deg"]), ("rad", 1.0))
}
"""Columns that a file may have, and what of s, m or rad their unit is."""


SUSPECT = {
    "roll": (EIGHTH_TURN, "an eighth of a turn"),
    "pitch": (EIGHTH_TURN, "an eighth of a turn"),
    "yaw": (HALF_TURN, "half a turn"),
}
"""Angles [rad] of columns without a unit beyond which they are probably in degrees, as in scene
files."""


PIECE_SAMPLES = np.linspace(0.0, 1.0, 9)  # of every piece, for its largest acceleration


def spline_base(file: str, duration: float, cut_off: float | None = None) -> SplineBase:
    """Return the quintic spline through a file's rows, with four continuous derivatives.

    Args:
        file: path of a CSV file with a head: time [s], and any of surge, sway, heave [m], roll,
            pitch, yaw [rad], the latter also as roll_deg, roll_rad, ...
        duration: s, of the run that it has to cover.
        cut_off: Hz, of the low pass of the rows, see `smooth`; None: none.

    Raises:
        SceneError: the file cannot be read, or has no valid content.
    """
    # here: few scenes have one, and it takes long to import
    from scipy.interpolate import make_interp_spline

    where = f"base_motion.file = {shorten(file, PATH)}"
    head, rows, lines = _read_columns(where, file)
    times = rows[:, head.index("time")]
    _check_times(where, times, lines, duration)
    values = np.zeros((len(times), len(AXES)))
    for i, name in enumerate(AXES):
        if name in head:
            values[:, i] = rows[:, head.index(name)]
    if cut_off is not None:
        values = _low_pass(where, times, values, cut_off)
    spline = make_interp_spline(times, values, k=5)
    knots = np.unique(spline.t)  # those of the ends stand several times
    powers = [spline(knots[:-1], nu=m) / factorial(m) for m in range(6)]
    return SplineBase(knots, np.ascontiguousarray(np.stack(powers, axis=-1).transpose(1, 0, 2)))


def _low_pass(where: str, times: Array, values: Array, cut_off: float) -> Array:
    """Return the rows after the low pass of `smooth`.

    Raises:
        SceneError: it would leave all of them, or nothing but a line.
    """
    span, rate = float(times[-1] - times[0]), (len(times) - 1) / float(times[-1] - times[0])
    least, most = max(1.0 / span, rate / MAX_ROWS), 0.5 * rate
    if not least <= cut_off <= most:
        raise SceneError(
            f"base_motion.cut_off = {cut_off:g}: must be {least:.3g} to {most:.3g} Hz: the file "
            f"covers {span:g} s, "
            f"{rate:.3g} rows a second"
        )
    try:
        return smooth(times, values, cut_off)
    except ValueError as error:
        raise SceneError(f"{where}: {error}") from None


def peak_accelerations(base: SplineBase, duration: float) -> tuple[Array, Array]:
    """Return (largest accelerations [m/s²] and [rad/s²] in 0 .. duration [s], their times [s])."""
    times = base.knots[:-1, None] + np.diff(base.knots)[:, None] * PIECE_SAMPLES
    s = np.clip(times, 0.0, duration) - base.knots[:-1, None]
    during_run = (base.knots[1:] > 0.0) & (base.knots[:-1] < duration)
    s, times, rows = (
        s[during_run],
        np.clip(times, 0.0, duration)[during_run],
        base.coefficients[:, during_run],
    )
    seconds = np.zeros((len(AXES), *s.shape))
    for k in range(2, rows.shape[2]):
        seconds += k * (k - 1) * rows[:, :, k, None] * s ** (k - 2)
    both = [np.linalg.norm(part, axis=0) for part in (seconds[:3], seconds[3:])]
    return np.array([size.max() for size in both]), np.array(
        [times.flat[size.argmax()] for size in both]
    )


def peak_notes(where: str, base: SplineBase, duration: float) -> dict[str, Any]:
    """Return notes on a base's largest accelerations, and warnings where no ship has such."""
    (linear, angular), (at, at_turn) = (
        part.tolist() for part in peak_accelerations(base, duration)
    )
    remedy = "are the rows noisy? base_motion.cut_off [Hz], or a lower one, smooths them"
    lines = []
    if linear > LIVELY:
        lines.append(f"{where}: means an acceleration of {linear:.3g} m/s² at {at:.6g} s; {remedy}")
    if angular > LIVELY_TURN:
        lines.append(
            f"{where}: means an angular acceleration of {angular:.3g} rad/s² at {at_turn:.6g} s; "
            f"{remedy}"
        )
    notes: dict[str, Any] = {
        "peak_base_acceleration": linear,
        "peak_base_angular_acceleration": angular,
    }
    return notes | ({"warnings": lines} if lines else {})


def _read_columns(where: str, file: str) -> tuple[list[str], Array, list[int]]:
    """Return (time and axes of the columns, rows in s, m and rad, their lines in the file)."""
    try:
        head, rows = read_table(Path(file))
    except ValueError as error:
        raise SceneError(f"{where}: {error}") from None
    for name in head:
        if name not in UNITS:
            raise SceneError(f"{where}: {unknown_key(name, UNITS, 'column')}")
    if "time" not in head:
        raise SceneError(f"{where}: has no column 'time'; its first line names the columns")
    axes, lines = [name.partition("_")[0] for name in head], [row.line for row in rows]
    for name in axes:
        if axes.count(name) > 1:
            raise SceneError(f"{where}: column {name!r} stands twice, in two units")
    numbers = np.array([row.numbers for row in rows]).reshape(len(rows), len(head))
    _check_angles(where, head, numbers, lines)
    return axes, numbers * [UNITS[name] for name in head], lines


def _check_angles(where: str, head: list[str], numbers: Array, lines: list[int]) -> None:
    """Raise SceneError where angles without a unit are probably in degrees."""
    for name, (largest, turn) in SUSPECT.items():
        column = numbers[:, head.index(name)] if name in head else np.empty(0)
        for k in np.flatnonzero(np.abs(column) > largest):
            at = f"row {lines[k]}, {name} = {column[k]:g}"
            meant = f"did you mean degrees? name the column {name}_deg (or {name}_rad)"
            raise SceneError(f"{where}: {at}: as radians more than {turn}; {meant}")


def _check_times(where: str, times: Array, lines: list[int], duration: float) -> None:
    if len(times) < FEWEST:
        raise SceneError(f"{where}: has {len(times)} rows, a smooth motion needs at least {FEWEST}")
    brief = np.flatnonzero(np.diff(times) < MIN_INTERVAL)
    if len(brief):
        at = int(brief[0]) + 1
        location = f"row {lines[at]}, time = {times[at]:g}"
        raise SceneError(f"{where}: {location}: must be {MIN_INTERVAL:g} s after the row before")
    if times[0] > 0.0 or times[-1] < duration:
        raise SceneError(
            f"{where}: covers {times[0]:g} to {times[-1]:g} s; the run goes from 0 to {duration:g} "
            "s"
        )
