"""The curves of a recording: which entity holds them, their names and colours, and how a block yields their values.

`plots/*` keeps every quantity in SI at the full rate. `shown/*` repeats what the overview plots, one unit per entity
and angles in degrees, because a plot has one axis and people read degrees.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.layout import Block, Layout, label

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from crane_sim.recording.layout import Numbers

Color = tuple[int, int, int]
PALETTE: tuple[Color, ...] = (
    (86, 156, 236),
    (245, 166, 60),
    (94, 201, 118),
    (205, 128, 224),
    (70, 204, 205),
    (240, 100, 96),
)
PLAIN: Color = (226, 230, 236)


class Channel(NamedTuple):
    """The curves of one entity; `values` returns (K,) or (K, curves), or None where the run has no such quantity."""

    entity: str
    names: tuple[str, ...]
    colors: tuple[Color, ...]
    values: Callable[[Block], Numbers | None]
    width: float = 1.6


def channels(layout: Layout) -> list[Channel]:
    """List every curve of a run, in the order in which they are written."""
    return _stored(layout) + _shown(layout)


def soften(color: Color) -> Color:
    """Return the darker tone that marks a target beside the curve that is to reach it."""
    red, green, blue = color
    return (6 * red // 10, 6 * green // 10, 6 * blue // 10)


def pick(layout: Layout, unit: str, actuated: bool) -> list[int]:
    """Return the indices of the coordinates with this unit that are, or are not, actuated."""
    pairs = enumerate(zip(layout.joints, layout.units, strict=True))
    return [i for i, (joint, own) in pairs if own == unit and (joint in layout.actuated) is actuated]


def _stored(layout: Layout) -> list[Channel]:
    nu = len(layout.actuated)
    names = tuple(f"{label(j)} [{u}]" for j, u in zip(layout.joints, layout.units, strict=True))
    rates = tuple(f"{label(j)} [{u}/s]" for j, u in zip(layout.joints, layout.units, strict=True))
    efforts = tuple(f"{label(j)} [{u}]" for j, u in zip(layout.actuated, layout.effort_units, strict=True))
    colors = tuple(PALETTE[i % len(PALETTE)] for i in range(len(names)))
    return [
        Channel("plots/q", names, colors, lambda b: b.q),
        Channel("plots/v", rates, colors, lambda b: b.v),
        Channel("plots/q_ref", names[:nu], colors, lambda b: b.reference),
        Channel("plots/q_err", names[:nu], colors, lambda b: _minus(b.reference, b.q[:, :nu])),
        Channel("plots/effort", efforts, colors, lambda b: b.effort),
        Channel("plots/effort_demanded", efforts, colors, lambda b: b.demanded),
        Channel("plots/payload", ("x [m]", "y [m]", "z [m]"), PALETTE, lambda b: b.nodes[:, -1]),
        Channel("plots/swing", ("from the vertical [rad]",), (PLAIN,), lambda b: b.swing),
        Channel("plots/energy", ("energy [J]",), (PALETTE[1],), lambda b: b.energy),
        Channel("plots/lyapunov", ("V [J]",), (PALETTE[3],), lambda b: _column(b.lyapunov, 0)),
        Channel("plots/lyapunov_rate", ("dV/dt [W]",), (PALETTE[4],), lambda b: _column(b.lyapunov, 1)),
        Channel("plots/tension", ("rope tension [N]",), (PALETTE[3],), lambda b: b.tension),
    ]


def _shown(layout: Layout) -> list[Channel]:
    turns, lengths = pick(layout, "rad", actuated=True), pick(layout, "m", actuated=True)
    swings = pick(layout, "rad", actuated=False)
    torques = [i for i, unit in enumerate(layout.effort_units) if unit == "N m"]
    names = tuple(label(layout.joints[i]) for i in swings)
    colors = tuple(PALETTE[i % len(PALETTE)] for i in swings)
    return [
        *_pair(layout, "shown/angle_deg", turns, lambda b: np.degrees(b.q), lambda b: _degrees(b.reference)),
        *_pair(layout, "shown/length_m", lengths, lambda b: b.q, lambda b: b.reference),
        Channel("shown/swing_deg", names, colors, lambda b: np.degrees(b.q[:, swings])),
        Channel("shown/swing_total_deg", ("from the vertical",), (PLAIN,), lambda b: np.degrees(b.swing)),
        _of(layout, "shown/torque_Nm", torques, lambda b: b.effort),
    ]


def _pair(
    layout: Layout,
    entity: str,
    which: list[int],
    actual: Callable[[Block], Numbers],
    target: Callable[[Block], Numbers | None],
) -> list[Channel]:
    curves = _of(layout, entity, which, actual)
    names = tuple(f"{name} target" for name in curves.names)
    colors = tuple(soften(color) for color in curves.colors)
    return [Channel(f"{entity}_target", names, colors, lambda b: _columns(target(b), which), 1.2), curves]


def _of(layout: Layout, entity: str, which: list[int], values: Callable[[Block], Numbers]) -> Channel:
    names = tuple(label(layout.joints[i]) for i in which)
    colors = tuple(PALETTE[i % len(PALETTE)] for i in which)
    return Channel(entity, names, colors, lambda b: values(b)[:, which])


def _column(values: Numbers | None, index: int) -> Numbers | None:
    return None if values is None else values[:, index]


def _columns(values: Numbers | None, which: Sequence[int]) -> Numbers | None:
    return None if values is None else values[:, which]


def _degrees(values: Numbers | None) -> Numbers | None:
    return None if values is None else np.degrees(values)


def _minus(left: Numbers | None, right: Numbers) -> Numbers | None:
    return None if left is None else left - right
