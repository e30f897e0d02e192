"""The curves of a recording: their entities, names and colours, and their values from a block.

`plots/*` keeps every quantity in SI at the full rate. `shown/*` repeats what the overview plots, one unit per entity
and angles in degrees, because a plot has one axis and people read degrees.

What a curve of a recording is: its entity, its name and colour, and how a block yields its values.

The curves of an overhead crane's cable, computed from its nodes, independent of its coordinates.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from crane_sim.recording.layout import Block, Layout, label
from crane_sim.recording.rerun.unit_plots import UnitPlot, commands, efforts, errors, rates

if TYPE_CHECKING:
    from collections.abc import Callable, Sequence

    from crane_sim.recording.layout import Array
    from crane_sim.recording.suspension import Suspension


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


AXES = ("surge [m]", "sway [m]", "heave [m]", "roll [rad]", "pitch [rad]", "yaw [rad]")


class Channel(NamedTuple):
    """The curves of one entity; `values` returns (K,) or (K, curves), or None where the run has no such quantity."""

    entity: str
    names: tuple[str, ...]
    colors: tuple[Color, ...]
    values: Callable[[Block], Array | None]
    width: float = 1.6
    stride: int = 1  # steps from one row to the next


def colors_of(which: Sequence[int]) -> tuple[Color, ...]:
    """Return the colours of curves by their numbers."""
    return tuple(PALETTE[i % len(PALETTE)] for i in which)


def soften(color: Color) -> Color:
    """Return the darker tone that marks a target beside the curve that is to reach it."""
    red, green, blue = color
    return (6 * red // 10, 6 * green // 10, 6 * blue // 10)


def lighten(color: Color) -> Color:
    """Return the lighter tone that marks measured values."""
    red, green, blue = ((value + 2 * 255) // 3 for value in color)
    return red, green, blue


BLUE_GREEN, XZ = (PALETTE[0], PALETTE[2]), (0, 2)


def cable_channels(cable: Suspension) -> list[Channel]:
    """Return the payload's trajectory, swings that are no joints, the length of an elastic cable."""
    listed = _planar(cable) if cable.planar else _spatial()
    if cable.elastic:
        listed.append(Channel("shown/cable_m", ("cable",), (PALETTE[3],), lambda b: _length(b.nodes)))
    return listed


def _planar(cable: Suspension) -> list[Channel]:
    listed = [Channel("shown/payload_m", ("x", "z"), BLUE_GREEN, lambda b: b.nodes[:, -1, XZ])]
    if cable.elastic:
        names, lower = tuple(f"link {k}" for k in cable.links), np.array(cable.links)
        colors = colors_of(range(1, 1 + len(names)))
        listed.append(
            Channel(
                "shown/swing_deg",
                names,
                colors,
                lambda b: _angle_from_vertical(_link_vectors(b.nodes)[:, lower - 1], 0),
            )
        )
    if len(cable.links) > 1:
        names = ("trolley to payload",)
        listed.append(
            Channel("shown/swing_total_deg", names, (PLAIN,), lambda b: _angle_from_vertical(_whole(b.nodes), 0), 2.2)
        )
    return listed


def _spatial() -> list[Channel]:
    return [
        Channel("shown/lean_deg", ("towards x", "towards y"), PALETTE, lambda b: _leans(_whole(b.nodes))),
        Channel("shown/swing_total_deg", ("from the vertical",), (PLAIN,), lambda b: np.degrees(b.swing)),
    ]


def _link_vectors(nodes: Array) -> Array:
    """Return the vectors (K, N, 3) from node to node."""
    return np.diff(nodes, axis=1)


def _whole(nodes: Array) -> Array:
    """Return the vector (K, 3) from the trolley to the payload."""
    return nodes[:, -1] - nodes[:, 0]


def _angle_from_vertical(line: Array, axis: int) -> Array:
    """Return the angles [°] from the downward vertical of vectors (..., 3), seen across a horizontal axis."""
    return np.degrees(np.arctan2(line[..., axis], -line[..., 2]))


def _leans(line: Array) -> Array:
    return np.column_stack([_angle_from_vertical(line, 0), _angle_from_vertical(line, 1)])


def _length(nodes: Array) -> Array:
    return np.linalg.norm(_link_vectors(nodes), axis=2).sum(axis=1)


def channels(layout: Layout) -> list[Channel]:
    """List every curve of a run, in the order in which they are written."""
    listed = [*_stored_curves(layout), *_positions(layout), *_shown_curves(layout)]
    return [channel for channel in listed if channel.names]


def angle_indices(layout: Layout) -> list[int]:
    """Return the indices of the coordinates that are actuated angles."""
    return [i for i in layout.driven if layout.units[i] == "rad"]


def _stored_curves(layout: Layout) -> list[Channel]:
    driven = layout.driven
    names = tuple(f"{label(j)} [{u}]" for j, u in zip(layout.joints, layout.units, strict=True))
    rates = tuple(f"{label(j)} [{u}/s]" for j, u in zip(layout.joints, layout.units, strict=True))
    efforts, commands = (
        tuple(f"{label(j)} [{u}]" for j, u in zip(layout.actuated, units, strict=True))
        for units in (layout.effort_units, layout.command_units)
    )
    derived = f", {layout.provenance}" if layout.provenance else ""
    targets, colors = tuple(names[i] for i in driven), colors_of(range(len(names)))
    return [
        Channel("plots/q", names, colors, lambda b: b.q),
        Channel("plots/v", rates, colors, lambda b: b.v),
        Channel("plots/q_ref", targets, colors_of(driven), lambda b: b.reference),
        Channel("plots/q_err", targets, colors_of(driven), lambda b: _minus(b.reference, b.q[:, driven])),
        Channel("plots/effort", efforts, colors_of(driven), lambda b: b.effort),
        Channel("plots/effort_demanded", commands, colors_of(driven), lambda b: b.demanded),
        Channel("plots/payload", ("x [m]", "y [m]", "z [m]"), PALETTE, lambda b: b.nodes[:, -1]),
        Channel("plots/swing", (f"from the vertical [rad]{derived}",), (PLAIN,), lambda b: b.swing),
        Channel("plots/energy", (f"energy [J]{derived}",), (PALETTE[1],), lambda b: b.energy),
        Channel("plots/energy_parts", ("kinetic [J]", "potential [J]"), BLUE_GREEN, _energy_parts),
        Channel("plots/lyapunov", ("V [J]",), (PALETTE[3],), lambda b: _entry_column(b.lyapunov, 0)),
        Channel("plots/lyapunov_rate", ("dV/dt [W]",), (PALETTE[4],), lambda b: _entry_column(b.lyapunov, 1)),
        *(_tensions(layout, derived), _reeved_tensions(layout, derived)),
        *_of_some_runs(layout, names, rates),
    ]


def _of_some_runs(layout: Layout, names: tuple[str, ...], rates: tuple[str, ...]) -> list[Channel]:
    """Return the measured coordinates and rates of a crane with sensors, and the force on a load that may touch."""
    colors = colors_of(range(len(names)))
    return [
        Channel("plots/q_measured", names if layout.sensed else (), colors, lambda b: _half(b.measured, 0)),
        Channel("plots/v_measured", rates if layout.sensed else (), colors, lambda b: _half(b.measured, 1)),
        Channel("plots/contact", ("normal force on the load [N]",), (PALETTE[2],), lambda b: b.contact),
    ]


def _tensions(layout: Layout, derived: str) -> Channel:
    """Return the tensions of links or falls, in the darker tone where a colour is used again."""
    names = layout.ropes.tensions
    colors = (*PALETTE, *map(soften, PALETTE)) if len(names) > 1 else (PALETTE[3],)
    return Channel("plots/tension", tuple(f"{name} [N]{derived}" for name in names), colors, lambda b: b.tensions)


def _reeved_tensions(layout: Layout, derived: str) -> Channel:
    """Return the tensions of lead line and falls of a rope over sheaves; it has no names without one."""
    names = tuple(f"{name} [N]{derived}" for name in layout.ropes.reeved)
    falls = (*PALETTE, *map(soften, PALETTE)) * (1 + len(names) // (2 * len(PALETTE)))
    return Channel("plots/reeved_tension", names, (PLAIN, *falls)[: len(names)], lambda b: b.reeved)


def _positions(layout: Layout) -> list[Channel]:
    """Return the positions that a reader needs to draw the crane: those of the nodes once a frame of the 3D scene."""
    falls, stride = layout.ropes.falls, layout.frame_stride
    ends = () if falls is None else ("upper and lower end of each fall in the base [m]",)
    return [
        Channel("plots/tip", ("x [m]", "y [m]", "z [m]"), PALETTE, lambda b: b.nodes[:, layout.ropes.tip]),
        Channel("plots/base", AXES, PALETTE, lambda b: b.base),
        Channel("frames/nodes", ("x, y, z of each node [m]",), (), lambda b: _flat(b.nodes), 1.0, stride),
        Channel("frames/target", ("x [m]", "y [m]", "z [m]"), (), _target, 1.0, stride),
        Channel("frames/falls", ends, (), lambda b: _flat(layout.fall_ends(b)), 1.0, stride),
    ]


def _shown_curves(layout: Layout) -> list[Channel]:
    length_plots = [(plot.entity, [layout.joints.index(name) for name in plot.joints]) for plot in layout.length_plots]
    return [
        *_with_targets(layout, "shown/angle_deg", angle_indices(layout), np.degrees),
        *(curves for entity, which in length_plots for curves in _with_targets(layout, entity, which, np.asarray)),
        *_swings(layout),
        *_split(layout, errors(layout), lambda b: _minus(b.reference, b.q[:, layout.driven])),
        *_split(layout, rates(layout), lambda b: b.v[:, layout.moving]),
        *(_measured_rates(layout, plot) for plot in rates(layout)),
        *_split(layout, efforts(layout), lambda b: b.effort),
        *_split(layout, commands(layout), lambda b: b.demanded),
        _energy_changes(),
    ]


def _swings(layout: Layout) -> list[Channel]:
    """Return the swings that are joints, and the other curves of the cable."""
    which = [layout.joints.index(name) for name in layout.swings]
    joints = _of(layout, "shown/swing_deg", which, lambda b: np.degrees(b.q[:, which]))
    measured = _measured(layout, "shown/swing_deg", which, np.degrees)
    if layout.suspension:
        return [joints, measured, *cable_channels(layout.suspension)]
    total = Channel("shown/swing_total_deg", ("from the vertical",), (PLAIN,), lambda b: np.degrees(b.swing))
    return [joints, measured, total]


def _split(layout: Layout, plots: list[UnitPlot], values: Callable[[Block], Array | None]) -> list[Channel]:
    """Return the curves of a quantity (K, components) in plots of one unit each."""

    def channel(plot: UnitPlot) -> Channel:
        def shown(block: Block) -> Array | None:
            rows = values(block)
            return None if rows is None else plot.convert(rows[:, plot.columns])

        return Channel(plot.entity, plot.names, _colors(layout, plot.coordinates), shown)

    return [channel(plot) for plot in plots]


def _energy_changes() -> Channel:
    """Return the energies less the initial potential energy, which would dwarf the kinetic one."""
    names = ("kinetic", "potential since the start", "sum")
    return Channel(
        "shown/energy_J",
        names,
        (PALETTE[0], PALETTE[2], PALETTE[1]),
        lambda b: np.column_stack([b.kinetic, b.raised, b.kinetic + b.raised]),
    )


def _with_targets(layout: Layout, entity: str, which: list[int], convert: Callable[[Array], Array]) -> list[Channel]:
    """Return the curves of coordinates and, for those that are actuated, of their targets."""
    curves = _of(layout, entity, which, lambda b: convert(b.q[:, which]))
    driven = [i for i in which if i in layout.driven]
    columns = [layout.driven.index(i) for i in driven]
    names = tuple(f"{label(layout.joints[i])} target" for i in driven)
    colors = tuple(soften(color) for color in _colors(layout, driven))
    target = Channel(
        f"{entity}_target",
        names,
        colors,
        lambda b: None if b.reference is None else convert(b.reference[:, columns]),
        1.2,
    )
    return [target, curves, _measured(layout, entity, which, convert)]


def _measured(
    layout: Layout, entity: str, which: Sequence[int], convert: Callable[[Array], Array], rate: bool = False
) -> Channel:
    """Return measured coordinates, or their rates: thin, in a lighter tone of the same colours."""
    first = len(layout.joints) if rate else 0
    sensed = [i for i in which if first + i in layout.sensed]
    names = tuple(f"{label(layout.joints[i])} measured" for i in sensed)
    colors = tuple(lighten(color) for color in _colors(layout, sensed))
    columns = [first + i for i in sensed]
    return Channel(
        f"{entity}_measured",
        names,
        colors,
        lambda b: None if b.measured is None else convert(b.measured[:, columns]),
        0.8,
    )


def _measured_rates(layout: Layout, plot: UnitPlot) -> Channel:
    return _measured(layout, plot.entity, plot.coordinates, plot.convert, rate=True)


def _of(layout: Layout, entity: str, which: Sequence[int], values: Callable[[Block], Array]) -> Channel:
    return Channel(entity, tuple(label(layout.joints[i]) for i in which), _colors(layout, which), values)


def _colors(layout: Layout, which: Sequence[int]) -> tuple[tuple[int, int, int], ...]:
    """Return colours that are different for all coordinates that are plotted."""
    return colors_of([layout.moving.index(i) for i in which])


def _energy_parts(block: Block) -> Array:
    return np.column_stack([block.kinetic, block.potential])


def _target(block: Block) -> Array | None:
    return None if block.target is None else block.target[:, -1]


def _flat(nodes: Array | None) -> Array | None:
    return None if nodes is None else nodes.reshape(len(nodes), -1)


def _entry_column(values: Array | None, index: int) -> Array | None:
    return None if values is None else values[:, index]


def _half(measured: Array | None, part: int) -> Array | None:
    """Return the positions (0) or the rates (1) of measured states (K, 2 nq)."""
    return None if measured is None else np.hsplit(measured, 2)[part]


def _minus(left: Array | None, right: Array) -> Array | None:
    return None if left is None else left - right
