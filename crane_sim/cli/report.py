"""Terminal output: the progress bar, the summary, the catalogue."""

import json
import math
import os
import re
import shlex
import shutil
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, Progress, TextColumn, TimeRemainingColumn
from rich.table import Table

from crane_sim.cli.tables import print_line, print_table
from crane_sim.files.catalogue import config_folder
from crane_sim.recording.metric_units import plain_unit
from crane_sim.recording.path_units import path_unit_of_scene
from crane_sim.recording.run import NOT_IN_REAL_TIME

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene
    from crane_sim.simulation.rollout import Rollout

_GROUPS = (
    "wall_time compile_time real_time_factor steps_per_second rhs_evaluations deadline_misses "
    "unanswered_steps",
    "peak_swing_deg residual_swing_deg peak_tilt_deg peak_skew_deg peak_trim_deg peak_list_deg "
    "peak_lateral_deflection_deg peak_vertical_deflection_deg peak_mast_x_deflection_deg "
    "peak_mast_y_deflection_deg min_rope_tension max_rope_tension max_lead_line_tension "
    "max_drum_torque "
    "peak_contact_force saturated_steps energy_audit_error energy_audit_max",
    "tracking_mse tracking_mae tracking_peak peak_tip_acceleration",
    "peak_base_acceleration peak_base_angular_acceleration",
    "method model model_error_estimate left_out",
)
"""Metrics of the table: speed, motion, path, base, and what was chosen."""
_FURTHER_UNITS = {"real_time_factor": "x", "model_error_estimate": "m"}
"""Units of what only the terminal shows with one."""

_COMPUTE_TIMES = {"law_us": "law per step", "tracker_us": "tracker per setpoint"}

_ZERO_TOLERANCE = 1e-20  # in any unit: smaller values are rounding errors of zero

WITHOUT_ROS: dict[str, Any] = {
    "deadline_misses": 0,
    "commands": None,
    "recording": None,
    "recorded_steps": 0,
    "lost_steps": 0,
}
"""Summary entries on topics and recordings of a run without ROS."""


def speed(run: "Rollout") -> dict[str, float]:
    """Return the summary's entries on a run's speed."""
    wall, summary = run.stats["wall_time"], run.summary
    return {
        "wall_time": wall,
        "compile_time": compile_time(),
        "real_time_factor": summary["sim_time"] / wall,
        "steps_per_second": summary["steps"] / wall,
    }


def json_value(value: Any) -> Any:
    """Return the value for JSON: plain Python numbers, None for non-finite, no negative zero."""
    if isinstance(value, Mapping):
        return {key: json_value(entry) for key, entry in value.items()}
    if isinstance(value, list | tuple):
        return [json_value(entry) for entry in value]
    value = _python_number(value)
    if isinstance(value, float):
        return value + 0.0 if math.isfinite(value) else None
    return value


def _python_number(value: Any) -> Any:
    """Return a scalar of numpy as one of Python; any other value as it is."""
    return value.item() if hasattr(value, "item") else value


class ProgressReporter(NamedTuple):
    """Progress of a run at the terminal: `update(steps done, total steps)`, and `log(line)`."""

    update: Callable[[int, int], None]
    log: Callable[[str], None]


@contextmanager
def progress(scene: "Scene", quiet: bool) -> Iterator[ProgressReporter]:
    """Yield a progress bar's reporter with the real-time factor; `quiet`: it only prints lines."""
    columns = (
        TextColumn("{task.description}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %  {task.fields[factor]}"),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), disable=quiet, transient=True) as bar:
        task = bar.add_task(escape(scene.name), total=scene.steps, factor="")

        def update(done: int, _: int) -> None:
            elapsed = bar.tasks[0].elapsed or 0.0
            factor = (
                f"{done * scene.period / elapsed:.1f} x real time"
                if elapsed > 0.0 and done
                else "starting"
            )
            bar.update(task, completed=done, factor=factor)

        def log(line: str) -> None:
            print_line(bar.console, f"crane: {line}")

        yield ProgressReporter(update, log)


def compile_time() -> float:
    """Return how long this process has compiled [s]."""
    from crane_sim.tracing.compile_time import compile_time as seconds

    return seconds()


COMPILING = (
    "compiling this kind of scene (once per kind, group and law: 1 to 10 s, on a busy machine a "
    "minute)"
)
"""What is said while something compiles."""


@contextmanager
def compiling(quiet: bool) -> Iterator[None]:
    """Show a status line while a kind of scene is compiled; none where nothing needs compiling.

    Where stderr is no terminal, or `quiet`, it is one line, once in a process.
    """
    from crane_sim.tracing.compile_time import watch_compiling

    status = Console(stderr=True).status(COMPILING)
    show = _say_compiling if quiet or not sys.stderr.isatty() else status.start
    try:
        with watch_compiling(show):
            yield
    finally:
        status.stop()


@cache
def _say_compiling() -> None:
    """Say on stderr that a kind of scene is compiled."""
    print(f"crane: {COMPILING}", file=sys.stderr, flush=True)


def print_summary(summary: dict[str, Any], scene: "Scene") -> None:
    """Print the most important metrics of a scene's run as tables."""
    console = Console()
    console.print(_metrics_table(summary, path_unit_of_scene(scene)))
    _print_joints(console, summary, scene)
    if steps := summary.get("negative_tension_steps", 0):
        periods, most = (
            f"{steps} of {summary.get('steps')} periods",
            _format_number(-summary["min_rope_tension"]),
        )
        what = f"the cable was under compression of up to {most} N in {periods}"
        print_line(console, f"warning: {what}; a rope cannot push")
    if violation := summary.get("real_time_violation"):
        consequence = "its motion and metrics are also those of this machine"
        print_line(console, f"warning: {NOT_IN_REAL_TIME}: {violation}; {consequence}")
    print_notes(summary, console)
    _print_events(console, summary)
    if "state_sha256" in summary:
        print_line(console, f"state sha256  {summary['state_sha256']}")
    _print_files(console, summary)


def _metrics_table(summary: dict[str, Any], path_unit: str) -> Table:
    """Return the table of the metrics that a run has, by groups, and of its messages."""
    law = summary.get("law") or ("external" if summary.get("commands") else "none")
    title = escape(f"{summary['scene']} · law {law} · {summary['mode']}")
    table = Table(title=title, show_header=False, title_justify="left", box=box.SIMPLE)
    seconds = f"{_format_number(summary['sim_time'])} s in " if "sim_time" in summary else ""
    table.add_row("simulated", f"{seconds}{summary.get('steps')} steps")
    hidden = _hidden_metrics(summary)
    for keys in _GROUPS:
        table.add_section()
        for key in keys.split():
            if key in summary and key not in hidden:
                unit = plain_unit(key, path_unit) or _FURTHER_UNITS.get(key, "")
                value = escape(f"{_format_number(summary[key])} {unit}")
                table.add_row(key.removesuffix("_deg").replace("_", " "), value)
    table.add_section()
    for title, text in _message_rows(summary):
        table.add_row(title, text)
    return table


def _hidden_metrics(summary: Mapping[str, Any]) -> set[str]:
    """Return the metrics of speed without a meaning: of deadlines or compilation without any."""
    hidden = set() if summary["mode"] == "realtime" else {"deadline_misses"}
    return hidden if summary.get("compile_time") else hidden | {"compile_time"}


def print_outcome(summary: dict[str, Any], scene: "Scene", as_json: bool) -> int:
    """Print the summary of a run; return the exit code."""
    if as_json:
        print(json.dumps(json_value(summary)))
    elif summary.get("steps"):
        print_summary(summary, scene)
    if "error" in summary:
        print(f"crane: {summary['error']}", file=sys.stderr)
    return int("error" in summary)


def print_notes(notes: Mapping[str, Any], console: Console) -> None:
    """Print drawn values, notes on rounded and warnings of unlikely ones, one line each."""
    for key, value in notes.get("drawn", {}).items():
        shown = _format_number(value) if isinstance(value, float) else value
        print_line(console, f"{'drawn:':<8} {key} = {shown}")
    for key, word in (("rounded", "note"), ("warnings", "warning")):
        for line in notes.get(key, ()):
            print_line(console, f"{word + ':':<8} {line}")


def _print_events(console: Console, summary: dict[str, Any]) -> None:
    """Print the events, or their kinds where they are many."""
    kinds = summary.get("event_kinds", ())
    for kind in kinds:
        when = f"{kind['first']:.3f} s" + (f" .. {kind['last']:.3f} s" if kind["count"] > 1 else "")
        print_line(console, f"{kind['count']:6} x  {when:>24}  {kind['what']}")
    for event in summary.get("events", ()) if not kinds else ():
        print_line(console, f"{event['t']:12.6f} s  {event['what']}")
    listed = sum(kind["count"] for kind in kinds) or len(summary.get("events", ()))
    if more := summary.get("event_count", 0) - listed:
        print_line(console, f"{'':14}and {more} more events")


def _print_files(console: Console, summary: dict[str, Any]) -> None:
    for key in ("recording", "mcap"):
        if summary.get(key):
            print_line(console, f"{key:<13} {summary[key]}")
    for key, title in (
        ("parts", "part"),
        ("bag_parts", "bag part"),
        ("before_reset", "before reset"),
    ):
        for path in summary.get(key, ()):
            print_line(console, f"{title:<13} {path}")
    if summary.get("recording"):
        command = f"{crane_command()} view {shlex.quote(str(summary['recording']))}"
        print_line(console, f"{'open it with':<13} {command}")


def crane_command() -> str:
    """Return this command as one types it.

    It is `crane` if that is on the PATH, else the tree's script or the program.
    """
    if shutil.which("crane"):
        return "crane"
    script, folder = config_folder().parent / "crane", Path.cwd()
    program = script if script.is_file() else Path(sys.executable).with_name("crane")
    if not program.is_relative_to(folder):
        return shlex.quote(str(program))
    return shlex.quote(os.path.join(os.curdir, program.relative_to(folder)))


def _message_rows(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yield what a run over ROS says of its messages and nodes."""
    if commands := summary.get("commands"):
        yield "commands", ", ".join(f"{count} {name}" for name, count in commands.items())
    if demands := summary.get("demands"):
        held = f"held for up to {_format_number(demands['longest_hold'])} s"
        yield "setpoints", f"{demands['received']} received, {demands['late']} late, {held}"
    for key, title in _COMPUTE_TIMES.items():
        if key in summary:
            yield (
                title,
                ", ".join(f"{name} {value:.0f}" for name, value in summary[key].items()) + " µs",
            )
    if summary.get("recording"):
        yield "recorded", f"{summary['recorded_steps']} steps, {summary['lost_steps']} lost"
    if restarts := summary.get("restarts"):
        yield "replaced", ", ".join(f"{name} {count} x" for name, count in restarts.items())


def _print_joints(console: Console, summary: dict[str, Any], scene: "Scene") -> None:
    margins, times, peaks = (
        summary.get(name, {}) for name in ("limit_margin", "settling_time", "peak_effort")
    )
    names = [name for name in scene.joint_names if name in margins or name in peaks]
    if not names:
        return
    limits = ["limit margin"] * bool(margins)
    head = ("joint", "final error", "joint settled after [s]", "peak effort", *limits)
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    effort_units = dict(zip(scene.actuated, scene.effort_units, strict=True))
    rows = [
        (
            name,
            _format_with_unit(summary.get("final_error", {}).get(name), units[name]),
            "not settled" if times.get(name, 0.0) is None else _format_number(times.get(name)),
            _format_with_unit(peaks.get(name), effort_units.get(name, "")),
            *[_format_with_unit(margins.get(name), units[name])] * bool(margins),
        )
        for name in names
    ]
    print_table(console, "", head, rows)


def _format_with_unit(value: Any, unit: str) -> str:
    return "-" if value is None else f"{_format_number(value)} {unit}"


def _format_number(value: Any) -> str:
    """Return a number in four digits; below `_ZERO_TOLERANCE` it is zero without a sign."""
    value = _python_number(value)
    if isinstance(value, float):
        return f"{0.0 if abs(value) < _ZERO_TOLERANCE else value:.4g}"
    return "-" if value is None else str(value)


def _first_sentence(text: str) -> str:
    return re.split(r"(?<=[.!?])\s", " ".join(text.split()), maxsplit=1)[0]


def print_scenes(descriptions: dict[str, str]) -> None:
    """Print scene names and the first sentences of their descriptions, a line each."""
    width, console = max(map(len, descriptions), default=0), Console()
    for name, description in descriptions.items():
        print_line(console, f"{name:<{width}}  {_first_sentence(description)}")
