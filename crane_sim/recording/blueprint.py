"""How the viewer shows a recording when it is opened: the crane on the left, plots with units on the right."""

from __future__ import annotations

from math import cos, radians, sin

import rerun as rr
import rerun.blueprint as rrb

from crane_sim.recording.channels import pick
from crane_sim.recording.layout import Layout

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
    size = layout.size
    aside = layout.heading - radians(72.0)
    return rrb.Spatial3DView(
        name="Crane",
        origin="/",
        contents=["+ /**", "- /plots/**", "- /shown/**", "- /summary/**", "- /log/**"],
        background=rrb.Background(kind="SolidColor", color=(26, 30, 36)),
        line_grid=rrb.LineGrid3D(visible=False),
        spatial_information=rrb.SpatialInformation(target_frame="world", show_axes=False),
        eye_controls=rrb.EyeControls3D(
            kind=rrb.Eye3DKind.Orbital,
            position=(1.4 * size * cos(aside), 1.4 * size * sin(aside), 0.55 * size),
            look_target=(0.46 * size * cos(layout.heading), 0.46 * size * sin(layout.heading), -0.03 * size),
            eye_up=(0.0, 0.0, 1.0),
        ),
        defaults=[rr.Boxes3D.from_fields(fill_mode="solid"), rr.Cylinders3D.from_fields(fill_mode="solid")],
        overrides={"payload/trail": rrb.VisibleTimeRanges(_window())},
    )


def _window() -> rrb.VisibleTimeRange:
    return rrb.VisibleTimeRange(
        "sim_time",
        start=rrb.TimeRangeBoundary.cursor_relative(seconds=-TRAIL_SECONDS),
        end=rrb.TimeRangeBoundary.cursor_relative(),
    )


def _overview(layout: Layout) -> rrb.Container:
    angles = _plot("Joint angles [°]", "shown/angle_deg_target", "shown/angle_deg")
    torque = _plot("Joint torques [N m]", "shown/torque_Nm")
    swing = _plot("Payload swing [°]", "shown/swing_deg", "shown/swing_total_deg")
    tension = _plot("Rope tension [N]", "plots/tension")
    energy = _plot("Energy [J]", "plots/energy")
    if layout.lyapunov:
        energy = _plot("Lyapunov function V [J]", "plots/lyapunov")
    views = [angles, swing]
    if pick(layout, "m", actuated=True):
        views.append(_plot("Rope length [m]", "shown/length_m_target", "shown/length_m"))
    return rrb.Grid(*views, tension, torque, energy, grid_columns=2, name="Overview")


def _details(layout: Layout) -> rrb.Container:
    return rrb.Grid(
        _plot("Tracking error [rad, m]", "plots/q_err"),
        _plot("Joint rates [rad/s, m/s]", "plots/v"),
        _plot("Demanded effort [N m, N]", "plots/effort_demanded"),
        _plot("Payload position [m]", "plots/payload"),
        _plot("Energy [J]", "plots/energy"),
        _plot("dV/dt [W]", "plots/lyapunov_rate"),
        _plot("Real-time factor", "plots/rtf"),
        rrb.StateTimelineView(name="Mode", contents=["+ /plots/mode"]),
        grid_columns=2,
        name="Details",
    )


def _summary() -> rrb.TextDocumentView:
    return rrb.TextDocumentView(name="Summary", origin="summary/table")


def _plot(name: str, *entities: str) -> rrb.TimeSeriesView:
    return rrb.TimeSeriesView(
        name=name,
        contents=[f"+ /{entity}" for entity in entities],
        axis_x=rrb.TimeAxis(link=rrb.components.LinkAxis.LinkToGlobal),
        plot_legend=rrb.PlotLegend(corner=rrb.Corner2D.RightTop),
    )
