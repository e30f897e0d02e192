"""The commands of the laboratory: what they can do is imported when they are called."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from crane_sim.cli.help_lines import IntAtLeast
from crane_sim.cli.package_groups import install_groups
from crane_sim.cli.run_options import ensure_writable_folder
from crane_sim.cli.scene_options import as_json_option, load_scene_with_options
from crane_sim.files.errors import SceneError
from crane_sim.files.output import write_output

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene


@click.command()
@click.argument("pages", nargs=-1)
@click.option("--build", is_flag=True, help="Build the documentation site.")
@click.option("--serve", is_flag=True, help="Build it, and serve it on the loopback interface.")
@click.option(
    "-o", "--output", "folder", type=click.Path(path_type=Path), help="Of the site (default: site)."
)
def docs(pages: tuple[str, ...], build: bool, serve: bool, folder: Path | None) -> None:
    """List the pages in docs that commands write; write PAGES anew ("pictures", "all")."""
    if not (build or serve):
        if folder is not None:
            raise SceneError("crane docs --output: needs --build or --serve")
        from crane_bench.documentation import command

        command.check_names(pages)
        install_groups(*["bench"] * bool(pages))
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


@click.command()
@click.argument("scene", required=False)
@click.option(
    "--python", is_flag=True, help="The Python interface instead: functions, arguments, attributes."
)
@click.option(
    "--schema",
    is_flag=True,
    help="The format as a JSON schema instead, by which editors complete keys.",
)
@click.option(
    "--ros2-control",
    is_flag=True,
    help="Of SCENE: its URDF with a <ros2_control> tag, and controllers.",
)
@click.option(
    "--sites",
    is_flag=True,
    help="Cranes of ports and sites instead: run them, write page and pictures.",
)
@click.option(
    "--scene",
    "names",
    multiple=True,
    metavar="NAME",
    help="Of --sites only this one; may be repeated.",
)
@click.option(
    "--save",
    "folder",
    metavar="FOLDER",
    help="Write the page or files there instead of printing them.",
)
def describe(
    scene: str | None,
    python: bool,
    schema: bool,
    ros2_control: bool,
    sites: bool,
    names: tuple[str, ...],
    folder: str | None,
) -> None:
    """Describe the format of scene files (Markdown): keys, units, defaults, meaning; or SCENE.

    With SCENE and --ros2-control: what a stock ros2_control needs to drive this crane.
    """
    from crane_bench.documentation import api_page, json_schema, scene_format

    if names and not sites:
        raise SceneError("crane describe --scene: belongs to --sites; leave it out, or add that")
    ensure_writable_folder(folder)
    if sites:
        _describe_sites(
            folder, names, alone=scene is None and not (python or schema or ros2_control)
        )
        return
    if scene is None and ros2_control:
        raise SceneError("crane describe --ros2-control: needs SCENE")
    if python and schema:
        raise SceneError("crane describe --python --schema: take one of the two")
    for option, given, what in (
        ("--python", python, "Python interface"),
        ("--schema", schema, "JSON schema"),
    ):
        if given and scene is not None:
            raise SceneError(
                f"crane describe {scene} {option}: the {what} is that of all scenes; leave out "
                "SCENE"
            )
    if scene is not None:
        if ros2_control:
            _describe_ros2_control(load_scene_with_options(scene), folder)
        else:
            _describe_scene(scene, folder)
        return
    write, text = scene_format.save_scene_format, scene_format.scene_format
    if python:
        write, text = api_page.save_api_page, api_page.api_page
    if schema:
        write, text = json_schema.save_json_schema, json_schema.json_schema_text
    if folder is None:
        print(text(), end="")
    else:
        write(folder)


def _describe_sites(folder: str | None, names: tuple[str, ...], alone: bool) -> None:
    """Run the cranes of ports and sites, or the named ones, and write their page to a folder."""
    from crane_bench.documentation.scenes_page import check_names, save_page

    if not alone or folder is None:
        raise SceneError(
            "crane describe --sites: needs --save FOLDER, and no other option but --scene"
        )
    check_names(names)
    install_groups("bench")
    save_page(folder, names)


def _describe_scene(scene: str, folder: str | None) -> None:
    """Print what a scene is."""
    from crane_sim.cli.scene_description import print_scene

    if folder is not None:
        raise SceneError(
            f"crane describe {scene} --save: a scene is printed; leave it out, or add "
            "--ros2-control"
        )
    print_scene(load_scene_with_options(scene))


def _describe_ros2_control(scene: "Scene", folder: str | None) -> None:
    """Print the description and the controllers of a scene, or write them into a folder."""
    from crane_sim.ros.common.ros2_control import controllers_file, urdf_with_ros2_control

    files = {f"{scene.name}.urdf": urdf_with_ros2_control(scene)}
    files[f"{scene.name}_controllers.yaml"] = controllers_file(scene)
    for name, text in files.items():
        if folder is None:
            print(text)
        else:
            write_output(
                "--save",
                Path(folder, name),
                lambda path, text=text: path.write_text(f"{text.rstrip()}\n"),
            )
            print(Path(folder, name))


@click.command()
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
    install_groups(*["bench"] * (folder is not None))
    show(item, as_json, folder)


@click.command()
@click.option("--save", "folder", metavar="FOLDER", help="Also write page, figure and data there.")
@click.option(
    "--samples",
    type=IntAtLeast(2),
    help="Runs of each law in each trial, on the same samples; less than 11 cannot tell 8 laws "
    "apart.",
)
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="Rows of samples (default: runs/league_SAMPLES).",
)
@click.option(
    "--crane",
    "cranes",
    multiple=True,
    metavar="CRANE",
    help="With --samples: only this crane, which --save adds to those of the page; repeatable.",
)
@as_json_option
def league(
    folder: str | None,
    samples: int | None,
    output: Path | None,
    cranes: tuple[str, ...],
    as_json: bool,
) -> None:
    """Try every law on every scene that suits it: errors, swing, efforts (some minutes).

    With --samples every trial is a study, with intervals; interrupted, the same command runs what
    is missing.
    """
    from crane_bench.cli import league as command
    from crane_bench.league.cases import groups_named

    if samples is None and (output is not None or cranes):
        option = f"--crane {cranes[0]!r}" if cranes else f"-o {str(output)!r}"
        raise click.UsageError(
            f"{option}: is for --samples N only; add it, or leave out {option.split()[0]}"
        )
    ensure_writable_folder(folder)
    install_groups(*["bench"] * (folder is not None))
    if samples is None:
        command.league(as_json, folder)
    else:
        rows = output or Path("runs") / f"league_{samples}"
        command.sampled_league(as_json, folder, samples, rows, groups_named(cranes))


@click.command(add_help_option=False, context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def bench(arguments: tuple[str, ...]) -> None:
    """Benchmark speed against error, ROS transport and other suites (crane bench -h)."""
    from crane_bench.cli.bench import bench as command  # here: it imports every suite

    command.main(list(arguments), prog_name="crane bench", standalone_mode=False)


@click.command(add_help_option=False, context_settings={"ignore_unknown_options": True})
@click.argument("arguments", nargs=-1, type=click.UNPROCESSED)
def soak(arguments: tuple[str, ...]) -> None:
    """Test long runs and runs under faults (crane soak -h)."""
    from crane_bench.cli.soak import soak as command

    command.main(list(arguments), prog_name="crane soak", standalone_mode=False)
