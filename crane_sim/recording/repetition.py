"""Repetition of a run in real time from its recorded commands: a fresh plant passes through the same states.

A recording has the command that each period took (`plots/effort_demanded`, on the graph `held_command`), and NaN where
the brakes acted, whose command is zero, or that before them of a drive by position.
"""

from collections.abc import Sequence
from math import isnan

from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant


def repeat(scene: Scene, commands: Sequence[Sequence[float]]) -> Plant:
    """Return a plant at the end of a run of these commands (K, nu), one a period.

    Args:
        scene: that of the recording; its own law and inputs do not count.
        commands: as recorded.

    Raises:
        SimulationError: as in the run, which then ended there.
    """
    plant, last = Plant(scene.with_external_commands()), scene.idle_command
    for command in commands:
        plant.braking = all(map(isnan, command))
        last = last if plant.braking else tuple(map(float, command))
        plant.advance(_braked(scene, last) if plant.braking else last)
    return plant


def _braked(scene: Scene, last: Sequence[float]) -> tuple[float, ...]:
    """Return the command (nu,) of a period in which the brakes act, after the last command without them."""
    return tuple(x if kind == "position" else 0.0 for kind, x in zip(scene.commands, last, strict=True))
