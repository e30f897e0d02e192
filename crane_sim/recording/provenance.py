"""What the derived curves of a recording are computed from, where that is not the truth."""

from __future__ import annotations

from typing import TYPE_CHECKING

from crane_sim.hardware.equipment import sensor_board
from crane_sim.hardware.faults import SENSOR_LOSS

if TYPE_CHECKING:
    from crane_sim.hardware.equipment import Equipment
    from crane_sim.scene import Scene


def provenance(scene: Scene) -> str:
    """Return one phrase on what energies, tension and swing are computed from, empty where that is the truth.

    A recorder hears the joint states that everybody hears, and knows the scene's payload.
    """
    found = scene.hardware
    if found is None:
        return ""
    parts = ("from what the sensors show",) if _is_sensed(found, len(scene.joint_names)) else ()
    parts += ("for the payload of the start",) if found.reload is not None else ()
    return " and ".join(parts)


def _is_sensed(found: Equipment, nq: int) -> bool:
    """Return whether sensors show something else than the truth, or may come to do so."""
    return bool((found.signals != sensor_board(nq)).any() or (found.faults.kind <= SENSOR_LOSS).any())
