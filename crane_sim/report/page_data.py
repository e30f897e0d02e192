"""The content of a run's page as plain data: crane, frames, curves, metrics, versions, hashes."""

from __future__ import annotations

from hashlib import sha256
from typing import TYPE_CHECKING, Any
from xml.etree import ElementTree

import numpy as np

from crane_sim.description.suspended import ATTITUDE_JOINT
from crane_sim.recording.base_frame import base_quaternions
from crane_sim.recording.layout import label
from crane_sim.recording.metric_units import metric_label, plain_unit
from crane_sim.recording.rope_colors import usual_tensions
from crane_sim.recording.states import get_color, make_spans
from crane_sim.report.decimation import encode_columns, encode_floats, rows_with_peaks
from crane_sim.report.panels import PREFIXES, UNITS_WITH_PREFIX, Panel, panels_of
from crane_sim.scenes.schema.rigging import ATTITUDE

if TYPE_CHECKING:
    from collections.abc import Sequence

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Array
    from crane_sim.recording.run import RecordedRun


MAX_FRAME_VALUES = 140_000  # of all frames of a page: 0.75 MB
MAX_TOTAL_POINTS = 40_000  # of all curves of a page: 0.45 MB
MAX_CURVE_POINTS = 1000  # more than the columns of a screen for one curve
FAILURE_INTERVAL = 5.0  # s before a failure, which are shown first
DENSE_INTERVAL = 10.0  # s at the end of a long run for which all frames are kept
MAX_EVENTS = 200
USUAL_ROWS = 2000  # first rows, from which the usual tensions follow, as in the viewer
MAX_LOAD_RATIO = 2.0  # of tension to usual tension: above it the colour stays the same
MAX_SPANS = 1000  # of a timeline of states


def page_data(run: RecordedRun, max_frame_values: int = MAX_FRAME_VALUES) -> dict[str, Any]:
    """Return a run's page content, with at most `max_frame_values` values in its frames.

    The failure window: the last FAILURE_INTERVAL seconds of a run that failed. `headed_table` has
    rows below a row of column names, `plain_table` rows of a name and its values.
    """
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
        "real_time_violation": run.real_time_violation,
        "end": end,
        "failure_window_start": None if run.finished else max(0.0, end - FAILURE_INTERVAL),
        "robot": robot,
        "framing": run.crane.framing,
        "afloat": run.base is not None,
        "frames": frames_of(run, used_coordinates(robot), max_frame_values),
        "panels": _encode(run, panels, slice(None)),
        "failure_window_panels": _encode_failure(run, panels, end),
        "states": state_rows(run, end),
        "events": run.events[:MAX_EVENTS],
        "event_count": max(len(run.events), run.summary.get("event_count", 0)),
        "headlines": headlines(run),
        "scene": run.scene_text,
    } | _tables(run)


def _encode_failure(run: RecordedRun, panels: list[Panel], end: float) -> Any:
    """Return the panels of a run's failure window, None of a run that finished."""
    if run.finished:
        return None
    return _encode(run, panels, _rows_before_failure(run, end))


def state_rows(run: RecordedRun, end: float) -> list[dict[str, Any]]:
    """Return state timelines up to a time [s]: name and spans, [begin, end, state, colour]."""
    spans = {
        name: make_spans(changes, 0.0, end, end / MAX_SPANS) for name, changes in run.states.items()
    }
    return [
        {"name": name, "spans": [[*span, get_color(span.state)] for span in each[:MAX_SPANS]]}
        for name, each in spans.items()
    ]


def _tables(run: RecordedRun) -> dict[str, Any]:
    return {
        "headed_table": joint_table(run),
        "plain_table": plain_metrics(run),
        "origin": _origin(run),
    }


def _rows_before_failure(run: RecordedRun, end: float) -> slice:
    return slice(int(np.searchsorted(run.t, end - FAILURE_INTERVAL)), None)


def _encode(run: RecordedRun, panels: list[Panel], rows: slice) -> list[dict[str, Any]]:
    """Return panels with the curves of some rows."""
    curves = max(1, sum(len(panel.curves) for panel in panels))
    points = min(MAX_CURVE_POINTS, MAX_TOTAL_POINTS // curves)
    return [
        {
            "title": panel.title,
            "unit": panel.unit,
            "curves": [
                {
                    "name": curve.name,
                    "color": curve.color,
                    "dashed": curve.dashed,
                    "dotted": curve.dotted,
                }
                | curve_points(run.t[rows], curve.values[rows], points)
                for curve in panel.curves
            ],
        }
        for panel in panels
    ]


def curve_points(t: Array, values: Array, count: int) -> dict[str, str]:
    """Return a curve over the times t (K,), thinned out to about `count` points."""
    rows = rows_with_peaks(values, count)
    return {"t": encode_floats(t[rows]), "values": encode_floats(values[rows])}


def frames_of(
    run: RecordedRun, moving: list[int], max_values: int = MAX_FRAME_VALUES
) -> dict[str, Any]:
    """Return the 3D scene's frames as columns, and each quantity's columns: [first, count]."""
    frames, tip = run.frames, run.crane.tip_index
    steps = run.frame_steps
    parts = {
        "t": frames.t[:, None],
        "q": run.q[steps][:, moving],
        "nodes": _flat(frames.nodes[:, tip:]),
    }
    parts["tension"] = rope_loads(run)[steps]
    if run.base is not None:
        base = run.base[steps]
        parts["base"] = np.hstack([base[:, :3], base_quaternions(base)])
    if frames.target is not None and np.isfinite(frames.target).all():
        # it may begin in the middle of a run
        parts["target"] = frames.target
    if frames.falls is not None:
        parts["falls"] = _flat(frames.falls)
    widths = [part.shape[1] for part in parts.values()]
    firsts = np.cumsum([0, *widths]).tolist()
    columns = np.hstack(list(parts.values()))
    named = {
        name: [first, width] for name, first, width in zip(parts, firsts, widths, strict=False)
    }
    kept = _select_frames(frames.t, columns, max_values)
    return encode_columns(columns[kept]) | {"columns": named, "moving": moving}


def rope_loads(run: RecordedRun) -> Array:
    """Return ratios (K, L) of tensions to usual ones, up to `MAX_LOAD_RATIO`, for rope colours."""
    return np.minimum(run.tensions / usual_tensions(run.tensions[:USUAL_ROWS]), MAX_LOAD_RATIO)


def _select_frames(t: Array, columns: Array, max_values: int) -> NDArray[np.bool_]:
    """Return a mask (F,) of the kept frames: of a long run every n-th, but all at its end."""
    varying = max(1, int(np.count_nonzero(np.ptp(columns, axis=0) > 0.0)))
    stride = max(1, -(-len(t) * varying // max_values))
    dense = t > t[-1] - DENSE_INTERVAL
    if np.count_nonzero(dense) * varying > max_values // 4:
        dense = t == t[-1]
    return (np.arange(len(t)) % stride == 0) | dense


def _flat(values: Array) -> Array:
    return values.reshape(len(values), -1)


def _origin(run: RecordedRun) -> list[tuple[str, str]]:
    """Return (name, value) of the versions and hashes that are needed to repeat the run."""
    rows = [(name.replace("_", " "), value) for name, value in run.versions.items()]
    state = run.summary.get("state_sha256")
    rows += [("scene sha256", sha256(run.scene_text.encode()).hexdigest())]
    rows += [("state sha256", state)] if state else []
    return [*rows, ("seed", str(run.seed)), ("control period", f"{run.period:g} s")]


def parse_robot(urdf: str, coordinates: Sequence[str]) -> dict[str, Any]:
    """Return the links of a URDF with their solids, and its joints with their coordinates.

    A joint that moves has `source`, the index of its coordinate, and `multiplier` and `offset` of
    its position. A fixed joint has none of these, except for the one of a body's attitude, which
    URDF has no type for: its `source` is the indices of the components w, x, y, z of a quaternion.

    Args:
        urdf: the document's text.
        coordinates: names of the joint coordinates (nq,).
    """
    robot = ElementTree.fromstring(urdf)
    links = {
        link.attrib["name"]: [_solid(visual) for visual in link.iter("visual")]
        for link in robot.iter("link")
    }
    return {
        "links": links,
        "joints": [_joint_record(joint, list(coordinates)) for joint in robot.findall("joint")],
    }


def used_coordinates(robot: dict[str, Any]) -> list[int]:
    """Return the indices of the coordinates that move a joint, in ascending order."""
    used = [joint["source"] for joint in robot["joints"] if "source" in joint]
    return sorted(
        {i for source in used for i in (source if isinstance(source, list) else [source])}
    )


def _joint_record(joint: ElementTree.Element, coordinates: list[str]) -> dict[str, Any]:
    name, mimic = joint.attrib["name"], joint.find("mimic")
    description: dict[str, Any] = {
        "name": name,
        "parent": _child(joint, "parent").attrib["link"],
        "child": _child(joint, "child").attrib["link"],
        "at": _floats_of(_child(joint, "origin"), "xyz"),
        "rpy": _floats_of(_child(joint, "origin"), "rpy"),
    }
    if joint.attrib["type"] == "fixed":
        quaternion = [coordinates.index(part) for part in ATTITUDE if part in coordinates]
        return description | (
            {"source": quaternion} if name == ATTITUDE_JOINT and quaternion else {}
        )
    return description | {
        "source": coordinates.index(name if mimic is None else mimic.attrib["joint"]),
        "multiplier": 1.0 if mimic is None else float(mimic.attrib.get("multiplier", "1")),
        "offset": 0.0 if mimic is None else float(mimic.attrib.get("offset", "0")),
        "prismatic": joint.attrib["type"] == "prismatic",
        "axis": _floats_of(_child(joint, "axis"), "xyz"),
    }


def _solid(visual: ElementTree.Element) -> dict[str, Any]:
    shape = _child(visual, "geometry")[0]
    names = {"box": ("size",), "cylinder": ("radius", "length"), "sphere": ("radius",)}[shape.tag]
    return {
        "size": [number for name in names for number in _floats_of(shape, name)],
        "at": _floats_of(_child(visual, "origin"), "xyz"),
        "rpy": _floats_of(_child(visual, "origin"), "rpy"),
        "color": _floats_of(_child(_child(visual, "material"), "color"), "rgba"),
    }


def _child(element: ElementTree.Element, name: str) -> ElementTree.Element:
    child = element.find(name)
    assert child is not None, f"{element.tag} without {name}"
    return child


def _floats_of(element: ElementTree.Element, name: str) -> list[float]:
    return [float(number) for number in element.attrib[name].split()]


HEADLINES = {
    "sim_time": "simulated",
    "peak_swing_deg": "peak swing",
    "residual_swing_deg": "swing left at the end",
    "max_rope_tension": "largest tension",
    "min_rope_tension": "smallest tension",
    "saturated_steps": "saturated periods",
}
HIDDEN = tuple(
    "scene law mode seed error real_time_violation state_sha256 recording mcap event_count".split()
)
JOINTS = {
    "final_error": "final error",
    "settling_time": "joint settled after",
    "peak_effort": "peak effort",
}


def headlines(run: RecordedRun) -> list[tuple[str, str]]:
    """Return (name, value with its unit) of the metrics that are read first."""
    known = {key: run.summary[key] for key in HEADLINES if run.summary.get(key) is not None}
    return [(HEADLINES[key], _format(value, _unit(key, run))) for key, value in known.items()]


def plain_metrics(run: RecordedRun) -> list[tuple[str, str]]:
    """Return (name, value with its unit) of all single metrics of a run's summary."""
    single = {
        key: value
        for key, value in run.summary.items()
        if isinstance(value, str | int | float) or value is None
    }
    return [
        (metric_label(key), _format(value, _unit(key, run)))
        for key, value in single.items()
        if key not in HIDDEN
    ]


def joint_table(run: RecordedRun) -> list[list[str]]:
    """Return rows of actuated joints below column names; empty where there is nothing to say."""
    crane, summary = run.crane, run.summary
    units = dict(zip(crane.joint_names, crane.joint_units, strict=True))
    efforts = dict(zip(crane.actuated, crane.effort_units, strict=True))
    kinds = [key for key in JOINTS if summary.get(key)]
    unit_of = {
        "final_error": units,
        "settling_time": dict.fromkeys(crane.actuated, "s"),
        "peak_effort": efforts,
    }
    rows = [
        [label(name), *(_format(summary[key].get(name), unit_of[key][name]) for key in kinds)]
        for name in crane.actuated
    ]
    return [["joint", *(JOINTS[key] for key in kinds)], *rows] if kinds else []


def _unit(key: str, run: RecordedRun) -> str:
    return plain_unit(key, run.path_unit).replace("deg", "°")


def _format(value: Any, unit: str) -> str:
    if value is None:
        return "–"
    if not isinstance(value, float):
        return f"{value} {unit}".strip()
    prefixes = PREFIXES if unit in UNITS_WITH_PREFIX else ()
    factor, prefix = next(((f, p) for f, least, p in prefixes if abs(value) >= least), (1.0, ""))
    return f"{value / factor:.4g} {prefix}{unit}".strip()
