"""The command `crane bench`."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import click
from rich.console import Console

from crane_bench.speed import groups, scenes
from crane_bench.speed.cases import ERROR_LEVELS
from crane_bench.speed.crane_sim_engine import METHODS
from crane_bench.speed.page import FIGURES, format_page
from crane_bench.speed.results import cheapest_points, read_points
from crane_bench.speed.store import merge_suite, read_store, write_store
from crane_bench.speed.suites import SUITES
from crane_sim.cli.help_lines import HELP
from crane_sim.cli.package_groups import install_groups
from crane_sim.cli.tables import print_table
from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.files.output import write_text
from crane_sim.report.plotting import save_figure

SUITE_NAMES = ("scenes", *SUITES, "page")
SOAKS = ("kill", "signals", "memory", "inprocess", "determinism", "realtime")
_HELP = f"""Benchmark speed against error (scenes), ROS transport and other suites.

SUITE: {", ".join(SUITE_NAMES)}; scenes when left out, page rewrites page and figure. Control periods per second of
Plant.advance and simulate, without ROS: crane soak inprocess.

Data, figure and page go to FOLDER; unmeasured suites and scenes keep their previous data.
"""  # noqa: E501


@click.command(context_settings=HELP, help=_HELP)
@click.argument("suite", default="scenes")
@click.option("--quick", is_flag=True, help="Four scenes and three methods.")
@click.option(
    "--scene",
    "ids",
    multiple=True,
    metavar="ID",
    help="Only these (S1, S3a, ... or a catalogue name); may be repeated.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    metavar="NAME",
    help=f"Only these: {', '.join(METHODS)}; may be repeated.",
)
@click.option(
    "--crane",
    "cranes",
    multiple=True,
    metavar="NAME",
    help="Only this crane, for the suite groups; may be repeated.",
)
@click.option(
    "--peers", is_flag=True, help="Measure every other installed engine as well, interleaved."
)
@click.option(
    "--save",
    "folder",
    default="runs/bench",
    show_default=True,
    metavar="FOLDER",
    help="Where results go.",
)
def bench(
    suite: str,
    quick: bool,
    ids: Sequence[str],
    methods: Sequence[str],
    cranes: Sequence[str],
    peers: bool,
    folder: str,
) -> None:
    """Run a suite of the benchmark."""
    if suite not in SUITE_NAMES:
        hint = f"; crane soak {suite} is a soak" if suite in SOAKS else ""
        raise SceneError(unknown_key(suite, SUITE_NAMES, "SUITE") + hint)
    if suite != "scenes" and (quick or ids or methods or peers):
        raise SceneError(
            f"bench {suite}: --quick, --scene, --method and --peers only apply to scenes"
        )
    if suite != "groups" and cranes:
        raise SceneError(f"bench {suite}: --crane only applies to groups")
    cases = scenes.select_cases(ids, quick)
    if cranes:
        groups.select_cases(cranes)
    install_groups("bench")  # before anything is measured, which would be lost
    data = read_store(_make_folder(folder))
    if suite == "page" and not data:
        raise SceneError(
            f"bench page: {folder} has no data yet; measure something, or name another --save "
            "FOLDER"
        )
    if suite == "scenes":
        with Console(stderr=True).status("measuring") as status:
            measured = scenes.measure_scenes(
                cases, methods or (scenes.QUICK_METHODS if quick else ()), peers, status.update
            )
        data = merge_suite(data, suite, measured)
        for case in measured["scenes"]:
            _print_cheapest(case, data["scenes"]["scenes"][case])
    elif suite != "page":
        with Console(stderr=True).status(f"measuring: {SUITES[suite].title}"):
            data = merge_suite(
                data, suite, _measure_groups(data, cranes) if cranes else SUITES[suite].measure()
            )
        print("\n".join(SUITES[suite].format(data[suite])))
    _write(data, Path(folder))


def _measure_groups(data: dict[str, Any], cranes: Sequence[str]) -> dict[str, Any]:
    """Return the measured costs of these cranes' groups, with the previous data of other cranes."""
    measured = groups.measure_groups(cases=groups.select_cases(cranes))
    return groups.join(data["groups"], measured) if "groups" in data else measured


def _make_folder(folder: str) -> Path:
    try:
        Path(folder).mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise SceneError(f"--save {folder!r}: {error.strerror}") from None
    return Path(folder)


def _write(data: dict[str, Any], folder: Path) -> None:
    """Write data, figure and page."""
    from crane_bench.speed.figure import draw_benchmark

    written = ["performance.json", "performance.md"]
    try:
        write_store(data, folder)
        for suite, name in FIGURES.items():
            measured = data.get(suite, {}).get("scenes")
            if measured and save_figure(draw_benchmark, measured, folder / name, dpi=110):
                written.append(name)
        drawn = any((folder / name).is_file() for name in FIGURES.values())
        write_text(folder / "performance.md", format_page(data, drawn=drawn))
    except OSError as error:
        raise SceneError(f"--save {str(folder)!r}: {error.strerror}") from None
    Console(stderr=True).print(f"written to {folder}: {', '.join(written)}", markup=False)


def _print_cheapest(case: str, scene: dict[str, Any]) -> None:
    """Print the cheapest setting of every engine, and of every method of this simulator."""
    title = f"{case}: {scene['title']}\nµs of wall time per simulated second, at errors of"
    rows = [
        (
            engine,
            *("—" if p is None else f"{p.us_per_s:.3g} {p.method} {p.setting:.2g}" for p in points),
        )
        for engine, points in cheapest_points(read_points(scene), scene["trusted"]).items()
    ]
    print_table(Console(), title, ("engine", *(f"{level:.0e} m" for level in ERROR_LEVELS)), rows)
