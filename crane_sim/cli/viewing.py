"""The subcommands that show a recording, `view`, `shot`, `clip`, and `replay`, which repeats it."""

import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import click
from rich.console import Console
from rich.progress import Progress

from crane_sim import process_signals
from crane_sim.cli import report
from crane_sim.cli.help_lines import FiniteRange
from crane_sim.cli.run_options import VIEWER_PORT, ensure_writable_file
from crane_sim.cli.scene_options import as_json_option
from crane_sim.files.document import function_from
from crane_sim.files.errors import SceneError
from crane_sim.recording.read import is_recording

RUNS = Path("runs")  # where `crane run` puts recordings

_RUN = click.argument("run", required=False, type=click.Path(path_type=Path))


def _picture_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options on what of a recording is drawn."""
    for option in (
        click.option(
            "--view",
            default="",
            metavar="TITLE",
            help="Only the view of this title, such as Crane.",
        ),
        click.option(
            "--tab", default="", metavar="NAME", help="Overview | Details | States | Summary."
        ),
    ):
        command = option(command)
    return command


@click.command()
@_RUN
@click.option(
    "--web",
    is_flag=True,
    help="Serve the viewer's page to a browser on this machine; print its address.",
)
@click.option(
    "--live", is_flag=True, help=f"Watch a run that was started with --live, on port {VIEWER_PORT}."
)
@click.option("--port", type=click.IntRange(1, 65535), help="--live: the port that the run serves.")
def view(run: Path | None, web: bool, live: bool, port: int | None) -> None:
    """Open a recording in the Rerun viewer: RUN, or the newest in runs/."""
    if run is not None and live:
        raise SceneError(
            f"RUN and --live: only one of the two is possible, --live has no file yet ({run})"
        )
    if port is not None and not live:
        raise SceneError(f"--port = {port}: only with --live, whose run serves it")
    recording = None if live else find_recording(run)
    from crane_sim.recording.rerun.live import live_address
    from crane_sim.recording.rerun.viewer import ENVIRONMENT, check_viewable, window_command

    if recording is not None:
        check_viewable(recording)
    name = live_address(port or VIEWER_PORT) if recording is None else str(recording)
    source = name if recording is None else _source(recording)
    if web:
        from crane_sim.recording.rerun.web_page import web_page

        with web_page(source) as (viewer, address):
            print(f"{name} is shown at\n{address}\nuntil Ctrl-C", flush=True)
            raise SystemExit(viewer.wait())
    _require_display()
    command = window_command(source)
    process_signals.replace_process(command, os.environ | ENVIRONMENT)


@click.command()
@_RUN
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="The PNG (default: the recording's name).",
)
@click.option(
    "--time", "at", type=FiniteRange(), help="Scene time in s (default: the end of the run)."
)
@_picture_options
def shot(run: Path | None, output: Path | None, at: float | None, tab: str, view: str) -> None:
    """Draw a recording as the viewer does into a PNG, without a display.

    It is RUN, or the newest in runs/.
    """
    recording = find_recording(run)
    from crane_sim.recording.rerun.screenshot import Shown, picture

    output = check_output(output, recording, ".png")
    for line in picture(recording, output, at, Shown(tab, view)):
        print(f"crane: {line}", file=sys.stderr)
    print(output)


@click.command()
@_RUN
@click.option(
    "-o",
    "--output",
    type=click.Path(path_type=Path),
    help="A .gif or .mp4 (default: the recording's name).",
)
@click.option(
    "--from", "begin", type=FiniteRange(), default=0.0, help="Scene time in s at which it begins."
)
@click.option(
    "--to",
    "end",
    type=FiniteRange(),
    help="Scene time in s at which it ends (default: the end of the run).",
)
@click.option(
    "--fps",
    "frames_per_second",
    type=FiniteRange(1.0, 60.0),
    default=10.0,
    help="Pictures per second (default 10).",
)
@click.option(
    "--speed", type=FiniteRange(1e-3, 1e3), default=1.0, help="Scene time by time of the clip (1)."
)
@click.option("--width", type=click.IntRange(64, 1920), default=960, help="In pixels (960).")
@_picture_options
def clip(run: Path | None, output: Path | None, tab: str, view: str, **cut: Any) -> None:
    """Make a clip of a recording, without a display: RUN, or the newest in runs/.

    A picture takes about a second.
    """
    recording = find_recording(run)
    from crane_sim.recording.rerun.clip import Cut, write_clip
    from crane_sim.recording.rerun.screenshot import Shown

    output = check_output(output, recording, ".gif", ".mp4")
    with Progress(
        console=Console(stderr=True), disable=not sys.stderr.isatty(), transient=True
    ) as bar:
        task = bar.add_task("pictures")
        write_clip(
            recording,
            output,
            Cut(**cut),
            Shown(tab, view),
            lambda k, n: bar.update(task, completed=k, total=n),
        )
    print(output)


@click.command()
@_RUN
@click.option(
    "--law",
    help="Execute this law, a name or FILE.py:FUNCTION, where the run was driven without commands.",
)
@as_json_option
def replay(run: Path | None, law: str | None, as_json: bool) -> None:
    """Integrate a recorded run, RUN or the newest, anew from its commands.

    Every state is compared bit for bit.

    Exit code 0 where all states agree, else 1.
    """
    from crane_sim.recording.read import read_recording
    from crane_sim.recording.replay import replay as replay_run

    recording = find_recording(run)
    own = None if law is None else function_from(law, Path.cwd())
    with report.compiling(quiet=as_json):
        outcome = replay_run(read_recording(recording), own)
    if as_json:
        difference = outcome.difference and outcome.difference._asdict() | {
            "bit": outcome.difference.bit
        }
        print(
            json.dumps(
                {"steps": outcome.steps, "difference": difference, "changed": outcome.changed}
            )
        )
        raise SystemExit(int(outcome.difference is not None))
    if outcome.difference is None:
        print(f"{recording}: {outcome.steps} states agree bit for bit")
        return
    print(f"{recording}: {outcome.difference}")
    for name, (then, now) in outcome.changed.items():
        print(f"  {name} was {then}, is {now} now")
    if not outcome.changed:
        print(
            "  versions, processor and lock file are as they were: look for services that were "
            "called in the run"
        )
    raise SystemExit(1)


def find_recording(run: Path | None) -> Path:
    """Return the path of a recording: `run`, or the newest in `RUNS` where that is None.

    Raises:
        SceneError: there is none.
    """
    if run is not None and is_recording(run):
        return run
    if run is not None:
        raise SceneError(
            f"RUN = {str(run)!r}: no such file; leave it out for the newest in {RUNS}/"
        )
    recordings = sorted(RUNS.glob("*.rrd"), key=lambda file: file.stat().st_mtime)
    if not recordings:
        raise SceneError(f"RUN: {RUNS}/ has no recording yet; crane run makes one")
    return recordings[-1]


def check_output(output: Path | None, recording: Path, *suffixes: str) -> Path:
    """Return the file to write: `output`, or one named as the recording; create its folder.

    The latter has the first suffix.

    Raises:
        SceneError: it has another suffix, or cannot be written.
    """
    file = output or recording.with_suffix(suffixes[0])
    if file.suffix not in suffixes:
        raise SceneError(f"--output {file}: must end in {' or '.join(suffixes)}")
    ensure_writable_file("--output", file)
    return file


def _source(recording: Path) -> str:
    """Return the viewer's argument for a recording: its path; "-" for one that is cut.

    What is whole of a cut recording becomes stdin.
    """
    from crane_sim.recording.rerun.rrd_file import open_viewable

    if (whole := open_viewable(recording)) is None:
        return str(recording)
    os.dup2(whole.fileno(), sys.stdin.fileno())
    return "-"


def _require_display() -> None:
    if sys.platform == "linux" and not (
        os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY")
    ):
        raise SceneError(
            "crane view: there is no display here; --web serves the recording to a browser, crane "
            "shot draws a picture"
        )
