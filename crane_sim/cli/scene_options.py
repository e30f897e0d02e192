"""The options of every command that takes a scene, and loading of that scene."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import click

from crane_sim.cli.report import compiling
from crane_sim.files.document import function_from
from crane_sim.files.errors import SceneError, shorten
from crane_sim.files.yaml_text import YAML_ERRORS, parse_yaml

DEFAULT_SCENE = "knuckle_setpoint"
as_json_option = click.option(
    "--json", "as_json", is_flag=True, help="One JSON object on stdout, logs on stderr."
)
_CHANGES = (
    click.option("--duration", type=float, help="Simulated seconds (default: the scene's)."),
    click.option(
        "--law",
        help="Another law, a name or FILE.py:FUNCTION; the settings of the scene's own are "
        "dropped.",
    ),
    click.option("--seed", type=int, help="Seed of all random numbers."),
    click.option(
        "--set",
        "settings",
        multiple=True,
        metavar="GROUP.KEY=VALUE",
        help="Override a value of the scene.",
    ),
)


def scene_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add a scene, the options that change it, and --json to a command."""
    return click.argument("scene", default=DEFAULT_SCENE)(change_options(as_json_option(command)))


def change_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add options that change a scene to a command: the arguments of `load_scene_with_options`."""
    for option in reversed(_CHANGES):
        command = option(command)
    return command


def load_scene_with_options(
    scene: str,
    duration: float | None = None,
    law: str | None = None,
    seed: int | None = None,
    settings: tuple[str, ...] = (),
) -> Any:
    """Return the scene with the overrides of the command line.

    Raises:
        SceneError: there is no such scene, or an option does not fit it.
    """
    from crane_sim.scenes.scene import load_scene

    own = None if law is None else function_from(law, Path.cwd())
    option_values = {"duration": duration, "control.law": own, "seed": seed}
    options = {key: value for key, value in option_values.items() if value is not None}
    changes = _parse_settings(settings)
    for key in options:
        if key in changes:
            raise SceneError(
                f"--set {key}: --{key.removeprefix('control.')} sets the same key; leave out one "
                "of the two"
            )
    with compiling(quiet=True):  # the design of a law
        return load_scene(scene, changes | options)


def compile_scene(scene: Any, braking: bool) -> None:
    """Compile a scene once, before several nodes do so in parallel; `braking`: its brakes, too."""
    from crane_sim.ros.plant.warm_up import warm_up
    from crane_sim.simulation.plant import Plant

    warm_up(Plant(scene), braking)
    if scene.law is not None:
        scene.law(0.0, scene.initial_q, scene.initial_v)


def _parse_settings(settings: tuple[str, ...]) -> dict[str, Any]:
    changes: dict[str, Any] = {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not (key and equals):
            raise SceneError(f"--set {shorten(setting)}: must be GROUP.KEY=VALUE")
        try:
            changes[key] = parse_yaml(value)
        except YAML_ERRORS:
            raise SceneError(f"--set {shorten(setting)}: {shorten(value)} is not a value") from None
    return changes
