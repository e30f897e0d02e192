"""A base motion that was recorded: read from a CSV file, made smooth by a spline."""

import csv
from math import factorial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from crane_sim.base_motions import AXES, SplineBase
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
    head, rows = _read(where, file)
    times = rows[:, head.index("time")]
    _check_times(where, times, duration)
    values = np.zeros((len(times), len(AXES)))
    for i, name in enumerate(AXES):
        if name in head:
            values[:, i] = rows[:, head.index(name)]
    spline = make_interp_spline(times, values, k=5)
    knots = np.unique(spline.t)  # those of the ends stand several times
    powers = [spline(knots[:-1], nu=m) / factorial(m) for m in range(6)]
    return SplineBase(knots, np.ascontiguousarray(np.stack(powers, axis=-1).transpose(1, 0, 2)))


def _read(where: str, file: str) -> tuple[list[str], Array]:
    """Return (names of the columns, rows) of a file."""
    try:
        with Path(file).open(newline="", encoding="utf-8-sig") as stream:
            lines = [line for line in csv.reader(stream) if any(cell.strip() for cell in line)]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SceneError(f"{where}: cannot be read: {error}") from None
    head = [cell.strip() for cell in lines[0]] if lines else []
    for name in head:
        if name != "time" and name not in AXES:
            raise SceneError(f"{where}: {unknown_key(name, ('time', *AXES), 'column')}")
        if head.count(name) > 1:
            raise SceneError(f"{where}: column {name!r} stands twice")
    if "time" not in head:
        raise SceneError(f"{where}: has no column 'time'; its first line names the columns")
    return head, np.array([_numbers(where, number, line, head) for number, line in enumerate(lines[1:], 2)])


def _numbers(where: str, number: int, line: list[str], head: list[str]) -> list[float]:
    """Return the numbers of row `number` of a file, as many as there are columns."""
    if len(line) != len(head):
        raise SceneError(f"{where}: row {number} has {len(line)} values, the head names {len(head)} columns")
    found = []
    for name, cell in zip(head, line, strict=True):
        try:
            found.append(float(cell))
        except ValueError:
            raise SceneError(f"{where}: row {number}, {name} = {cell!r}: must be a number") from None
        if not np.isfinite(found[-1]):
            raise SceneError(f"{where}: row {number}, {name} = {cell!r}: must be a finite number")
    return found


def _check_times(where: str, times: Array, duration: float) -> None:
    if len(times) < FEWEST:
        raise SceneError(f"{where}: has {len(times)} rows, a smooth motion needs at least {FEWEST}")
    brief = np.flatnonzero(np.diff(times) < BRIEFEST)
    if len(brief):
        row = int(brief[0]) + 3
        raise SceneError(f"{where}: row {row}, time = {times[row - 2]:g}: must be {BRIEFEST:g} s after the row before")
    if times[0] > 0.0 or times[-1] < duration:
        raise SceneError(f"{where}: tells {times[0]:g} to {times[-1]:g} s; the run goes from 0 to {duration:g} s")
