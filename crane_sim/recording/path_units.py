"""Unit of the coordinates of a scene's path, in which its tracking errors are."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from collections.abc import Sequence

    from crane_sim.scenes.scene import Scene


def path_unit(of_joints: bool, joint_units: Sequence[str]) -> str:
    """Return the unit of a path: m for the payload, else the joints', empty if they differ."""
    units = set(joint_units) if of_joints else {"m"}
    return units.pop() if len(units) == 1 else ""


def path_unit_of_scene(scene: Scene) -> str:
    """Return the unit of a scene's path, m without one."""
    units = dict(zip(scene.joint_names, scene.joint_units, strict=True))
    of_joints = scene.trajectory is not None and scene.trajectory.of_joints
    return path_unit(of_joints, [units[name] for name in scene.actuated])
