"""What a scene is, at the terminal: its crane, joints, law, integrator and notes."""

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.console import Console

from crane_sim.cli.report import print_notes
from crane_sim.cli.tables import print_table

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

_HEAD = ("joint", "unit", "start", "target", "travel", "command")


def print_scene(scene: "Scene") -> None:
    """Print a scene: what it is, a row per joint, what commands and integrates it, and notes."""
    console = Console()
    law = f"law {scene.law_name}" if scene.law_name else "open loop"
    groups = [key for key, value in scene.document.items() if isinstance(value, dict)]
    lines = [
        f"{scene.name}: {' '.join(scene.description.split())}",
        f"crane {scene.crane}, {scene.duration:g} s in {scene.steps} steps of "
        f"{scene.period:g} s, {law}",
        f"groups: {', '.join(groups)}",
        f"integrator: {scene.method}",
    ]
    for line in lines:
        console.print(line, highlight=False, markup=False, soft_wrap=True)
    print_table(console, "", _HEAD, _joint_rows(scene))
    print_notes(scene.notes, console)


def _joint_rows(scene: "Scene") -> Iterator[tuple[str, ...]]:
    """Yield the cells of each joint."""
    targets = dict(zip(scene.actuated, scene.reference or (), strict=False))
    units = dict(zip(scene.actuated, scene.command_units, strict=True))
    kinds = dict(zip(scene.actuated, scene.commands, strict=True))
    travels = {limit.joint: f"{limit.low:g} .. {limit.high:g}" for limit in scene.limits}
    for name, unit, start in zip(
        scene.joint_names, scene.joint_units, scene.initial_q, strict=True
    ):
        target = f"{targets[name]:.4g}" if name in targets else ""
        command = f"{kinds[name]} [{units[name]}]" if name in kinds else ""
        yield name, unit, f"{start:.4g}", target, travels.get(name, ""), command
