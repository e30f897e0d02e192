"""The panels of a run's figure and page: which curves share an axis, in which unit, colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.quantities import PALETTE, Quantity, curve_sets

if TYPE_CHECKING:
    from crane_sim.recording.quantities import Curve
    from crane_sim.recording.run import RecordedRun

RUN_COLORS = (PALETTE[1], PALETTE[0], *PALETTE[2:])
"""Colours of runs in a comparison, chosen for contrast; the first is yellow like the crane, as in
its recording."""
AXIS_COLOR = "#8a95a1"
MIN_SPAN_FRACTION = 0.1  # of an axis: a curve with a smaller span gets an axis of its own
MAX_TITLE_NAMES = 4  # names of curves in a title
# factor, smallest peak for which it is used, SI prefix
PREFIXES = ((1e6, 2e6, "M"), (1e3, 2e4, "k"))
UNITS_WITH_PREFIX = ("N", "N m", "J", "W")


class Panel(NamedTuple):
    """Curves of one unit that share an axis."""

    title: str
    unit: str
    curves: tuple[Curve, ...]


def panels_of(run: RecordedRun) -> list[Panel]:
    """Return the panels of a run, in the order in which they are shown; angles are in degrees."""
    by_axis: dict[Quantity, list[Sequence[Curve]]] = {}
    for each in curve_sets(run):
        by_axis.setdefault(Quantity(each.title, each.unit), []).append(each.curves)
    return [
        panel
        for (title, unit), curves in by_axis.items()
        for panel in _group_by_axis(title, unit, curves)
    ]


def _group_by_axis(title: str, unit: str, curve_sets: Sequence[Sequence[Curve]]) -> list[Panel]:
    """Return panels in which each set of curves spans at least `MIN_SPAN_FRACTION` of its axis.

    A set is one joint's curve with its target, command or measured one; it is never divided.
    """
    groups: list[list[Sequence[Curve]]] = []
    for curves in curve_sets:
        fitting = next((group for group in groups if _fit_one_axis([*group, curves])), None)
        if fitting is None:
            groups.append([curves])
        else:
            fitting.append(curves)
    return [
        _scale(
            Panel(
                _title(title, group, len(groups)),
                unit,
                tuple(curve for curves in group for curve in curves),
            )
        )
        for group in groups
    ]


def _title(title: str, group: Sequence[Sequence[Curve]], count: int) -> str:
    """Return a panel's title.

    Where a quantity has several, it has the name of the first curve of each set.
    """
    names = [curves[0].name for curves in group]
    more = ", ..." if names[MAX_TITLE_NAMES:] else ""
    return f"{title}: {', '.join(names[:MAX_TITLE_NAMES])}{more}" if count > 1 else title


def _fit_one_axis(curve_sets: Sequence[Sequence[Curve]]) -> bool:
    """Return whether no set of curves has too small a span on an axis with all of them."""
    ranges = [_value_range(curves) for curves in curve_sets]
    total_low, total_high = min(low for low, _ in ranges), max(high for _, high in ranges)
    total, spans = total_high - total_low, [high - low for low, high in ranges]
    rounding = 1e-9 * max(abs(total_low), abs(total_high))
    if max(spans) <= rounding:
        return total <= rounding
    return all(span >= MIN_SPAN_FRACTION * total for span in spans)


def _value_range(curves: Sequence[Curve]) -> tuple[float, float]:
    """Return the smallest and largest finite value of curves; one without any counts as 0."""
    finite = [curve.values[np.isfinite(curve.values)] for curve in curves]
    low = min(each.min() if each.size else 0.0 for each in finite)
    high = max(each.max() if each.size else 0.0 for each in finite)
    return float(low), float(high)


def _scale(panel: Panel) -> Panel:
    """Return a panel with an SI prefix to its unit where its values are large."""
    peak = max(map(abs, _value_range(panel.curves)))
    for factor, least, prefix in PREFIXES if panel.unit in UNITS_WITH_PREFIX else ():
        if peak >= least:
            curves = tuple(curve._replace(values=curve.values / factor) for curve in panel.curves)
            return Panel(panel.title, prefix + panel.unit, curves)
    return panel
