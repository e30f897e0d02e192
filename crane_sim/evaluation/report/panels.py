"""The panels that a figure and a page of a run show: which curves share an axis, in which unit and colour."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.layout import label
from crane_sim.recording.quantities import shown_joints

if TYPE_CHECKING:
    from crane_sim.recording.layout import Numbers
    from crane_sim.recording.run import RecordedRun

PALETTE = ("#1f6fb4", "#d9730d", "#2a9d5c", "#9450b3", "#008b94", "#c8332b", "#8a6d3b", "#c2418c")
"""Colours of joints, in the hues and the order of those in the Rerun viewer, dark enough for white paper."""
RUN_COLORS = (PALETTE[1], PALETTE[0], *PALETTE[2:])
"""Colours of runs beside one another: the first is that of a crane, as in the recording of a comparison."""
INK, SOFT = "#2f3a45", "#8a95a1"
SHARE = 0.1  # of an axis: a curve that moves over less of it gets an axis of its own
NAMED = 4  # curves in a title
PREFIXES = ((1e6, 2e6, "M"), (1e3, 2e4, "k"))  # factor, the peak from which on it is used, SI prefix
PREFIXED = ("N", "N m", "J", "W")


class Curve(NamedTuple):
    """One curve over the steps of a run."""

    name: str
    color: str
    values: Numbers  # (K,)
    dashed: bool = False  # a target, a command, or one of so many curves that colours come again
    dotted: bool = False  # what a sensor shows beside the truth, in a lighter tone


class Panel(NamedTuple):
    """Curves of one unit and of like size."""

    title: str
    unit: str
    curves: tuple[Curve, ...]


def panels_of(run: RecordedRun) -> list[Panel]:
    """Return the panels of a run, in the order in which they are shown; angles are in degrees."""
    return [panel for part in (_positions, _swing, _payload, _speeds, _efforts, _rest) for panel in part(run)]


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
    return [*_share("Joint angles", "°", curves["°"]), *_share("Joint lengths and positions", "m", curves["m"])]


def _speeds(run: RecordedRun) -> list[Panel]:
    curves: dict[str, list[list[Curve]]] = {}
    for name, color in joint_colors(run).items():
        i = run.crane.joint_names.index(name)
        unit, factor = _degrees(run.crane.joint_units[i])
        measured = _measured(name, color, factor, run.v, run.v_measured, i)
        curves.setdefault(f"{unit}/s", []).append([Curve(label(name), color, factor * run.v[:, i]), *measured])
    return [panel for unit, each in curves.items() for panel in _share("Joint speeds", unit, each)]


def _measured(name: str, color: str, factor: float, true: Numbers, shown: Numbers | None, i: int) -> list[Curve]:
    """Return the curve of what a sensor shows of coordinate i, or of its rate, where that is not the truth."""
    if shown is None or np.array_equal(true[:, i], shown[:, i]):
        return []
    return [Curve(f"{label(name)} measured", _lighten(color), factor * shown[:, i], dotted=True)]


def _lighten(color: str) -> str:
    """Return the tone of a colour #rrggbb that is half white."""
    return "#" + "".join(f"{(int(color[k : k + 2], 16) + 255) // 2:02x}" for k in (1, 3, 5))


def _efforts(run: RecordedRun) -> list[Panel]:
    curves: dict[str, list[list[Curve]]] = {}
    colors, crane = joint_colors(run), run.crane
    for k, (name, unit) in enumerate(zip(crane.actuated, crane.effort_units, strict=True)):
        pair = [Curve(label(name), colors.get(name, INK), run.u[:, k])]
        if unit == crane.command_units[k] and _differs(run.commands[:, k], run.u[:, k]):
            pair.append(Curve(f"{label(name)} command", colors.get(name, INK), run.commands[:, k], dashed=True))
        curves.setdefault(unit, []).append(pair)
    return [panel for unit, each in curves.items() for panel in _share("Efforts", unit, each)]


def _swing(run: RecordedRun) -> list[Panel]:
    """Return the swing from the vertical, and its coordinates where the joints have them."""
    curves = [[Curve("from the vertical", INK, np.degrees(run.swing))]]
    for name, color in joint_colors(run).items():
        if name.startswith("swing_"):
            i, short = run.crane.joint_names.index(name), _short_swing(name)
            measured = _measured(short, color, _degrees("rad")[1], run.q, run.q_measured, i)
            curves.append([Curve(short, color, np.degrees(run.q[:, i])), *measured])
    return _share("Swing", "°", curves)


def _short_swing(name: str) -> str:
    """Return the name of a swing in a panel of swings: tangential, or that of the link whose angle it is."""
    short = label(name).removeprefix("swing ")
    return f"link {short}" if short.isdecimal() else short


def _payload(run: RecordedRun) -> list[Panel]:
    curves = [[Curve(name, PALETTE[i], run.payload[:, i])] for i, name in enumerate("xyz")]
    return _share("Payload position", "m", curves)


def _tensions(run: RecordedRun) -> list[Panel]:
    """Return the tensions of links or falls; `falls` of the frames tells which they are."""
    several, falls = run.tensions.shape[1] > 1, run.frames.falls is not None
    if not several and not falls:
        return _share("Rope tension", "N", [[Curve("uppermost link", INK, run.tension)]])
    curves = []
    for k, values in enumerate(run.tensions.T):
        color = PALETTE[k % len(PALETTE)] if several else INK
        curves.append([Curve(f"{'fall' if falls else 'link'} {k + 1}", color, values, dashed=k >= len(PALETTE))])
    return _share("Rope tension", "N", curves)


def _reeved_tensions(run: RecordedRun) -> list[Panel]:
    """Return the tensions of lead line and falls of a rope over sheaves, none without one."""
    if run.reeved is None:
        return []
    curves = [[Curve("lead line", INK, run.lead_line)]]
    for k, values in enumerate(run.falls.T):
        curves.append([Curve(f"fall {k + 1}", PALETTE[k % len(PALETTE)], values, dashed=k >= len(PALETTE))])
    return _share("Tension of lead line and falls", "N", curves)


def _rest(run: RecordedRun) -> list[Panel]:
    potential, energy = (each - each[0] for each in (run.potential, run.energy))
    curves = [
        [Curve("kinetic", PALETTE[0], run.kinetic)],
        [Curve("potential since the start", PALETTE[2], potential)],
        [Curve("total since the start", INK, energy)],
    ]
    panels = [*_tensions(run), *_reeved_tensions(run)]
    if run.contact is not None:
        panels += _share("Contact force", "N", [[Curve("on the load", PALETTE[2], run.contact)]])
    panels += _share("Energy", "J", curves)
    if run.lyapunov is not None:
        panels += _share("Lyapunov function of the law", "J", [[Curve("V", PALETTE[3], run.lyapunov[:, 0])]])
    return panels


def _share(title: str, unit: str, families: Sequence[Sequence[Curve]]) -> list[Panel]:
    """Return panels of curves that move over at least `SHARE` of their axis; families stay together."""
    groups: list[list[Sequence[Curve]]] = []
    for family in families:
        fitting = next((group for group in groups if _are_alike([*group, family])), None)
        if fitting is None:
            groups.append([family])
        else:
            fitting.append(family)
    return [
        _scale(Panel(_title(title, group, len(groups)), unit, tuple(curve for family in group for curve in family)))
        for group in groups
    ]


def _title(title: str, group: Sequence[Sequence[Curve]], count: int) -> str:
    """Return the title of one of several panels of a quantity: with the names of its curves, of targets not."""
    names = [family[0].name for family in group]
    return f"{title}: {', '.join(names[:NAMED])}{', ...' if names[NAMED:] else ''}" if count > 1 else title


def _are_alike(families: Sequence[Sequence[Curve]]) -> bool:
    ranges = [(min(_low(c) for c in family), max(-_low(c, -1.0) for c in family)) for family in families]
    whole = max(high for _, high in ranges) - min(low for low, _ in ranges)
    spans = [high - low for low, high in ranges]
    still = 1e-9 * max(abs(value) for pair in ranges for value in pair)
    if max(spans) <= still:
        return whole <= still
    return all(span >= SHARE * whole for span in spans)


def _low(curve: Curve, sign: float = 1.0) -> float:
    """Return the smallest finite value of a curve times a sign."""
    finite = curve.values[np.isfinite(curve.values)]
    return float((sign * finite).min(initial=np.inf)) if finite.size else 0.0


def _scale(panel: Panel) -> Panel:
    """Return a panel in a larger unit where its numbers would be long."""
    peak = max(max(abs(_low(curve)), abs(_low(curve, -1.0))) for curve in panel.curves)
    for factor, least, prefix in PREFIXES if panel.unit in PREFIXED else ():
        if peak >= least:
            curves = tuple(curve._replace(values=curve.values / factor) for curve in panel.curves)
            return Panel(panel.title, prefix + panel.unit, curves)
    return panel


def _degrees(unit: str) -> tuple[str, float]:
    """Return the unit that is shown, and the factor to it."""
    return ("°", 180.0 / np.pi) if unit == "rad" else (unit, 1.0)


def _differs(command: Numbers, effort: Numbers) -> bool:
    known = np.isfinite(command)
    return bool(np.any(np.abs(command - effort)[known] > 1e-6 * np.abs(effort).max(initial=1e-12)))
