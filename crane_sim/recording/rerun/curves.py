"""The curves of a recording: their entities, names and colours, and their values from a block.

`plots/*` keeps every quantity in SI at the full rate. `shown/*` repeats what the overview plots,
one unit per entity and angles in degrees, because a plot has one axis and people read degrees.
Curves of an overhead crane's cable are computed from its nodes, independent of its coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np

from crane_sim.recording.layout import Array, Block, Layout, label
from crane_sim.recording.quantities import COMMANDS, EFFORTS, ERROR, RATES, drawn_unit
from crane_sim.recording.suspension import Suspension

Values = Callable[[Block], Array | None]

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
BLUE_GREEN, XZ = (PALETTE[0], PALETTE[2]), (0, 2)
METRES = ("x [m]", "y [m]", "z [m]")
BASE_AXES = ("surge [m]", "sway [m]", "heave [m]", "roll [rad]", "pitch [rad]", "yaw [rad]")


class Channel(NamedTuple):
    """The curves of one entity; `values` returns (K,) or (K, curves), or None.

    It is None where the run has no such quantity.
    """

    entity: str
    names: tuple[str, ...]
    colors: tuple[Color, ...]
    values: Values
    width: float = 1.6
    stride: int = 1  # steps from one row to the next


class UnitPlot(NamedTuple):
    """The components of a quantity that share a unit: a plot has one axis."""

    entity: str
    title: str  # with the unit
    coordinates: tuple[int, ...]  # of the joints, in the order of q: they have the joint's colour
    columns: list[int]  # among the components of the quantity
    convert: Callable[[Array], Array]  # from SI to the unit that is shown


def errors(layout: Layout) -> list[UnitPlot]:
    """Return the plots of the tracking errors of the actuated joints."""
    units = [layout.units[i] for i in layout.driven]
    return _by_unit("error", layout.driven, units, dict.fromkeys(units, ERROR))


def rates(layout: Layout) -> list[UnitPlot]:
    """Return the plots of the rates of the coordinates that are plotted."""
    return _by_unit("rate", layout.moving, [f"{layout.units[i]}/s" for i in layout.moving], RATES)


def efforts(layout: Layout) -> list[UnitPlot]:
    """Return the plots of the efforts applied."""
    return _by_unit("effort", layout.driven, layout.effort_units, EFFORTS)


def commands(layout: Layout) -> list[UnitPlot]:
    """Return the plots of what is commanded."""
    return _by_unit("command", layout.driven, layout.command_units, COMMANDS)


def _by_unit(
    name: str, coordinates: Sequence[int], units: Sequence[str], titles: Mapping[str, str]
) -> list[UnitPlot]:
    """Return the plots of a quantity of the coordinates, in the order of their units (SI)."""
    plots = []
    for unit in dict.fromkeys(units):
        columns = [i for i, own in enumerate(units) if own == unit]
        shown, _ = drawn_unit(unit)
        word = shown.replace("°", "deg").replace("/", "_").replace("²", "2").replace(" ", "")
        convert = np.asarray if shown == unit else np.degrees
        which = tuple(coordinates[i] for i in columns)
        plots.append(
            UnitPlot(f"shown/{name}_{word}", f"{titles[unit]} [{shown}]", which, columns, convert)
        )
    return plots


def channels(layout: Layout) -> list[Channel]:
    """List every curve of a run, in the order in which they are written."""
    listed = [*_stored_curves(layout), *_positions(layout), *_shown_curves(layout)]
    return [channel for channel in listed if channel.names]


def angle_indices(layout: Layout) -> list[int]:
    """Return the indices of the coordinates that are actuated angles."""
    return [i for i in layout.driven if layout.units[i] == "rad"]


def _with_units(joints: Sequence[str], units: Sequence[str], suffix: str = "") -> tuple[str, ...]:
    return tuple(
        f"{label(joint)} [{unit}{suffix}]" for joint, unit in zip(joints, units, strict=True)
    )


def _stored_curves(layout: Layout) -> list[Channel]:
    derived = f", {layout.provenance}" if layout.provenance else ""
    return [
        *_joint_curves(layout),
        Channel("plots/payload", METRES, PALETTE, lambda b: b.nodes[:, -1]),
        Channel("plots/swing", (f"from the vertical [rad]{derived}",), (PLAIN,), lambda b: b.swing),
        *_energies(derived),
        _tensions(layout, derived),
        _reeved_tensions(layout, derived),
        *_measured_joints(layout),
        Channel(
            "plots/contact", ("normal force on the load [N]",), (PALETTE[2],), lambda b: b.contact
        ),
    ]


def _joint_curves(layout: Layout) -> list[Channel]:
    """Return the positions, speeds, targets and efforts of the coordinates."""
    driven = layout.driven
    names = _with_units(layout.joints, layout.units)
    speeds = _with_units(layout.joints, layout.units, "/s")
    applied = _with_units(layout.actuated, layout.effort_units)
    demanded = _with_units(layout.actuated, layout.command_units)
    targets = tuple(names[i] for i in driven)
    colors, own = _hues(range(len(names))), _hues(driven)
    return [
        Channel("plots/q", names, colors, lambda b: b.q),
        Channel("plots/v", speeds, colors, lambda b: b.v),
        Channel("plots/q_ref", targets, own, lambda b: b.reference),
        Channel("plots/q_err", targets, own, lambda b: _minus(b.reference, b.q[:, driven])),
        Channel("plots/effort", applied, own, lambda b: b.effort),
        Channel("plots/effort_demanded", demanded, own, lambda b: b.demanded),
    ]


def _energies(derived: str) -> list[Channel]:
    """Return the energies, and the Lyapunov function with its rate."""
    return [
        Channel("plots/energy", (f"energy [J]{derived}",), (PALETTE[1],), lambda b: b.energy),
        Channel("plots/energy_parts", ("kinetic [J]", "potential [J]"), BLUE_GREEN, _energy_parts),
        Channel("plots/lyapunov", ("V [J]",), (PALETTE[3],), lambda b: _columns(b.lyapunov, 0)),
        Channel(
            "plots/lyapunov_rate", ("dV/dt [W]",), (PALETTE[4],), lambda b: _columns(b.lyapunov, 1)
        ),
    ]


def _measured_joints(layout: Layout) -> list[Channel]:
    """Return the measured positions and speeds; no names where they are the true ones."""
    joints = layout.joints if layout.sensed else ()
    units = layout.units if layout.sensed else ()
    names = _with_units(joints, units)
    speeds = _with_units(joints, units, "/s")
    colors = _hues(range(len(layout.joints)))
    return [
        Channel("plots/q_measured", names, colors, lambda b: _half(b.measured, 0)),
        Channel("plots/v_measured", speeds, colors, lambda b: _half(b.measured, 1)),
    ]


def _tensions(layout: Layout, derived: str) -> Channel:
    """Return the tensions of links or falls, in the darker tone where a colour is used again."""
    names = layout.ropes.tensions
    colors = (*PALETTE, *map(_soften, PALETTE)) if len(names) > 1 else (PALETTE[3],)
    return Channel(
        "plots/tension",
        tuple(f"{name} [N]{derived}" for name in names),
        colors,
        lambda b: b.tensions,
    )


def _reeved_tensions(layout: Layout, derived: str) -> Channel:
    """Return the tensions of lead line and falls of a rope over sheaves; no names without one."""
    names = tuple(f"{name} [N]{derived}" for name in layout.ropes.reeved)
    falls = (*PALETTE, *map(_soften, PALETTE)) * (1 + len(names) // (2 * len(PALETTE)))
    return Channel("plots/reeved_tension", names, (PLAIN, *falls)[: len(names)], lambda b: b.reeved)


def _positions(layout: Layout) -> list[Channel]:
    """Return the positions needed to draw the crane: the nodes' once a frame of the 3D scene."""
    stride = layout.frame_stride
    ends = (
        () if layout.ropes.falls is None else ("upper and lower end of each fall in the base [m]",)
    )
    return [
        Channel("plots/tip", METRES, PALETTE, lambda b: b.nodes[:, layout.ropes.tip]),
        Channel("plots/base", BASE_AXES, PALETTE, lambda b: b.base),
        Channel(
            "frames/nodes", ("x, y, z of each node [m]",), (), lambda b: _flat(b.nodes), 1.0, stride
        ),
        Channel("frames/target", METRES, (), lambda b: _columns(b.target, -1), 1.0, stride),
        Channel("frames/falls", ends, (), lambda b: _flat(layout.fall_ends(b)), 1.0, stride),
    ]


def _shown_curves(layout: Layout) -> list[Channel]:
    lengths = [
        (plot.entity, [layout.joints.index(name) for name in plot.joints])
        for plot in layout.length_plots
    ]
    energies = ("kinetic", "potential since the start", "sum")
    return [
        *_with_targets(layout, "shown/angle_deg", angle_indices(layout), np.degrees),
        *(
            curves
            for entity, which in lengths
            for curves in _with_targets(layout, entity, which, np.asarray)
        ),
        *_swings(layout),
        *_split(layout, errors(layout), lambda b: _minus(b.reference, b.q[:, layout.driven])),
        *_split(layout, rates(layout), lambda b: b.v[:, layout.moving]),
        *(
            _measured(layout, plot.entity, plot.coordinates, plot.convert, rate=True)
            for plot in rates(layout)
        ),
        *_split(layout, efforts(layout), lambda b: b.effort),
        *_split(layout, commands(layout), lambda b: b.demanded),
        Channel("shown/energy_J", energies, ENERGY_COLORS, _energy_changes),
    ]


def _swings(layout: Layout) -> list[Channel]:
    """Return the swings that are joints, and the other curves of the cable."""
    which = [layout.joints.index(name) for name in layout.swings]
    joints = _of(layout, "shown/swing_deg", which, lambda b: np.degrees(b.q[:, which]))
    listed = [joints, _measured(layout, "shown/swing_deg", which, np.degrees)]
    cable, total = layout.suspension, "shown/swing_total_deg"
    if cable is None or not cable.planar:
        if cable:
            names = ("towards x", "towards y")
            listed.append(
                Channel("shown/lean_deg", names, PALETTE, lambda b: _lean(_whole(b.nodes)))
            )
        listed.append(
            Channel(total, ("from the vertical",), (PLAIN,), lambda b: np.degrees(b.swing))
        )
    elif len(cable.links) > 1:
        names = ("trolley to payload",)
        listed.append(
            Channel(total, names, (PLAIN,), lambda b: _lean(_whole(b.nodes))[..., 0], 2.2)
        )
    return listed + (_cable_curves(cable) if cable else [])


def _cable_curves(cable: Suspension) -> list[Channel]:
    """Return what only an overhead crane shows.

    That is a trajectory in the plane, and angles and length of an elastic cable.
    """
    listed = []
    if cable.planar:
        listed.append(
            Channel("shown/payload_m", ("x", "z"), BLUE_GREEN, lambda b: b.nodes[:, -1, XZ])
        )
    if cable.elastic:
        links = np.array(cable.links) - 1
        names = tuple(f"link {k}" for k in cable.links)
        angles = Channel(
            "shown/swing_deg",
            names,
            _hues(cable.links),
            lambda b: _lean(np.diff(b.nodes, axis=1)[:, links])[..., 0],
        )
        listed += [angles] if cable.planar else []
        listed.append(
            Channel("shown/cable_m", ("cable",), (PALETTE[3],), lambda b: _length(b.nodes))
        )
    return listed


ENERGY_COLORS = (PALETTE[0], PALETTE[2], PALETTE[1])


def _energy_changes(block: Block) -> Array:
    """Return the energies less the initial potential energy, which would dwarf the kinetic one."""
    return np.column_stack([block.kinetic, block.raised, block.kinetic + block.raised])


def _energy_parts(block: Block) -> Array:
    return np.column_stack([block.kinetic, block.potential])


def _split(layout: Layout, plots: list[UnitPlot], values: Values) -> list[Channel]:
    """Return the curves of a quantity (K, components) in plots of one unit each."""

    def shown(plot: UnitPlot, block: Block) -> Array | None:
        rows = values(block)
        return None if rows is None else plot.convert(rows[:, plot.columns])

    return [_of(layout, plot.entity, plot.coordinates, partial(shown, plot)) for plot in plots]


def _with_targets(
    layout: Layout, entity: str, which: list[int], convert: Callable[[Array], Array]
) -> list[Channel]:
    """Return the curves of coordinates and, for those that are actuated, of their targets."""
    curves = _of(layout, entity, which, lambda b: convert(b.q[:, which]))
    driven = [i for i in which if i in layout.driven]
    columns = [layout.driven.index(i) for i in driven]
    target = _of(
        layout,
        f"{entity}_target",
        driven,
        lambda b: None if b.reference is None else convert(b.reference[:, columns]),
    )
    names = tuple(f"{name} target" for name in target.names)
    target = target._replace(names=names, colors=tuple(map(_soften, target.colors)), width=1.2)
    return [target, curves, _measured(layout, entity, which, convert)]


def _measured(
    layout: Layout,
    entity: str,
    which: Sequence[int],
    convert: Callable[[Array], Array],
    rate: bool = False,
) -> Channel:
    """Return measured coordinates, or their rates: thin, in a lighter tone of the same colours."""
    first = len(layout.joints) if rate else 0
    sensed = [i for i in which if first + i in layout.sensed]
    columns = [first + i for i in sensed]
    curves = _of(
        layout,
        f"{entity}_measured",
        sensed,
        lambda b: None if b.measured is None else convert(b.measured[:, columns]),
    )
    names = tuple(f"{name} measured" for name in curves.names)
    return curves._replace(names=names, colors=tuple(map(_lighten, curves.colors)), width=0.8)


def _of(layout: Layout, entity: str, which: Sequence[int], values: Values) -> Channel:
    """Return curves of coordinates, in colours that are different for all that are plotted."""
    names = tuple(label(layout.joints[i]) for i in which)
    return Channel(entity, names, _hues([layout.moving.index(i) for i in which]), values)


def _hues(which: Sequence[int]) -> tuple[Color, ...]:
    """Return the colours of curves by their numbers."""
    return tuple(PALETTE[i % len(PALETTE)] for i in which)


def _soften(color: Color) -> Color:
    """Return the darker tone that marks a target beside the curve that is to reach it."""
    red, green, blue = color
    return (6 * red // 10, 6 * green // 10, 6 * blue // 10)


def _lighten(color: Color) -> Color:
    """Return the lighter tone that marks measured values."""
    red, green, blue = ((value + 2 * 255) // 3 for value in color)
    return red, green, blue


def _whole(nodes: Array) -> Array:
    """Return the vector (K, 3) from the trolley to the payload."""
    return nodes[:, -1] - nodes[:, 0]


def _lean(line: Array) -> Array:
    """Return angles (..., 2) [°] of vectors (..., 3) from straight down, towards x and y."""
    return np.degrees(np.arctan2(line[..., :2], -line[..., 2:]))


def _length(nodes: Array) -> Array:
    return np.linalg.norm(np.diff(nodes, axis=1), axis=2).sum(axis=1)


def _flat(nodes: Array | None) -> Array | None:
    return None if nodes is None else nodes.reshape(len(nodes), -1)


def _columns(values: Array | None, index: int) -> Array | None:
    return None if values is None else values[:, index]


def _half(measured: Array | None, part: int) -> Array | None:
    """Return the positions (0) or the rates (1) of measured states (K, 2 nq)."""
    return None if measured is None else np.hsplit(measured, 2)[part]


def _minus(left: Array | None, right: Array) -> Array | None:
    return None if left is None else left - right
