"""The panels that a figure and a page of a run show: which curves share an axis, in which unit and colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.layout import label
from crane_sim.recording.quantities import shown_joints

if TYPE_CHECKING:
    from crane_sim.recording.layout import Array
    from crane_sim.recording.run import RecordedRun

PALETTE = ("#1f6fb4", "#d9730d", "#2a9d5c", "#9450b3", "#008b94", "#c8332b", "#8a6d3b", "#c2418c")
"""Colours of joints, in the hues and the order of those in the Rerun viewer, dark enough for white paper."""
RUN_COLORS = (PALETTE[1], PALETTE[0], *PALETTE[2:])
"""Colours of runs in a comparison, chosen for contrast; the first is yellow like the crane, as in its recording."""
TEXT_COLOR, AXIS_COLOR = "#2f3a45", "#8a95a1"
MIN_SPAN_FRACTION = 0.1  # of an axis: a curve with a smaller span gets an axis of its own
MAX_TITLE_NAMES = 4  # names of curves in a title
PREFIXES = ((1e6, 2e6, "M"), (1e3, 2e4, "k"))  # factor, smallest peak for which it is used, SI prefix
UNITS_WITH_PREFIX = ("N", "N m", "J", "W")


class Curve(NamedTuple):
    """One curve over the steps of a run."""

    name: str
    color: str
    values: Array  # (K,)
    dashed: bool = False  # a target, a command, or a curve whose colour another one has already
    dotted: bool = False  # what a sensor measures, in a lighter tone


class Panel(NamedTuple):
    """Curves of one unit that share an axis."""

    title: str
    unit: str
    curves: tuple[Curve, ...]


def panels_of(run: RecordedRun) -> list[Panel]:
    """Return the panels of a run, in the order in which they are shown; angles are in degrees."""
    return [
        panel
        for part in (_positions, _swing, _payload, _speeds, _efforts, _tensions_and_energies)
        for panel in part(run)
    ]


def joint_colors(run: RecordedRun) -> dict[str, str]:
    """Return the colour of every joint that is shown."""
    return {name: PALETTE[i % len(PALETTE)] for i, name in enumerate(shown_joints(run))}


def _positions(run: RecordedRun) -> list[Panel]:
    curves: dict[str, list[list[Curve]]] = {"°": [], "m": []}
    for name, color in joint_colors(run).items():
        i = run.crane.joint_names.index(name)
        if name.startswith("swing_") or run.crane.joint_units[i] == "1":
            continue
        unit, factor = _degrees(run.crane.joint_units[i])
        pair = [Curve(label(name), color, factor * run.q[:, i])]
        if run.reference is not None and name in run.crane.actuated:
            target = factor * run.reference[:, run.crane.actuated.index(name)]
            pair.append(Curve(f"{label(name)} target", color, target, dashed=True))
        curves[unit].append(pair + _measured(name, color, factor, run.q, run.q_measured, i))
    return [
        *_group_by_axis("Joint angles", "°", curves["°"]),
        *_group_by_axis("Joint lengths and positions", "m", curves["m"]),
    ]


def _speeds(run: RecordedRun) -> list[Panel]:
    curves: dict[str, list[list[Curve]]] = {}
    for name, color in joint_colors(run).items():
        i = run.crane.joint_names.index(name)
        unit, factor = _degrees(run.crane.joint_units[i])
        measured = _measured(name, color, factor, run.v, run.v_measured, i)
        curves.setdefault(f"{unit}/s", []).append([Curve(label(name), color, factor * run.v[:, i]), *measured])
    titles = {"°/s": "Joint angular speeds"}
    return [
        panel for unit, each in curves.items() for panel in _group_by_axis(titles.get(unit, "Joint speeds"), unit, each)
    ]


def _measured(name: str, color: str, factor: float, true: Array, measured: Array | None, i: int) -> list[Curve]:
    """Return the curve of what a sensor measures of coordinate i, or of its velocity, where it differs from `true`."""
    if measured is None or np.array_equal(true[:, i], measured[:, i]):
        return []
    return [Curve(f"{label(name)} measured", _lighten(color), factor * measured[:, i], dotted=True)]


def _lighten(color: str) -> str:
    """Return a colour #rrggbb mixed with as much white."""
    return "#" + "".join(f"{(int(color[k : k + 2], 16) + 255) // 2:02x}" for k in (1, 3, 5))


def _efforts(run: RecordedRun) -> list[Panel]:
    curves: dict[str, list[list[Curve]]] = {}
    colors, crane = joint_colors(run), run.crane
    for k, (name, unit) in enumerate(zip(crane.actuated, crane.effort_units, strict=True)):
        pair = [Curve(label(name), colors.get(name, TEXT_COLOR), run.u[:, k])]
        if unit == crane.command_units[k] and _differs(run.commands[:, k], run.u[:, k]):
            pair.append(Curve(f"{label(name)} command", colors.get(name, TEXT_COLOR), run.commands[:, k], dashed=True))
        curves.setdefault(unit, []).append(pair)
    return [panel for unit, each in curves.items() for panel in _group_by_axis("Efforts", unit, each)]


def _swing(run: RecordedRun) -> list[Panel]:
    """Return the swing from the vertical, and its coordinates where the joints have them."""
    curves = [[Curve("from the vertical", TEXT_COLOR, np.degrees(run.swing))]]
    for name, color in joint_colors(run).items():
        if name.startswith("swing_"):
            i, short = run.crane.joint_names.index(name), _short_swing(name)
            measured = _measured(short, color, _degrees("rad")[1], run.q, run.q_measured, i)
            curves.append([Curve(short, color, np.degrees(run.q[:, i])), *measured])
    return _group_by_axis("Swing", "°", curves)


def _short_swing(name: str) -> str:
    """Return the name of a swing angle in a panel of swings: `tangential`, or of a chain `link 2`."""
    short = label(name).removeprefix("swing ")
    return f"link {short}" if short.isdecimal() else short


def _payload(run: RecordedRun) -> list[Panel]:
    curves = [[Curve(name, PALETTE[i], run.payload[:, i])] for i, name in enumerate("xyz")]
    return _group_by_axis("Payload position", "m", curves)


def _tensions(run: RecordedRun) -> list[Panel]:
    """Return the tensions of links, or of falls where the frames have them."""
    several, falls = run.tensions.shape[1] > 1, run.frames.falls is not None
    if not several and not falls:
        return _group_by_axis("Rope tension", "N", [[Curve("uppermost link", TEXT_COLOR, run.tension)]])
    curves = []
    for k, values in enumerate(run.tensions.T):
        color = PALETTE[k % len(PALETTE)] if several else TEXT_COLOR
        curves.append([Curve(f"{'fall' if falls else 'link'} {k + 1}", color, values, dashed=k >= len(PALETTE))])
    return _group_by_axis("Rope tension", "N", curves)


def _reeved_tensions(run: RecordedRun) -> list[Panel]:
    """Return the tensions of lead line and falls of a rope over sheaves; empty without sheaves."""
    if run.reeved is None:
        return []
    curves = [[Curve("lead line", TEXT_COLOR, run.lead_line)]]
    for k, values in enumerate(run.falls.T):
        curves.append([Curve(f"fall {k + 1}", PALETTE[k % len(PALETTE)], values, dashed=k >= len(PALETTE))])
    return _group_by_axis("Tension of lead line and falls", "N", curves)


def _tensions_and_energies(run: RecordedRun) -> list[Panel]:
    potential, energy = (each - each[0] for each in (run.potential, run.energy))
    curves = [
        [Curve("kinetic", PALETTE[0], run.kinetic)],
        [Curve("potential since the start", PALETTE[2], potential)],
        [Curve("total since the start", TEXT_COLOR, energy)],
    ]
    panels = [*_tensions(run), *_reeved_tensions(run)]
    if run.contact is not None:
        panels += _group_by_axis("Contact force", "N", [[Curve("on the load", PALETTE[2], run.contact)]])
    panels += _group_by_axis("Energy", "J", curves)
    if run.lyapunov is not None:
        panels += _group_by_axis("Lyapunov function of the law", "J", [[Curve("V", PALETTE[3], run.lyapunov[:, 0])]])
    return panels


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
        _scale(Panel(_title(title, group, len(groups)), unit, tuple(curve for curves in group for curve in curves)))
        for group in groups
    ]


def _title(title: str, group: Sequence[Sequence[Curve]], count: int) -> str:
    """Return the title of a panel; where a quantity has several, with the name of the first curve of each set."""
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
    """Return the smallest and the largest finite value of curves; a curve without any counts as 0."""
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


def _degrees(unit: str) -> tuple[str, float]:
    """Return the unit that is shown, and the factor to it."""
    return ("°", 180.0 / np.pi) if unit == "rad" else (unit, 1.0)


def _differs(command: Array, effort: Array) -> bool:
    known = np.isfinite(command)
    return bool(np.any(np.abs(command - effort)[known] > 1e-6 * np.abs(effort).max(initial=1e-12)))
