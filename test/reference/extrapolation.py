"""Gragg-Bulirsch-Stoer extrapolation in extended precision, with events found to the last digit.

Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, section II.9: the explicit
midpoint rule with n substeps has an error expansion in even powers of 1/n, so K rows of the
Aitken-Neville table reach order 2K.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Real = np.longdouble
Vector = np.ndarray  # of Real
Field = Callable[[Real, Vector], Vector]
FINEST = Real(2e-18)  # s; how closely an event is found within its step
NOISE = Real(1e-16)  # of an event function: less is rounding, which would make a mode flicker


class Setting(NamedTuple):
    """How accurately to integrate."""

    rows: int = 9  # of the table: order 2 rows
    tolerance: float = 1e-16  # of a step, relative to 1 + |y|
    longest: float = 0.02  # s, of a step; events that begin and end inside one go unseen


def midpoint(field: Field, t: Real, y: Vector, slope: Vector, h: Real, n: int) -> Vector:
    """Return y(t + h) after n substeps of the explicit midpoint rule, `slope` being field(t, y)."""
    part = h / n
    before, now = y, y + part * slope
    for k in range(1, n):
        before, now = now, before + 2 * part * field(t + k * part, now)
    return now


def step(field: Field, t: Real, y: Vector, h: Real, rows: int) -> tuple[Vector, float]:
    """Return y(t + h) and the estimated error of the next-to-last order, relative to 1 + |y|."""
    slope = field(t, y)
    table: list[Vector] = []
    for j in range(rows):
        line = [midpoint(field, t, y, slope, h, 2 * (j + 1))]
        for k in range(j):
            ratio = Real(j + 1) / (j - k)
            line.append(line[k] + (line[k] - table[k]) / (ratio * ratio - 1))
        table = line
    return table[-1], float(np.max(np.abs(table[-1] - table[-2]) / (1 + np.abs(y))))


def crossing(value: Callable[[Real], Real], last: Real) -> Real:
    """Return where in (0, last] `value`, negative at `last`, becomes so.

    Illinois method, with bisection from zero.
    """
    low, high = Real(0), last
    at_low, at_high, side = max(value(low), Real(0)), value(high), 0
    while high - low > FINEST:
        middle = (
            high - at_high * (high - low) / (at_high - at_low) if at_low > 0 else (low + high) / 2
        )
        middle = min(max(middle, low + FINEST / 4), high - FINEST / 4)
        found = value(middle)
        if found < 0:
            at_low = at_low / 2 if side < 0 else at_low
            high, at_high, side = middle, found, -1
        else:
            at_high = at_high / 2 if side > 0 else at_high
            low, at_low, side = middle, found, 1
    return high


class Walk:
    """A solution on its way: time, state and the step length that the last error allows."""

    def __init__(self, t: float, y: Vector, setting: Setting) -> None:
        """Start at time t [s] in state y."""
        self.t, self.y, self.setting = Real(t), y, setting
        self.length = Real(1e-4)

    def advance(
        self, field: Field, end: Real, project: Field, event: Callable[[Real, Vector], Real]
    ) -> bool:
        """Go on to `end`, or to where `event` becomes negative; return whether it did."""
        rows, tolerance, longest = self.setting
        while self.t < end:
            h = min(self.length, end - self.t, Real(longest))
            y, error = step(field, self.t, self.y, h, rows)
            factor = 0.9 * (tolerance / max(error, 1e-30)) ** (1 / (2 * rows - 1))
            if not error <= tolerance:
                self.length = h * max(0.1, factor) if np.isfinite(error) else h / 10
                continue
            if event(self.t + h, y) < -NOISE:
                self.locate(field, h, project, event)
                return True
            last = h == end - self.t
            self.t, self.y = end if last else self.t + h, project(self.t + h, y)
            self.length = (
                max(self.length, h) if last and factor > 1 else h * min(3.0, max(0.3, factor))
            )
        return False

    def locate(
        self, field: Field, h: Real, project: Field, event: Callable[[Real, Vector], Real]
    ) -> None:
        """Move to the moment within the next h at which `event` becomes negative.

        Every trial is a step of its own.
        """
        t, y, rows = self.t, self.y, self.setting.rows
        h = crossing(lambda part: event(t + part, step(field, t, y, part, rows)[0]) + NOISE, h)
        self.t, self.y = t + h, project(t + h, step(field, t, y, h, rows)[0])
