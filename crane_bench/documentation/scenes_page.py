"""The page of the scenes of cranes of ports and sites: description, picture and metrics of each."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from crane_bench.documentation.drawing import polygons
from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.files.output import write_text
from crane_sim.models.falls.crane import FallsCrane
from crane_sim.recording.base_frame import fall_ends
from crane_sim.report.plotting import BLUE, RED, save_figure
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.derived import world_points
from crane_sim.simulation.goals import express_in_base
from crane_sim.simulation.rollout import simulate

PORTS_AND_SITES = (
    *("tower_gust", "tower_flexible_jib", "tower_sway", "tower_beam_turns", "tower_set_down"),
    *("mobile_lift", "reeved_twelve_falls"),
    *("knuckle_hook_and_sling", "knuckle_ship_falls", "pendulum_lifeboat"),
    *("bridge_hook_and_sling", "bridge_pick_up", "tandem_play"),
    *("port_sts_container", "spreader_skew", "set_down_on_deck", "spreader_pick_up"),
)
"""The scenes of the page."""
_MARGIN = 0.03  # of the drawn box, on either side
_HEAD = """# Cranes as they stand in ports and on sites

Written by `crane describe --sites --save docs`: each crane where its run begins (pale) and ends, and the path of its
load (red, from the blue dot), in the axes of its base. Masses, lengths and speeds are those of real machines;
[machines.md](machines.md) has the equations, and the sources of the data.
"""  # noqa: E501
_METRICS = {
    "peak_swing_deg": ("largest swing", "°"),
    "residual_swing_deg": ("swing at the end", "°"),
    "max_rope_tension": ("largest tension", "N"),
    "peak_contact_force": ("largest contact force", "N"),
    "energy_audit_max": ("audit of the energy, relative", ""),
}


def save_page(folder: str | Path, names: Sequence[str] = ()) -> None:
    """Run the scenes with these names, all without any, and write page and pictures into a folder.

    Sections of the other scenes stay as the folder's page has them.

    Raises:
        SceneError: the page has no scene of such a name.
    """
    check_names(names)
    page = Path(folder, "scenes.md")
    sections = read_sections(page.read_text()) if page.is_file() else {}
    for name in names or PORTS_AND_SITES:
        print(name, flush=True)
        sections[name] = write_section(name, Path(folder))
    write_text(
        page, "\n".join([_HEAD, *(sections[name] for name in PORTS_AND_SITES if name in sections)])
    )


def check_names(names: Sequence[str]) -> None:
    """Raise SceneError where the page has no scene of one of these names."""
    for name in names:
        if name not in PORTS_AND_SITES:
            raise SceneError(unknown_key(name, PORTS_AND_SITES, "SCENE of the page"))


def read_sections(page: str) -> dict[str, str]:
    """Return the sections of a page by the name of their scene."""
    parts = page.split("\n## ")[1:]
    return {part.partition("\n")[0]: f"## {part.rstrip()}\n" for part in parts}


def write_section(name: str, folder: Path) -> str:
    """Run a scene, draw it into a file of the folder and return its section of the page."""
    scene = load_scene(name)
    run = simulate(scene)
    file = f"scene_{name}.png"
    drawn = save_figure(draw, (scene, run), folder / file, dpi=80)
    picture = f"![{name}]({file})\n\n" if drawn else ""
    return f"## {name}\n\n{scene.description.strip()}\n\n{picture}{format_metrics(run.summary)}\n"


def format_metrics(summary: Mapping[str, Any]) -> str:
    """Return the metrics of a run in one line."""
    parts = [f"{summary['sim_time']:g} s"]
    for key, (name, unit) in _METRICS.items():
        value = summary.get(key)
        if isinstance(value, int | float):
            parts.append(f"{name} {value:.3g} {unit}".rstrip())
    return " · ".join(parts)


def draw(figure: Any, data: Any) -> None:
    """Draw (scene, run) into a figure without axes."""
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    scene, run = data
    figure.set_size_inches(9.0, 6.0)
    axes = figure.add_subplot(projection="3d", computed_zorder=False)
    corners = list[np.ndarray]()
    for row, opacity in ((0, 0.25), (-1, 1.0)):
        faces = polygons(scene, run.q[row].tolist())
        colours = [(*face.colour[:3], opacity * face.colour[3]) for face in faces]
        shapes = [face.corners for face in faces]
        axes.add_collection3d(
            Poly3DCollection(shapes, facecolors=colours, edgecolors=(0, 0, 0, 0.15 * opacity))
        )
        corners += shapes
        for line in ropes(scene, float(run.t[row]), run.q[row], run.v[row]):
            axes.plot(*line.T, color="black", alpha=opacity, linewidth=1.0)
    trail = express_in_base(scene.model, run.t, run.payload)
    axes.plot(*trail.T, color=RED, linewidth=1.5)
    axes.scatter(*trail[[0]].T, color=BLUE, s=12)
    _frame(axes, np.concatenate([*corners, trail]))


def ropes(scene: Scene, t: float, q: np.ndarray, v: np.ndarray) -> list[np.ndarray]:
    """Return the ropes, each (n, 3) [m] in the axes of the base."""
    points, tip = world_points(scene.model._replace(base=None), t, q, v)
    if isinstance(scene.model, FallsCrane):
        values = {name: q[[i]] for i, name in enumerate(scene.joint_names)}
        tops, bottoms = fall_ends(scene.model.falls, values, points[[tip]])
        return [np.array(pair) for pair in zip(tops[0], bottoms[0], strict=True)]
    return [points[tip:]]


def _frame(axes: Any, points: np.ndarray) -> None:
    """Show all points (n, 3) in equal scales."""
    from matplotlib.ticker import MaxNLocator

    low, high = points.min(axis=0), points.max(axis=0)
    size = np.maximum(high - low, 0.15 * (high - low).max())
    middle = 0.5 * (low + high)
    for set_limits, centre, length in zip(
        (axes.set_xlim, axes.set_ylim, axes.set_zlim), middle, size, strict=True
    ):
        half = (0.5 + _MARGIN) * length
        set_limits(centre - half, centre + half)
    axes.set_box_aspect(size)
    axes.view_init(elev=18.0, azim=-62.0)
    for axis, name, length in zip((axes.xaxis, axes.yaxis, axes.zaxis), "xyz", size, strict=True):
        axis.set_label_text(f"{name} [m]")
        axis.set_major_locator(MaxNLocator(2 + int(5.0 * length / size.max())))
        axis.set_tick_params(labelsize=7)
        axis.pane.set_alpha(0.3)
