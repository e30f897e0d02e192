"""The command `crane drive`: an operator's hands on a crane, in real time over Fast DDS."""

import re
import sys
from collections.abc import Mapping, Sequence
from importlib.util import find_spec
from typing import Any

import click

from crane_sim import process_signals
from crane_sim.cli import report
from crane_sim.cli.help_lines import HELP
from crane_sim.cli.operator_console import OperatorConsole, format_lever_note, make_lever_table
from crane_sim.cli.run_options import RunOptions, drive_options
from crane_sim.cli.scene_options import (
    DEFAULT_SCENE,
    as_json_option,
    compile_scene,
    load_scene_with_options,
)
from crane_sim.cli.tables import print_line
from crane_sim.files.errors import SceneError, shorten
from crane_sim.operator.drives import LAW_GROUPS, driven_joints, with_operator_drives
from crane_sim.operator.gamepad import MISSING
from crane_sim.operator.inputs import DEVICES
from crane_sim.operator.levers import Assignment, make_lever_assignment

DEFAULT_TOPIC = "/joy"
_TOPIC = re.compile(r"(~/|/)?[A-Za-z_]\w*(/[A-Za-z_]\w*)*", re.ASCII)  # the rule of ROS

_OPTIONS = (
    click.argument("scene", default=DEFAULT_SCENE),
    click.option(
        "--input",
        "device",
        default="keyboard",
        help=f"The device: {' | '.join(DEVICES)} (default keyboard).",
    ),
    click.option(
        "--gamepad",
        default="",
        metavar="FILE",
        help="Of --input gamepad: its device (default: the first).",
    ),
    click.option(
        "--joy-topic",
        metavar="TOPIC",
        help="Of --input joy: topic of sensor_msgs/Joy (default /joy).",
    ),
    click.option(
        "--map",
        "mapping",
        multiple=True,
        metavar="NAME=N",
        help="Axis N of a joint, -N inverted; a button.",
    ),
    click.option(
        "--speed",
        "speeds",
        multiple=True,
        metavar="JOINT=V",
        help="Largest speed of a joint, m/s or rad/s.",
    ),
    click.option("--assist", is_flag=True, help="Begin with the assistance against swing."),
    click.option(
        "--duration", type=float, help="Simulated seconds (default 3600, or until you end it)."
    ),
    click.option("--seed", type=int, help="Seed of all random numbers."),
    click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="GROUP.KEY=VALUE",
        help="Override a value of the scene.",
    ),
    as_json_option,
)


def drive_command(command: Any) -> Any:
    """Add the options of `crane drive` to a command."""
    for option in reversed(_OPTIONS):
        command = option(command)
    return command


@click.command(context_settings=HELP)
@drive_command
@drive_options
def drive(scene: str, as_json: bool, **given: Any) -> None:
    """Drive a crane by hand, in real time: by keyboard, gamepad or sensor_msgs/Joy."""
    from crane_sim import orchestration

    options = RunOptions.of_drive(
        {name: given.pop(name) for name in RunOptions._fields if name in given}
    )
    options.check()
    _check_device(given)
    _check_settings(given["settings"])
    loaded = load_scene_with_options(scene, seed=given["seed"], settings=given["settings"])
    arguments = options.arguments(loaded.name)
    speeds, assignment = (
        _parse_speeds(given["speeds"]),
        make_lever_assignment(loaded.actuated, given["mapping"]),
    )
    with report.compiling(quiet=as_json):
        ready = with_operator_drives(loaded, given["duration"], speeds)
        compile_scene(ready.with_external_commands(), braking=True)
    arguments["compile_time"] = report.compile_time()
    console = _open_console(ready, assignment, given, as_json)
    console.log(_describe_drives(loaded, ready))
    try:
        summary = orchestration.run(ready, operator=console, on_news=console.log, **arguments)
    finally:
        console.close()
    process_signals.exit_now(report.print_outcome(dict(ready.notes) | summary, ready, as_json))


def _check_settings(settings: Sequence[str]) -> None:
    """Raise SceneError for a setting that an operator's run leaves out."""
    for setting in settings:
        group = setting.partition("=")[0].partition(".")[0]
        if group in LAW_GROUPS:
            raise SceneError(
                f"--set {setting}: {group} is left out, since an operator commands the crane"
            )
        if group == "duration":
            raise SceneError(f"--set {setting}: the length of a run by hand is --duration")


def _check_device(given: Mapping[str, Any]) -> None:
    """Raise SceneError where the device is unknown, cannot be there, or does not fit an option."""
    device, topic = given["device"], given["joy_topic"]
    if device not in DEVICES:
        raise SceneError(f"--input = {device!r}: possible: {', '.join(DEVICES)}")
    if device == "keyboard" and not sys.stdin.isatty():
        raise SceneError(
            "--input keyboard: needs a terminal, and the input is none; possible: gamepad, joy"
        )
    if device == "gamepad" and find_spec("evdev") is None:
        raise SceneError(f"--input gamepad: {MISSING}")
    _check_owners(given)
    if topic is not None and not _TOPIC.fullmatch(topic):
        raise SceneError(
            f"--joy-topic {topic!r}: is no topic's name; possible: letters, digits, _ and /, such "
            "as /joy"
        )


def _check_owners(given: Mapping[str, Any]) -> None:
    """Raise SceneError for an option that belongs to another device."""
    device = given["device"]
    for option, value, owner in (
        ("--gamepad", given["gamepad"], "gamepad"),
        ("--joy-topic", given["joy_topic"], "joy"),
    ):
        if value and device != owner:
            raise SceneError(
                f"{option} {value}: belongs to --input {owner}, here is --input {device}"
            )
    if given["mapping"] and device == "keyboard":
        raise SceneError(
            f"--map {given['mapping'][0]}: belongs to --input gamepad or joy, here is --input "
            "keyboard"
        )


def _parse_speeds(speeds: Sequence[str]) -> dict[str, float]:
    parsed = {}
    for entry in speeds:
        joint, _, value = entry.partition("=")
        try:
            parsed[joint] = float(value)
        except ValueError:
            raise SceneError(f"--speed {shorten(entry)}: must be JOINT=NUMBER") from None
    return parsed


def _open_console(
    scene: Any, assignment: Assignment, given: dict[str, Any], as_json: bool
) -> OperatorConsole:
    """Print the table of levers; return the console, closed."""
    joints, device = driven_joints(scene), given["device"]
    parameters = {
        "device": device,
        "joy_topic": given["joy_topic"] or DEFAULT_TOPIC,
        "gamepad": given["gamepad"],
    }
    parameters |= {"mapping": ",".join(given["mapping"]), "assistance": given["assist"]}
    console = OperatorConsole(parameters, scene.name, joints, as_json)
    console.console.print(make_lever_table(joints, assignment, device))
    print_line(console.console, format_lever_note(assignment, device))
    return console


def _describe_drives(scene: Any, operated_scene: Any) -> str:
    """Return one line on the drives that the operator has in place of the scene's own."""
    kinds = zip(scene.actuated, scene.commands, operated_scene.commands, strict=True)
    changed = [joint for joint, before, after in kinds if before != after]
    return (
        f"drives by speed in place of the scene's own: {', '.join(changed) or 'none'} "
        "(docs/operator.md)"
    )
