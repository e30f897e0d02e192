"""Blueprint of the viewer for a recording: the crane on the left, plots with units on the right."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import ceil, floor, log10

import rerun as rr
import rerun.blueprint as rrb

from crane_sim.recording.camera import Framing
from crane_sim.recording.layout import Layout, Span, label
from crane_sim.recording.quantities import LYAPUNOV, PAYLOAD, POSITIONS, REEVED, SWING
from crane_sim.recording.rerun.curves import (
    UnitPlot,
    angle_indices,
    commands,
    efforts,
    errors,
    rates,
)

TRAIL_SECONDS = 6.0


TRAIL_WINDOW = rrb.VisibleTimeRanges(
    rrb.VisibleTimeRange(
        "sim_time",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-TRAIL_SECONDS),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )
)
"""How much of a path is shown: the last seconds before the instant that is looked at."""


def blueprint(layout: Layout, live: bool = False) -> rrb.Blueprint:
    """Lay out the views of a run; the time of one that is watched live follows the run."""
    view = crane_view(layout.framing, ("payload/trail",))
    return arrange(view, _overview(layout), _details(layout), _states(), _summary_view(), live=live)


def arrange(crane: rrb.View, *tabs: rrb.View | rrb.Container, live: bool = False) -> rrb.Blueprint:
    """Return the blueprint, crane left, tabs right, which starts at the beginning.

    A live one follows the end.
    """
    play_state = "following" if live else "paused"
    return rrb.Blueprint(
        rrb.Horizontal(crane, rrb.Tabs(*tabs, active_tab=0), column_shares=[5, 6]),
        rrb.TimePanel(state="collapsed", timeline="sim_time", play_state=play_state),
        collapse_panels=True,
    )


def crane_view(framing: Framing, trails: Sequence[str]) -> rrb.Spatial3DView:
    """Return the view of the 3D scene; `trails` are paths shown over the last seconds."""
    hidden = ("plots", "shown", "curves", "frames", "states", "summary", "log")
    return rrb.Spatial3DView(
        name="Crane",
        origin="/",
        contents=["+ /**", *(f"- /{name}/**" for name in hidden)],
        background=rrb.Background(kind="SolidColor", color=(26, 30, 36)),
        line_grid=rrb.LineGrid3D(visible=False),
        spatial_information=rrb.SpatialInformation(target_frame="world", show_axes=False),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=framing.eye,
            look_target=framing.look_at,
            eye_up=(0.0, 0.0, 1.0),
            tracking_entity=framing.follows or None,
        ),
        defaults=[
            kind.from_fields(fill_mode="solid")
            for kind in (rr.Boxes3D, rr.Cylinders3D, rr.Ellipsoids3D)
        ],
        overrides=dict.fromkeys(trails, TRAIL_WINDOW),
    )


def _overview(layout: Layout) -> rrb.Container:
    views = []
    if angle_indices(layout):
        views.append(_plot_with_targets(layout, f"{POSITIONS['rad']} [°]", "shown/angle_deg"))
    views.append(_swing_view(layout))
    for way in layout.length_plots:
        views.append(_plot_with_targets(layout, way.title, way.entity))
    if layout.suspension and layout.suspension.elastic:
        views.append(_plot(layout, "Length of the cable [m]", "shown/cable_m"))
    views.append(_plot(layout, f"{label(layout.tension).capitalize()} [N]", "plots/tension"))
    if layout.ropes.reeved:
        views.append(_plot(layout, f"{REEVED} [N]", "plots/reeved_tension"))
    if layout.actuated and not layout.undriven:
        views.append(_unit_views(layout, efforts(layout))[0])
    if layout.lyapunov:
        views.append(_plot(layout, f"{LYAPUNOV} [J]", "plots/lyapunov"))
    else:
        views.append(_energy_view(layout))
    if len(views) % 2:
        views.append(_payload(layout))
    return rrb.Grid(*views, grid_columns=2, name="Overview")


def _swing_view(layout: Layout) -> rrb.TimeSeriesView:
    if layout.suspension and layout.suspension.planar:
        return _plot(
            layout,
            f"{SWING} [°]",
            "shown/swing_deg",
            "shown/swing_total_deg",
            "shown/swing_deg_measured",
        )
    entities = ("swing_deg", "lean_deg", "swing_total_deg", "swing_deg_measured")
    return _plot(layout, "Payload swing [°]", *(f"shown/{name}" for name in entities))


def _energy_view(layout: Layout) -> rrb.TimeSeriesView:
    return _plot(layout, "Energy since the start [J]", "shown/energy_J")


def _payload(layout: Layout) -> rrb.TimeSeriesView:
    planar = layout.suspension is not None and layout.suspension.planar
    return _plot(layout, f"{PAYLOAD} [m]", "shown/payload_m" if planar else "plots/payload")


def _details(layout: Layout) -> rrb.Container:
    views: list[rrb.View] = []
    if layout.actuated and layout.has_targets:
        views += _unit_views(layout, errors(layout))
    views += _unit_views(layout, rates(layout))
    if layout.actuated and not layout.undriven:
        views += _unit_views(layout, efforts(layout))[1:]
    if layout.actuated and layout.commanded:
        views += _unit_views(layout, commands(layout))
    views += [_payload(layout), _energy_view(layout)]
    if layout.lyapunov:
        views.append(_plot(layout, "dV/dt [W]", "plots/lyapunov_rate"))
    if layout.paced:
        views.append(_plot(layout, "Real-time factor", "plots/rtf"))
    return rrb.Grid(*views, grid_columns=2 if len(views) <= 8 else 3, name="Details")


def _states() -> rrb.Container:
    """Return the timelines of all states, above what was noted and what happened."""
    states = rrb.StateTimelineView(name="States", origin="/states")
    return rrb.Vertical(
        states, rrb.TextLogView(name="Events", origin="/log"), row_shares=[3, 2], name="States"
    )


def _unit_views(layout: Layout, plots: Iterable[UnitPlot]) -> list[rrb.TimeSeriesView]:
    return [_plot(layout, plot.title, plot.entity, f"{plot.entity}_measured") for plot in plots]


def _summary_view() -> rrb.TextDocumentView:
    return rrb.TextDocumentView(name="Summary", origin="summary/table")


def _plot_with_targets(layout: Layout, name: str, entity: str) -> rrb.TimeSeriesView:
    return _plot(layout, name, f"{entity}_target", entity, f"{entity}_measured")


def _plot(layout: Layout, name: str, *entities: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        name=name,
        contents=[f"+ /{entity}" for entity in entities],
        axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        axis_y=value_axis([layout.spans[entity] for entity in entities if entity in layout.spans]),
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop),
    )


def value_axis(spans: Sequence[Span]) -> rrb.ScalarAxis | None:
    """Return the range of an axis where the viewer's own has less than two labels, else None.

    It labels powers of ten, and where these are dense enough tenths of them.
    """
    if not spans:
        return None
    low, high = min(span.low for span in spans), max(span.high for span in spans)
    if not low < high:
        return None
    step = 10.0 ** floor(log10(high - low))
    first, last = ceil(low / step), floor(high / step)
    if last > first:
        return None
    margin = 0.05 * step
    wide = (first - 1, first + 1) if first == last else (last, first)
    return rrb.ScalarAxis(
        range=(min(low, wide[0] * step) - margin, max(high, wide[1] * step) + margin)
    )
