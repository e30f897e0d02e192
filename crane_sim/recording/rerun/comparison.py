"""A comparison as a recording: the cranes in one scene, curves over one time, metrics."""

from __future__ import annotations

import re
import uuid
from typing import TYPE_CHECKING
from xml.etree import ElementTree

import numpy as np
import rerun as rr
import rerun.blueprint as rrb

from crane_sim.description.suspended import ATTITUDE_JOINT
from crane_sim.description.transforms import BASE, WORLD
from crane_sim.recording.base_frame import base_quaternions
from crane_sim.recording.camera import Framing, MotionRange
from crane_sim.recording.layout import Span
from crane_sim.recording.metric_units import markdown_table, metric_row
from crane_sim.recording.quantities import Quantity, moving_quantities
from crane_sim.recording.rerun.blueprint import arrange, crane_view, value_axis
from crane_sim.recording.rerun.cranes import CABLE_RADIUS_RATIO, joint_transforms, load_robot
from crane_sim.recording.rerun.curves import PALETTE
from crane_sim.recording.rerun.part_file import PartFile, RecordingError
from crane_sim.recording.rerun.scene3d import Vessel, log_ground
from crane_sim.recording.rerun.timelines import time_columns
from crane_sim.recording.rerun.writer import APPLICATION

if TYPE_CHECKING:
    from collections.abc import Sequence
    from pathlib import Path

    from crane_sim.recording.comparison import Comparison
    from crane_sim.recording.layout import Array
    from crane_sim.recording.rerun.curves import Color
    from crane_sim.recording.run import RecordedRun

    Curves = dict[Quantity, tuple[Array, ...]]


FIRST_TAB_PLOTS = 8
TITLE = "comparison"
COLORS = (PALETTE[1], PALETTE[0], *PALETTE[2:])
"""Run colours, chosen for contrast; the first is yellow like the crane."""


def record_comparison(comparison: Comparison, path: Path) -> Path:
    """Write all runs of a comparison into a recording; return its path.

    Raises:
        RecordingError: the file cannot be written.
    """
    runs = comparison.runs
    quantities = moving_quantities(runs)
    framing = framing_of(runs)
    rec = rr.RecordingStream(APPLICATION, recording_id=f"{TITLE}-{uuid.uuid4().hex[:12]}")
    rec.set_log_time_enabled(False)
    rec.set_log_tick_enabled(False)
    file = PartFile(path, rec)
    try:
        with file.on_disk():
            file.connect(_blueprint(framing, quantities, len(runs)))
            rec.send_recording_name(" and ".join(comparison.names))
            rec.send_property("run", rr.AnyValues(compared=list(comparison.names)))
            _log_surroundings(rec, runs[0], framing)
            _log_runs(rec, comparison)
            _log_curves(rec, comparison, quantities)
        return file.finish()
    except RecordingError:
        file.discard()
        raise


def framing_of(runs: Sequence[RecordedRun]) -> Framing:
    """Return how to look at the cranes of all runs."""
    framing = Framing(**runs[0].crane.framing)._replace(follows="")
    motion = MotionRange(framing)
    for run in runs:
        motion.add(run.frames.nodes)
    return motion.fit() or framing


def _log_surroundings(rec: rr.RecordingStream, run: RecordedRun, framing: Framing) -> None:
    """Log the ground, or for a crane on a moving base the hull and water at rest."""
    if run.base is None:
        log_ground(rec, framing)
    else:
        Vessel(rec, f"{_key(0)}/{BASE}", None).fit(framing)


def _blueprint(framing: Framing, quantities: Curves, runs: int) -> rrb.Blueprint:
    plots = [
        _plot(quantity, values, legend=i % FIRST_TAB_PLOTS == 0)
        for i, (quantity, values) in enumerate(quantities.items())
    ]
    trails = [f"{_key(i)}/path" for i in range(runs)]
    tabs: list[rrb.View | rrb.Container] = [
        rrb.Grid(*plots[:FIRST_TAB_PLOTS], grid_columns=2, name="Overview")
    ]
    if plots[FIRST_TAB_PLOTS:]:
        tabs.append(rrb.Grid(*plots[FIRST_TAB_PLOTS:], grid_columns=2, name="Details"))
    tabs.append(rrb.TextLogView(name="Events", origin="/log"))
    tabs.append(rrb.TextDocumentView(name="Summary", origin="summary/table"))
    return arrange(crane_view(framing, trails), *tabs)


def _plot(quantity: Quantity, values: tuple[Array, ...], legend: bool) -> rrb.TimeSeriesView:
    """Return the plot of a quantity.

    One legend on a tab suffices, since a run has the same colour in all plots.
    """
    finite = np.concatenate([each[np.isfinite(each)] for each in values])
    return rrb.TimeSeriesView(
        name=f"{quantity.title[0].upper()}{quantity.title[1:]} [{quantity.unit}]",
        contents=[f"+ /{_entity(quantity)}/**"],
        axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        axis_y=value_axis([Span(finite.min(), finite.max())] if finite.size else []),
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop, visible=legend),
    )


def _log_runs(rec: rr.RecordingStream, comparison: Comparison) -> None:
    """Log cranes, events and metrics."""
    for i, (run, name) in enumerate(zip(comparison.runs, comparison.names, strict=True)):
        draw_run(rec, run, _key(i), COLORS[i % len(COLORS)], ghost=i > 0)
        for t, what in run.events:
            rec.set_time("sim_time", duration=t)
            rec.log(f"log/{_key(i)}", rr.TextLog(f"{name}: {what}", level="INFO"))
    rec.log(
        "summary/table",
        rr.TextDocument(_metrics_markdown(comparison), media_type=rr.MediaType.MARKDOWN),
        static=True,
    )


def _log_curves(rec: rr.RecordingStream, comparison: Comparison, quantities: Curves) -> None:
    for i, (run, name) in enumerate(zip(comparison.runs, comparison.names, strict=True)):
        style = rr.SeriesLines(names=name, colors=COLORS[i % len(COLORS)], widths=1.6)
        time = time_columns(run.t)
        for quantity, values in quantities.items():
            entity = f"{_entity(quantity)}/{_key(i)}"
            rec.log(entity, style, static=True)
            rec.send_columns(entity, time, rr.Scalars.columns(scalars=values[i]))


def _metrics_markdown(comparison: Comparison) -> str:
    """Return all runs' metrics as a markdown document, with differences from the first."""
    names = comparison.names
    header = ["metric", *names, *(f"{name} − {names[0]}" for name in names[1:])]
    rows = []
    for key, values in comparison.metrics.items():
        label, unit, texts = metric_row(key, comparison.runs, values)
        rows.append([f"{label} [{unit}]" if unit else label, *(text or "–" for text in texts)])
    return f"# {' and '.join(names)}\n\n{markdown_table(header, rows)}\n"


def _key(i: int) -> str:
    """Return the prefix of the entities and frames of run i."""
    return f"run_{i + 1}"


def _entity(quantity: Quantity) -> str:
    """Return the entity below which the curves of a quantity are."""
    return f"curves/{re.sub(r'[^0-9a-z]+', '_', quantity.title.lower())}"


GHOST_OPACITY = 0.45


def draw_run(
    rec: rr.RecordingStream, run: RecordedRun, key: str, color: Color, ghost: bool
) -> None:
    """Draw a run's crane with its ropes, and its payload's path in a colour.

    A ghost is all in this colour.

    All entities, and the names of all coordinate frames, begin with `key`.
    """
    tree = load_robot(_colored(run.urdf, color) if ghost else run.urdf, f"{key}/crane", f"{key}/")
    root, joints = f"{key}/{tree.root_link().name}", tree.joints()
    rec.send_chunks(tree.stream(include_joint_transforms=False))
    for joint in joints:
        if joint.joint_type == "fixed" and joint.name != ATTITUDE_JOINT:
            rec.log(f"{key}/tf/{joint.name}", joint.compute_transform(0.0), static=True)
    steps = run.frame_steps
    time = time_columns(run.frames.t)
    values = dict(zip(run.crane.joint_names, run.q[steps].T, strict=True))
    for name, columns in joint_transforms(joints, values):
        rec.send_columns(f"{key}/tf/{name}", time, columns)
    _place(rec, f"{key}/tf/stand", root, time, None if run.base is None else run.base[steps])
    _draw_ropes(rec, run, key, root, color)
    _draw_path(rec, run, key, color)


def _colored(urdf: str, color: Color) -> str:
    """Return a URDF with all its solids in a colour, translucent."""
    robot = ElementTree.fromstring(urdf)
    rgb = " ".join(f"{component / 255:.3f}" for component in color)
    for each in robot.iter("color"):
        each.set("rgba", f"{rgb} {GHOST_OPACITY}")
    return ElementTree.tostring(robot, encoding="unicode")


def _place(
    rec: rr.RecordingStream, entity: str, root: str, time: list[rr.TimeColumn], base: Array | None
) -> None:
    """Place a crane's root in the world: at rest, or with its base (F, 6), [m] and [rad]."""
    if base is None:
        rec.log(entity, rr.Transform3D(parent_frame=WORLD, child_frame=root), static=True)
        return
    columns = rr.Transform3D.columns(
        translation=base[:, :3],
        quaternion=base_quaternions(base),
        parent_frame=[WORLD] * len(base),
        child_frame=[root] * len(base),
    )
    rec.send_columns(entity, time, columns)


def _draw_ropes(
    rec: rr.RecordingStream, run: RecordedRun, key: str, root: str, color: Color
) -> None:
    """Draw the cable from tip to payload in the world, or the falls in the base's frame."""
    frames, radius = run.frames, CABLE_RADIUS_RATIO * run.crane.framing["size"]
    strips = frames.nodes[:, None, run.crane.tip_index :] if frames.falls is None else frames.falls
    count, ropes = strips.shape[:2]
    style = rr.LineStrips3D.from_fields(colors=color, radii=radius)
    rec.log(
        f"{key}/rope",
        rr.CoordinateFrame(WORLD if frames.falls is None else root),
        style,
        static=True,
    )
    columns = rr.LineStrips3D.columns(
        strips=strips.reshape(-1, *strips.shape[2:]).astype(np.float32)
    )
    rec.send_columns(f"{key}/rope", time_columns(frames.t), columns.partition([ropes] * count))


def _draw_path(rec: rr.RecordingStream, run: RecordedRun, key: str, color: Color) -> None:
    """Draw the payload's path: each frame has the line from the position before."""
    payload = run.frames.nodes[:, -1]
    lines = np.stack([np.vstack([payload[:1], payload[:-1]]), payload], axis=1).astype(np.float32)
    style = rr.LineStrips3D.from_fields(colors=color, radii=0.003 * run.crane.framing["size"])
    rec.log(f"{key}/path", rr.CoordinateFrame(WORLD), style, static=True)
    rec.send_columns(
        f"{key}/path", time_columns(run.frames.t), rr.LineStrips3D.columns(strips=lines)
    )
