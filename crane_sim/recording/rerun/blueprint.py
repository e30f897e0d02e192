"""Blueprint of the viewer for a recording: the crane on the left, plots with units on the right."""

from __future__ import annotations

from typing import TYPE_CHECKING

import rerun as rr
import rerun.blueprint as rrb

from crane_sim.recording.layout import Layout, label
from crane_sim.recording.rerun.curves import angle_indices

if TYPE_CHECKING:
    from collections.abc import Iterable

TRAIL_SECONDS = 6.0


def blueprint(layout: Layout) -> rrb.Blueprint:
    """Lay out the views of a run."""
    return rrb.Blueprint(
        rrb.Horizontal(
            _crane(layout),
            rrb.Tabs(_overview(layout), _details(layout), _summary(), active_tab=0),
            column_shares=[5, 6],
        ),
        rrb.TimePanel(state="collapsed", timeline="sim_time", play_state="paused"),
        collapse_panels=True,
    )


def _crane(layout: Layout) -> rrb.Spatial3DView:
    return rrb.Spatial3DView(
        name="Crane",
        origin="/",
        contents=["+ /**", "- /plots/**", "- /shown/**", "- /frames/**", "- /summary/**", "- /log/**"],
        background=rrb.Background(kind="SolidColor", color=(26, 30, 36)),
        line_grid=rrb.LineGrid3D(visible=False),
        spatial_information=rrb.SpatialInformation(target_frame="world", show_axes=False),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=layout.framing.eye,
            look_target=layout.framing.look_at,
            eye_up=(0.0, 0.0, 1.0),
            tracking_entity=layout.framing.follows or None,
        ),
        defaults=[kind.from_fields(fill_mode="solid") for kind in (rr.Boxes3D, rr.Cylinders3D, rr.Ellipsoids3D)],
        overrides={"payload/trail": rrb.VisibleTimeRanges(_window())},
    )


def _window() -> rrb.VisibleTimeRange:
    return rrb.VisibleTimeRange(
        "sim_time",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-TRAIL_SECONDS),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )


def _overview(layout: Layout) -> rrb.Container:
    views = []
    if angle_indices(layout):
        views.append(_plot("Joint angles [°]", "shown/angle_deg_target", "shown/angle_deg"))
    views.append(_swing_view(layout))
    for way in layout.length_plots:
        views.append(_plot(way.title, f"{way.entity}_target", way.entity))
    if layout.suspension and layout.suspension.elastic:
        views.append(_plot("Length of the cable [m]", "shown/cable_m"))
    views.append(_plot(f"{label(layout.tension).capitalize()} [N]", "plots/tension"))
    if angle_indices(layout):
        views.append(_plot("Joint torques [N m]", "shown/torque_Nm"))
    elif layout.actuated and not layout.undriven:
        views.append(_plot("Drive forces [N]", "plots/effort"))
    if layout.lyapunov:
        views.append(_plot("Lyapunov function V [J]", "plots/lyapunov"))
    else:
        views.append(_energy_view(layout))
    if len(views) % 2:
        views.append(_payload(layout))
    return rrb.Grid(*views, grid_columns=2, name="Overview")


def _swing_view(layout: Layout) -> rrb.TimeSeriesView:
    if layout.suspension and layout.suspension.planar:
        return _plot("Swing [°]", "shown/swing_deg", "shown/swing_total_deg")
    return _plot("Payload swing [°]", "shown/swing_deg", "shown/lean_deg", "shown/swing_total_deg")


def _energy_view(layout: Layout) -> rrb.TimeSeriesView:
    parts = ("plots/energy_parts",) if layout.suspension else ()
    return _plot("Energy [J]", *parts, "plots/energy")


def _payload(layout: Layout) -> rrb.TimeSeriesView:
    planar = layout.suspension is not None and layout.suspension.planar
    return _plot("Payload position [m]", "shown/payload_m" if planar else "plots/payload")


def _details(layout: Layout) -> rrb.Container:
    views = []
    if layout.actuated and layout.has_targets:
        views.append(_plot(f"Tracking error [{_units(layout.units[i] for i in layout.driven)}]", "plots/q_err"))
    views.append(_plot("Joint rates [rad/s, m/s]", "shown/rate" if layout.has_hidden_coordinates else "plots/v"))
    if layout.actuated and layout.commanded:
        what = "Demanded effort" if layout.command_units == layout.effort_units else "Command"
        views.append(_plot(f"{what} [{_units(layout.command_units)}]", "plots/effort_demanded"))
    views += [_payload(layout), _energy_view(layout)]
    if layout.lyapunov:
        views.append(_plot("dV/dt [W]", "plots/lyapunov_rate"))
    views.append(_plot("Real-time factor", "plots/rtf"))
    views.append(rrb.StateTimelineView(name="Mode", contents=["+ /plots/mode"]))
    return rrb.Grid(*views, grid_columns=2, name="Details")


def _units(units: Iterable[str]) -> str:
    return ", ".join(dict.fromkeys(units))


def _summary() -> rrb.TextDocumentView:
    return rrb.TextDocumentView(name="Summary", origin="summary/table")


def _plot(name: str, *entities: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        name=name,
        contents=[f"+ /{entity}" for entity in entities],
        axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop),
    )
