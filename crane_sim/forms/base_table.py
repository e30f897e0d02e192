"""A base motion that was recorded: read from a CSV file, made smooth by a spline."""

from math import factorial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from crane_sim.base_motions import AXES, SplineBase
from crane_sim.csv_table import read_table
from crane_sim.explain import SceneError, unknown_key

Array = npt.NDArray[np.float64]
FEWEST = 6  # rows, of a quintic spline
BRIEFEST = 1e-6  # s, between two rows: powers of it stay numbers of the machine


def spline_base(file: str, duration: float) -> SplineBase:
    """Return the quintic spline through a file's rows: its derivatives are continuous up to the fourth.

    Args:
        file: path of a CSV file with a head: time [s], and any of surge, sway, heave [m], roll, pitch, yaw [rad].
        duration: s, of the run that it has to cover.

    Raises:
        SceneError: the file cannot be read, or does not say what it must.
    """
    from scipy.interpolate import make_interp_spline  # here: few scenes have one, and it takes long to import

    where = f"base_motion.file = {file!r}"
    head, rows, lines = _read(where, file)
    times = rows[:, head.index("time")]
    _check_times(where, times, lines, duration)
    values = np.zeros((len(times), len(AXES)))
    for i, name in enumerate(AXES):
        if name in head:
            values[:, i] = rows[:, head.index(name)]
    spline = make_interp_spline(times, values, k=5)
    knots = np.unique(spline.t)  # those of the ends stand several times
    powers = [spline(knots[:-1], nu=m) / factorial(m) for m in range(6)]
    return SplineBase(knots, np.ascontiguousarray(np.stack(powers, axis=-1).transpose(1, 0, 2)))


def _read(where: str, file: str) -> tuple[list[str], Array, list[int]]:
    """Return (names of the columns, rows, their lines in the file)."""
    try:
        head, rows = read_table(Path(file))
    except ValueError as error:
        raise SceneError(f"{where}: {error}") from None
    for name in head:
        if name != "time" and name not in AXES:
            raise SceneError(f"{where}: {unknown_key(name, ('time', *AXES), 'column')}")
    if "time" not in head:
        raise SceneError(f"{where}: has no column 'time'; its first line names the columns")
    numbers = np.array([row.numbers for row in rows]).reshape(len(rows), len(head))
    return head, numbers, [row.line for row in rows]


def _check_times(where: str, times: Array, lines: list[int], duration: float) -> None:
    if len(times) < FEWEST:
        raise SceneError(f"{where}: has {len(times)} rows, a smooth motion needs at least {FEWEST}")
    brief = np.flatnonzero(np.diff(times) < BRIEFEST)
    if len(brief):
        at = int(brief[0]) + 1
        said = f"row {lines[at]}, time = {times[at]:g}"
        raise SceneError(f"{where}: {said}: must be {BRIEFEST:g} s after the row before")
    if times[0] > 0.0 or times[-1] < duration:
        raise SceneError(f"{where}: tells {times[0]:g} to {times[-1]:g} s; the run goes from 0 to {duration:g} s")
