"""What the page of a run holds, as plain data: the crane, its frames, curves, metrics, and where they come from."""

from __future__ import annotations

from hashlib import sha256
from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.evaluation.report.decimation import encode_columns, encode_floats, rows_with_peaks
from crane_sim.evaluation.report.metrics_table import headlines, joint_table, plain_metrics
from crane_sim.evaluation.report.panels import Panel, panels_of
from crane_sim.evaluation.report.robot import parse_robot, used_coordinates
from crane_sim.recording.base_frame import base_rotations
from crane_sim.recording.rope_colors import usual_tensions
from crane_sim.recording.states import get_color, make_spans

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from crane_sim.recording.layout import Numbers
    from crane_sim.recording.run import RecordedRun

FRAME_NUMBERS = 140_000  # in all frames of a page: 0.75 MB
CURVE_NUMBERS = 40_000  # points of all curves of a page: 0.45 MB
POINTS = 1000  # of one curve at most, more than a screen has columns for it
LAST = 5.0  # s before a failure, which are shown first
DENSE = 10.0  # s at the end of a long run that keep all their frames
EVENTS = 200  # that are listed
FIRST = 2000  # rows in which a tension is looked for to which others are compared, as in the viewer
LOADED = 2.0  # share of it above which a colour does not change any more
MAX_SPANS = 1000  # of a timeline of states


def page_data(run: RecordedRun, frame_numbers: int = FRAME_NUMBERS) -> dict[str, Any]:
    """Return all that the page of a run shows, with at most so many numbers in its frames."""
    robot = parse_robot(run.urdf, run.crane.joint_names)
    end = float(run.t[-1]) + run.period
    panels = panels_of(run)
    return {
        "name": run.name,
        "description": run.scene_values.get("description", ""),
        "law": run.law,
        "kind": run.crane.kind,
        "finished": run.finished,
        "error": run.error,
        "end": end,
        "last": None if run.finished else max(0.0, end - LAST),
        "robot": robot,
        "framing": run.crane.framing,
        "afloat": run.base is not None,
        "frames": frames_of(run, used_coordinates(robot), frame_numbers),
        "panels": _encode(run, panels, slice(None)),
        "last_panels": None if run.finished else _encode(run, panels, _last(run, end)),
        "states": state_rows(run, end),
        "events": run.events[:EVENTS],
        "event_count": max(len(run.events), run.summary.get("event_count", 0)),
        "headlines": headlines(run),
        "scene": run.scene_text,
    } | _tables(run)


def state_rows(run: RecordedRun, end: float) -> list[dict[str, Any]]:
    """Return the timelines of states up to a time [s]: name and spans, [begin, end, state, colour]."""
    spans = {name: make_spans(changes, 0.0, end, end / MAX_SPANS) for name, changes in run.states.items()}
    return [
        {"name": name, "spans": [[*span, get_color(span.state)] for span in each[:MAX_SPANS]]}
        for name, each in spans.items()
    ]


def _tables(run: RecordedRun) -> dict[str, Any]:
    return {"metrics": plain_metrics(run.summary), "joints": joint_table(run), "origin": _origin(run)}


def _last(run: RecordedRun, end: float) -> slice:
    return slice(int(np.searchsorted(run.t, end - LAST)), None)


def _encode(run: RecordedRun, panels: list[Panel], rows: slice) -> list[dict[str, Any]]:
    """Return panels with the curves of some rows."""
    curves = max(1, sum(len(panel.curves) for panel in panels))
    points = min(POINTS, CURVE_NUMBERS // curves)
    return [
        {
            "title": panel.title,
            "unit": panel.unit,
            "curves": [
                {"name": curve.name, "color": curve.color, "dashed": curve.dashed, "dotted": curve.dotted}
                | curve_points(run.t[rows], curve.values[rows], points)
                for curve in panel.curves
            ],
        }
        for panel in panels
    ]


def curve_points(t: Numbers, values: Numbers, count: int) -> dict[str, str]:
    """Return a curve over the times t (K,), thinned out to about `count` points."""
    rows = rows_with_peaks(values, count)
    return {"t": encode_floats(t[rows]), "values": encode_floats(values[rows])}


def frames_of(run: RecordedRun, moving: list[int], numbers: int = FRAME_NUMBERS) -> dict[str, Any]:
    """Return the frames of the 3D scene, as columns, and which columns are what: [first, count]."""
    frames, tip = run.frames, run.crane.tip_index
    at = run.frame_steps
    parts = {"t": frames.t[:, None], "q": run.q[at][:, moving], "nodes": _flat(frames.nodes[:, tip:])}
    parts["tension"] = rope_loads(run)[at]
    if run.base is not None:
        base = run.base[at]
        parts["base"] = np.hstack([base[:, :3], base_rotations(base).as_quat()])
    if frames.target is not None:
        parts["target"] = frames.target
    if frames.falls is not None:
        parts["falls"] = _flat(frames.falls)
    widths = [part.shape[1] for part in parts.values()]
    firsts = np.cumsum([0, *widths]).tolist()
    columns = np.hstack(list(parts.values()))
    named = {name: [first, width] for name, first, width in zip(parts, firsts, widths, strict=False)}
    kept = _kept_frames(frames.t, columns, numbers)
    return encode_columns(columns[kept]) | {"columns": named, "moving": moving}


def rope_loads(run: RecordedRun) -> Numbers:
    """Return the tensions (K, L) as shares of those that the colours of ropes compare them to, at most `LOADED`."""
    return np.minimum(run.tensions / usual_tensions(run.tensions[:FIRST]), LOADED)


def _kept_frames(t: Numbers, columns: Numbers, numbers: int) -> NDArray[np.bool_]:
    """Return which frames (F,) stay: of a long run every n-th, but all at its end."""
    varying = max(1, int(np.count_nonzero(np.ptp(columns, axis=0) > 0.0)))
    stride = max(1, -(-len(t) * varying // numbers))
    dense = t > t[-1] - DENSE
    if np.count_nonzero(dense) * varying > numbers // 4:
        dense = t == t[-1]
    return (np.arange(len(t)) % stride == 0) | dense


def _flat(values: Numbers) -> Numbers:
    return values.reshape(len(values), -1)


def _origin(run: RecordedRun) -> list[tuple[str, str]]:
    """Return versions and hashes: what it takes to get the same run again."""
    rows = [(name.replace("_", " "), value) for name, value in run.versions.items()]
    state = run.summary.get("state_sha256")
    rows += [("scene sha256", sha256(run.scene_text.encode()).hexdigest())]
    rows += [("state sha256", state)] if state else []
    return [*rows, ("seed", str(run.seed)), ("control period", f"{run.period:g} s")]
