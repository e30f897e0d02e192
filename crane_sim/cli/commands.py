"""The subcommands of `crane`."""

import json
import os
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import yaml

from crane_sim import process_signals
from crane_sim.cli import report
from crane_sim.cli.compare import compare_runs
from crane_sim.cli.doctor import doctor
from crane_sim.cli.help_lines import HELP, Application
from crane_sim.cli.identify import identify_parameters
from crane_sim.cli.interfaces import interfaces
from crane_sim.cli.package_groups import GROUPS, install_groups, install_packages
from crane_sim.cli.run_options import RunOptions, check_recording, run_options
from crane_sim.cli.scene_options import (
    as_json_option,
    change_options,
    compile_scene,
    load_scene_with_options,
    scene_options,
)
from crane_sim.cli.sweep import sweep
from crane_sim.cli.tune import tune
from crane_sim.cli.viewing import check_output, clip, find_recording, replay, shot, view
from crane_sim.files.catalogue import config_folder, scene_files
from crane_sim.files.errors import SceneError
from crane_sim.recording.read import read_recording

if TYPE_CHECKING:
    from crane_sim.simulation.rollout import Rollout


@click.group(cls=Application, context_settings=HELP)
@click.version_option(
    None, "-V", "--version", package_name="crane_sim", message="crane_sim %(version)s"
)
def app() -> None:
    """A crane simulator of ROS 2 nodes: accurate, fast, and bit for bit repeatable.

    SCENE is a name of the catalogue (crane scenes) or a file.
    """


@app.command("run")
@scene_options
@run_options
def run_scene(scene: str, as_json: bool, **scene_changes: Any) -> None:
    """Run a scene as OS processes over Fast DDS: plant, controller, recorder."""
    from crane_sim import orchestration

    options = RunOptions(**{name: scene_changes.pop(name) for name in RunOptions._fields})
    options.check()
    loaded = load_scene_with_options(scene, **scene_changes)
    options.check_scene(loaded)
    arguments = options.arguments(loaded.name)
    with report.compiling(quiet=as_json):
        compile_scene(loaded, braking=options.mode == "realtime")
    arguments["compile_time"] = report.compile_time()
    with report.progress(loaded, quiet=as_json or not sys.stderr.isatty()) as reporter:
        summary = orchestration.run(
            loaded, on_progress=reporter.update, on_news=reporter.log, **arguments
        )
    process_signals.exit_now(report.print_outcome(dict(loaded.notes) | summary, loaded, as_json))


@app.command(add_help_option=False, context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def drive(arguments: tuple[str, ...]) -> None:
    """Drive a crane by hand, in real time: by keyboard, gamepad or sensor_msgs/Joy (drive -h)."""
    from crane_sim.cli.drive import drive as command  # here: it imports what an operator needs

    command.main(list(arguments), prog_name="crane drive", standalone_mode=False)


@app.command()
@scene_options
@click.option(
    "--record",
    type=click.Path(path_type=Path),
    help="Write the run as a recording FILE.rrd; `crane run` always does.",
)
def simulate(scene: str, as_json: bool, record: Path | None, **changes: Any) -> None:
    """Run a scene in one process, without ROS: the same numbers, bit for bit, as a lockstep run."""
    from crane_sim.simulation.plant import SimulationError
    from crane_sim.simulation.rollout import simulate as roll_out

    check_recording(record)
    loaded = load_scene_with_options(scene, **changes)
    with report.compiling(quiet=as_json):
        roll_out(replace(loaded, duration=loaded.period))
    failure = {}
    try:
        result = roll_out(loaded)
    except SimulationError as error:
        result, failure = error.run, {"error": str(error)}
    recorded = {} if record is None else _record(result, record)
    summary = result.summary | report.speed(result) | report.WITHOUT_ROS | recorded | failure
    raise SystemExit(report.print_outcome(summary, loaded, as_json))


@app.command()
@click.argument("runs", nargs=-1, type=click.Path(path_type=Path), metavar="[RUN ...]")
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="A .png (default: the recording's name), .pdf or .svg.",
)
def plot(runs: tuple[Path, ...], output: Path | None) -> None:
    """Draw the curves of a recorded run, RUN or the newest.

    They are positions and targets, speeds, efforts, swing, energy.

    Of several runs of one crane: one curve a run of each quantity that all have, with one legend.
    """
    from crane_sim.report.figure import KINDS, save_comparison_figure, save_run_figure

    recordings = [find_recording(run) for run in runs or (None,)]
    file = check_output(output, recordings[0], *KINDS)
    install_groups("plots")
    if len(recordings) == 1:
        save_run_figure(read_recording(recordings[0]), file)
    else:
        from crane_sim.recording.comparison import compare

        save_comparison_figure(compare(*recordings), file)
    print(file)


@app.command("report")
@click.argument("run", required=False, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="A .html (default: the recording's name).",
)
def write_report(run: Path | None, output: Path | None) -> None:
    """Write a recorded run, RUN or the newest, as one HTML page that plays it.

    The page needs neither a network nor any other file.

    RUN may be the folder of a study: the page then has its distributions, differences and worst
    runs.
    """
    from crane_sim.report.page import save_page

    if run is not None and run.is_dir():
        from crane_sim.report.study_page import save_study_page
        from crane_sim.study.result import check_folder

        check_folder(run)
        file = check_output(output, run / "report", ".html")
        install_groups("plots", "study")
        save_study_page(run, file)
        print(file)
        return
    recording = find_recording(run)
    file = check_output(output, recording, ".html")
    save_page(read_recording(recording), file)
    print(file)


@app.command()
@as_json_option
def scenes(as_json: bool) -> None:
    """List the catalogue, one line each."""
    descriptions = {
        name: yaml.safe_load(file.read_text()).get("description", "")
        for name, file in scene_files().items()
    }
    if as_json:
        print(json.dumps(descriptions))
    else:
        report.print_scenes(descriptions)


@app.command()
@click.argument("file")
@change_options
@click.option(
    "--ros2-control",
    "urdf",
    type=click.Path(path_type=Path),
    help="Its <ros2_control> tag is checked, too.",
)
@click.option(
    "--namespace",
    default="",
    help="Namespace of the run that the tag is for, / the root (default: the crane's name).",
)
def check(file: str, urdf: Path | None, namespace: str, **changes: Any) -> None:
    """Validate a scene file, and with --ros2-control URDF the tag of ros2_control for its crane."""
    loaded = load_scene_with_options(file, **changes)
    if urdf is not None:
        from crane_sim.ros.common.ros2_control_tag import check_tag

        check_tag(loaded, urdf, namespace)
        print(f"{urdf}: fine (commands {', '.join(loaded.actuated)})")
    control = f"law {loaded.law_name}" if loaded.law_name else "open loop"
    steps = f"{loaded.steps} steps of {loaded.period:g} s"
    print(f"{file}: fine ({loaded.crane}, {loaded.duration:g} s, {steps}, {control})")
    report.print_notes(loaded.notes, report.Console())


@app.command()
@click.argument("scene")
def urdf(scene: str) -> None:
    """Print a crane's URDF; the plant adds a <ros2_control> tag (describe SCENE --ros2-control)."""
    from crane_sim.description import urdf as describe_crane

    print(describe_crane(load_scene_with_options(scene)))


@app.command(context_settings={"ignore_unknown_options": True, "help_option_names": []})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def test(arguments: tuple[str, ...]) -> None:
    """Run the test suite; arguments are pytest's."""
    tree = config_folder().parent
    if not (tree / "test").is_dir():
        raise SceneError(f"{tree}: has no tests; run this in the source tree")
    install_groups(*(name for name in GROUPS if name != "peers"))
    os.chdir(tree)
    process_signals.replace_process([sys.executable, "-m", "pytest", *arguments])


for command in (view, shot, clip, replay, compare_runs):
    app.add_command(command)
for command in (sweep, tune, identify_parameters, install_packages, interfaces, doctor):
    app.add_command(command)


def _record(run: "Rollout", path: Path) -> dict[str, Any]:
    """Write a recording; return its entries of the summary."""
    return {"recording": str(run.record(path)), "recorded_steps": run.summary["steps"]}
