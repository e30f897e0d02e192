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
from crane_sim.cli.help_lines import HELP, CommandGroup, IntAtLeast
from crane_sim.cli.identify import identify_parameters
from crane_sim.cli.package_groups import GROUPS, install_groups, install_packages
from crane_sim.cli.run_options import RunOptions, check_recording, ensure_writable_folder, run_options
from crane_sim.cli.scene_options import as_json_option, change_options, load_scene_with_options, scene_options
from crane_sim.cli.sweep import sweep
from crane_sim.cli.tune import tune
from crane_sim.cli.viewing import check_output, clip, find_recording, replay, shot, view
from crane_sim.files.catalogue import config_folder, scene_files
from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_output
from crane_sim.recording.read import read_recording

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene
    from crane_sim.simulation.rollout import Rollout


@click.group(cls=CommandGroup, context_settings=HELP)
@click.version_option(None, "-V", "--version", package_name="crane_sim", message="crane_sim %(version)s")
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
        _warm_plant(loaded)
    arguments["compile_time"] = report.compile_time()
    with report.progress(loaded, quiet=as_json or not sys.stderr.isatty()) as reporter:
        summary = orchestration.run(loaded, on_progress=reporter.update, on_news=reporter.log, **arguments)
    process_signals.exit_now(report.print_outcome(dict(loaded.notes) | summary, loaded, as_json))


@app.command(add_help_option=False, context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def drive(arguments: tuple[str, ...]) -> None:
    """Drive a crane by hand, in real time: by keyboard, gamepad or sensor_msgs/Joy (crane drive -h)."""
    from crane_sim.cli.drive import drive as command  # here: it imports what an operator needs

    command.main(list(arguments), prog_name="crane drive", standalone_mode=False)


@app.command()
@scene_options
@click.option("--record", type=click.Path(path_type=Path), help="Write the run as a recording: FILE.rrd.")
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
    "-o", "--output", type=click.Path(path_type=Path), help="A .png (default: the recording's name), .pdf or .svg."
)
def plot(runs: tuple[Path, ...], output: Path | None) -> None:
    """Draw the curves of a recorded run, RUN or the newest: positions and targets, speeds, efforts, swing, energy.

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
@click.option("-o", "--output", type=click.Path(path_type=Path), help="A .html (default: the recording's name).")
def write_report(run: Path | None, output: Path | None) -> None:
    """Write a recorded run, RUN or the newest, as one HTML page that plays it, without a network or any other file.

    RUN may be the folder of a study: the page then has its distributions, differences and worst runs.
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
@click.option("--save", "folder", metavar="FOLDER", help="Run the cranes of ports and sites; write their page there.")
@click.option("--scene", "names", multiple=True, metavar="NAME", help="Of --save only this one; may be repeated.")
@as_json_option
def scenes(folder: str | None, names: tuple[str, ...], as_json: bool) -> None:
    """List the catalogue, one line each."""
    if names and folder is None:
        raise SceneError("--scene: belongs to --save FOLDER; leave it out, or say where the page is")
    ensure_writable_folder(folder)
    if folder is not None:
        from crane_bench.documentation.scenes_page import check_names, save_page

        check_names(names)
        install_groups("plots")
        save_page(folder, names)
        return
    descriptions = {
        name: yaml.safe_load(file.read_text()).get("description", "") for name, file in scene_files().items()
    }
    if as_json:
        print(json.dumps(descriptions))
    else:
        report.print_scenes(descriptions)


@app.command()
@click.argument("file")
@change_options
@click.option("--ros2-control", "urdf", type=click.Path(path_type=Path), help="Its <ros2_control> tag is checked, too.")
@click.option(
    "--namespace", default="", help="Namespace of the run that the tag is for, / the root (default: the crane's name)."
)
def check(file: str, urdf: Path | None, namespace: str, **changes: Any) -> None:
    """Validate a scene file, and with --ros2-control URDF the tag with which ros2_control is to drive its crane."""
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
@click.argument("pages", nargs=-1)
@click.option("--build", is_flag=True, help="Build the documentation site.")
@click.option("--serve", is_flag=True, help="Build it, and serve it on the loopback interface.")
@click.option("-o", "--output", "folder", type=click.Path(path_type=Path), help="Of the site (default: site).")
def docs(pages: tuple[str, ...], build: bool, serve: bool, folder: Path | None) -> None:
    """List the pages in docs that commands write; with PAGES, write these anew ("pictures", "all")."""
    if not (build or serve):
        if folder is not None:
            raise SceneError("crane docs --output: needs --build or --serve")
        from crane_bench.documentation import command

        command.check_names(pages)
        install_groups(*["plots"] * bool(pages))
        command.docs(pages)
        return
    if pages:
        raise SceneError(f"crane docs {pages[0]}: the site has all pages; leave out the name")
    from crane_bench.documentation.site import build_site, serve_site, source_tree

    tree = source_tree()
    install_groups("docs")
    site = build_site(tree, folder or Path("site"))
    print(site / "index.html")
    if serve:
        serve_site(site)


@app.command()
@click.argument("scene", required=False)
@click.option("--python", is_flag=True, help="The Python interface instead: functions, arguments, attributes.")
@click.option("--ros2-control", is_flag=True, help="Of SCENE: its URDF with a <ros2_control> tag, and controllers.")
@click.option("--save", "folder", metavar="FOLDER", help="Write the page or files there instead of printing them.")
def describe(scene: str | None, python: bool, ros2_control: bool, folder: str | None) -> None:
    """Describe the format of scene files: every key, its unit, default and meaning (Markdown).

    With SCENE and --ros2-control: what a stock ros2_control needs to drive this crane.
    """
    from crane_bench.documentation import api_page, scene_format

    ensure_writable_folder(folder)
    if (scene is None) == ros2_control:
        raise SceneError(f"crane describe {scene or '--ros2-control'}: SCENE and --ros2-control belong together")
    if scene is not None and python:
        raise SceneError(
            f"crane describe {scene} --python: the Python interface is that of all scenes; leave out SCENE"
        )
    if scene is not None:
        _describe_ros2_control(load_scene_with_options(scene), folder)
    elif folder is not None:
        (api_page.save_api_page if python else scene_format.save_scene_format)(folder)
    else:
        print(api_page.api_page() if python else scene_format.scene_format(), end="")


def _describe_ros2_control(scene: "Scene", folder: str | None) -> None:
    """Print the description and the controllers of a scene, or write them into a folder."""
    from crane_sim.ros.common.ros2_control import controllers_file, urdf_with_ros2_control

    files = {f"{scene.name}.urdf": urdf_with_ros2_control(scene)}
    files[f"{scene.name}_controllers.yaml"] = controllers_file(scene)
    for name, text in files.items():
        if folder is None:
            print(text)
        else:
            write_output("--save", Path(folder, name), lambda path, text=text: path.write_text(f"{text.rstrip()}\n"))
            print(Path(folder, name))


@app.command()
@click.argument("packages", nargs=-1)
@click.option("--check", is_flag=True, help="Build nothing: only list what is there and from where.")
def interfaces(packages: tuple[str, ...], check: bool) -> None:
    """Build the message packages that ROS 2's wheels lack into the environment (about a minute, once), and list them.

    PACKAGES: tf2_msgs, simulation_interfaces, control_msgs; all when left out. One that is there is used as it is.
    """
    from crane_sim.cli.interfaces import interfaces as command

    raise SystemExit(command(packages, check))


@app.command()
@click.argument("scene")
def urdf(scene: str) -> None:
    """Print a crane's URDF, without the <ros2_control> tag that the plant adds (describe SCENE --ros2-control)."""
    from crane_sim.description import urdf as describe_crane

    print(describe_crane(load_scene_with_options(scene)))


@app.command()
@click.argument("item", required=False)
@click.option("--save", "folder", metavar="FOLDER", help="Also write pages and figures there.")
@as_json_option
def reproduce(item: str | None, folder: str | None, as_json: bool) -> None:
    """Compare the papers' results, and references, with what is measured here.

    ITEM: overhead, hardcases, knuckle, offshore, observer; all when left out.
    """
    from crane_bench.reproduce import check_item, show

    check_item(item)
    ensure_writable_folder(folder)
    install_groups(*["plots"] * (folder is not None))
    show(item, as_json, folder)


@app.command()
@click.option("--save", "folder", metavar="FOLDER", help="Also write page, figure and data there.")
@click.option(
    "--samples",
    type=IntAtLeast(2),
    help="Runs of each law in each trial, on the same samples; less than 11 cannot tell 8 laws apart.",
)
@click.option("-o", "--output", type=click.Path(path_type=Path), help="Rows of samples (default: runs/league_SAMPLES).")
@click.option(
    "--crane",
    "cranes",
    multiple=True,
    metavar="CRANE",
    help="With --samples: only this crane, which --save adds to those of the page; repeatable.",
)
@as_json_option
def league(
    folder: str | None, samples: int | None, output: Path | None, cranes: tuple[str, ...], as_json: bool
) -> None:
    """Try every law on every scene that suits it: errors, swing, efforts (some minutes).

    With --samples every trial is a study, with intervals; interrupted, the same command runs what is missing.
    """
    from crane_bench.cli import league as command
    from crane_bench.league.cases import groups_named

    if samples is None and (output is not None or cranes):
        option = f"--crane {cranes[0]!r}" if cranes else f"-o {str(output)!r}"
        raise click.UsageError(f"{option}: is for --samples N only; add it, or leave out {option.split()[0]}")
    ensure_writable_folder(folder)
    install_groups(*["plots"] * (folder is not None and samples is None))
    if samples is None:
        command.league(as_json, folder)
    else:
        rows = output or Path("runs") / f"league_{samples}"
        command.sampled_league(as_json, folder, samples, rows, groups_named(cranes))


@app.command(add_help_option=False, context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def bench(arguments: tuple[str, ...]) -> None:
    """Benchmark speed against error, ROS transport and other suites (crane bench -h)."""
    from crane_bench.cli.bench import bench as command  # here: it imports every suite

    command.main(list(arguments), prog_name="crane bench", standalone_mode=False)


@app.command(add_help_option=False, context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def soak(arguments: tuple[str, ...]) -> None:
    """Test long runs and runs under faults (crane soak -h)."""
    from crane_bench.cli.soak import soak as command

    command.main(list(arguments), prog_name="crane soak", standalone_mode=False)


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


for command in (view, shot, clip, replay, compare_runs, sweep, tune, identify_parameters, install_packages, doctor):
    app.add_command(command)


def _warm_plant(scene: Any) -> None:
    """Compile the scene once, before several nodes would compile it in parallel."""
    from crane_sim.simulation.plant import Plant

    plant = Plant(scene)
    demand = scene.law(0.0, plant.q, plant.v) if scene.law else (0.0,) * len(scene.actuated)
    plant.advance(demand if scene.sampled else None)
    plant.summary()


def _record(run: "Rollout", path: Path) -> dict[str, Any]:
    """Write a recording; return its entries of the summary."""
    return {"recording": str(run.record(path)), "recorded_steps": run.summary["steps"]}
