"""The options of every command that takes a scene, and the scene that they give."""

from collections.abc import Callable
from typing import Any

import click
import yaml

from crane_sim.files.document import UNREADABLE
from crane_sim.files.errors import SceneError, shorten

DEFAULT_SCENE = "knuckle_setpoint"
as_json_option = click.option("--json", "as_json", is_flag=True, help="One JSON object on stdout, logs on stderr.")
_SCENE_OPTIONS = (
    click.argument("scene", default=DEFAULT_SCENE),
    click.option("--duration", type=float, help="Simulated seconds; the scene's own when left out."),
    click.option("--law", help="Another control law, without the settings of the scene's own."),
    click.option("--seed", type=int, help="Seed of everything random."),
    click.option("--set", "settings", multiple=True, metavar="GROUP.KEY=VALUE", help="Override a value of the scene."),
    as_json_option,
)


def scene_options(command: Callable[..., None]) -> Callable[..., None]:
    """Give a command the options of a scene."""
    for option in reversed(_SCENE_OPTIONS):
        command = option(command)
    return command


def loaded_scene(
    scene: str,
    duration: float | None = None,
    law: str | None = None,
    seed: int | None = None,
    settings: tuple[str, ...] = (),
) -> Any:
    """Return the scene with the options of the command line put in.

    Raises:
        SceneError: there is no such scene, or an option does not fit it.
    """
    from crane_sim.scenes.scene import load_scene

    named = {"duration": duration, "control.law": law, "seed": seed}
    options = {key: value for key, value in named.items() if value is not None}
    changes = _parse_settings(settings)
    for key in options:
        if key in changes:
            raise SceneError(f"--set {key}: --{key.removeprefix('control.')} says the same; leave out one of the two")
    return load_scene(scene, changes | options)


def _parse_settings(settings: tuple[str, ...]) -> dict[str, Any]:
    changes: dict[str, Any] = {}
    for setting in settings:
        key, equals, value = setting.partition("=")
        if not (key and equals):
            raise SceneError(f"--set {shorten(setting)}: must be GROUP.KEY=VALUE")
        try:
            changes[key] = yaml.safe_load(value)
        except UNREADABLE:
            raise SceneError(f"--set {shorten(setting)}: {shorten(value)} is not a value") from None
    return changes
