"""The command `crane identify`: parameters of a scene from a measured run."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click
import yaml
from rich.console import Console

from crane_sim.cli import report
from crane_sim.cli.package_groups import install_groups
from crane_sim.cli.run_options import ensure_writable_file
from crane_sim.cli.scene_options import as_json_option, load_scene_with_options
from crane_sim.cli.tables import print_line, print_table
from crane_sim.files.errors import SceneError
from crane_sim.files.installation import require
from crane_sim.files.output import write_text

if TYPE_CHECKING:
    from crane_sim.identification import Identification


@click.command("identify")
@click.argument("scene")
@click.argument("run", type=click.Path(path_type=Path))
@click.option(
    "--parameters", required=True, metavar="KEY,KEY", help="Numbers of the scene, by dotted keys."
)
@click.option(
    "--joints", metavar="NAME,NAME", help="Joints whose positions count (default: all measured)."
)
@click.option("--segment", type=float, help="Length of the parts of the run [s] (default: 5).")
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="GROUP.KEY=VALUE",
    help="Another first guess, or any value.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Folder (default: runs/identify-NAME of the run).",
)
@as_json_option
def identify_parameters(
    scene: str,
    run: Path,
    parameters: str,
    joints: str | None,
    segment: float | None,
    settings: tuple[str, ...],
    output: Path | None,
    as_json: bool,
) -> None:
    """Identify parameters of SCENE, the first guess, from a measured RUN: FILE.rrd or a ROS bag.

    The folder gets the scene with the estimates, all results, and a picture of fit against data.
    """
    from crane_sim.identification import identify

    loaded = load_scene_with_options(scene, settings=settings)
    if not run.exists():
        raise SceneError(f"RUN = {str(run)!r}: no such file")
    install_groups("plots")
    require("matplotlib", "the picture")
    folder = output or Path("runs") / f"identify-{run.stem}"
    ensure_writable_file("-o", (folder if folder.exists() else folder.parent) / "scene.yaml")
    options = {} if segment is None else {"segment": segment}
    with report.compiling(quiet=as_json):
        found = identify(loaded, run, _names(parameters), joints=_names(joints or ""), **options)
    files = _save(found, folder)
    if as_json:
        print(
            json.dumps(
                report.json_value(found.to_dict()) | {"files": [str(file) for file in files]}
            )
        )
    else:
        print_identification(found, Console())
        print(*files, sep="\n")


def _names(text: str) -> list[str]:
    return [name for name in map(str.strip, text.split(",")) if name]


def _save(found: Identification, folder: Path) -> list[Path]:
    """Write the scene with the estimates, results and picture into a folder; return the files."""
    from crane_sim.report.identification_figure import save_identification_figure

    scene, estimate, picture = (
        folder / name for name in ("scene.yaml", "estimate.json", "fit.png")
    )
    units = dict(zip(found.guess.joint_names, found.guess.joint_units, strict=True))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        write_text(scene, yaml.safe_dump(found.scene.to_dict(), sort_keys=False))
        write_text(estimate, json.dumps(report.json_value(found.to_dict()), indent=1) + "\n")
        save_identification_figure(found, units, picture)
    except OSError as error:
        raise SceneError(f"-o {folder}: cannot be written: {error.strerror or error}") from None
    return [scene, estimate, picture]


def print_identification(found: Identification, console: Console) -> None:
    """Print estimates and the scene's values, correlation, residuals of joints, and warnings."""
    head = ("parameter", "scene", "estimate", "from", "to", "deviation")
    rows = [
        (e.key, *(f"{x:.6g}" for x in (e.start, e.value, e.low, e.high)), f"{e.deviation:.2g}")
        for e in found.estimates
    ]
    print_table(console, "estimates, 95 % intervals", head, rows)
    if len(found.estimates) > 1:
        keys = [each.key for each in found.estimates]
        rows = [
            (key, *(f"{x:.2f}" for x in row))
            for key, row in zip(keys, found.correlation, strict=True)
        ]
        print_table(console, "", ("correlation", *keys), rows)
    residuals = ", ".join(f"{name} {rms:.3g}" for name, rms in found.residual.items())
    samples = f"{len(found.data.t)} samples in {len(found.segments)} segments"
    print_line(console, f"data less fit, rms [m, rad]: {residuals}; {samples}")
    for line in found.warnings:
        print_line(console, f"warning: {line}", "bold red")
