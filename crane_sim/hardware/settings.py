"""What a scene says of its hardware, in numbers."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.hardware.drives import DRIVE_ROWS, NEUTRAL
from crane_sim.hardware.faults import JOINT_STUCK, Faults
from crane_sim.hardware.payloads import PayloadFault
from crane_sim.hardware.sensors import EVERY, SENSOR_ROWS


class BrakeSettings(NamedTuple):
    """The brakes of a scene; what is None is computed from the crane (`brake_defaults`)."""

    capacity: tuple[float, ...] | None = None  # (nu,), in the units of the efforts
    frequency: float | None = None  # rad/s, of a joint on its brake's spring
    damping: float = 0.7  # of the critical one


class Equipment(NamedTuple):
    """Hardware of a scene; the boards of drives and sensors are copied for every run."""

    drives: Any  # (DRIVE_ROWS, nu)
    signals: Any  # (SENSOR_ROWS, 2 nq)
    faults: Faults
    names: tuple[str, ...] = ()  # of the faults
    reload: PayloadFault | None = None
    brake: BrakeSettings = BrakeSettings()
    ideal: bool = True  # nothing but brakes, which nobody feels until they are applied

    @property
    def can_stick(self) -> bool:
        """Whether a fault applies a brake."""
        return JOINT_STUCK in self.faults.kind


def drive_board(nu: int) -> Any:
    """Return the board of drives without any effect (DRIVE_ROWS, nu)."""
    board = np.zeros((DRIVE_ROWS, nu))
    for row, value in NEUTRAL.items():
        board[row] = value
    return board


def sensor_board(nq: int) -> Any:
    """Return the board of perfect sensors (SENSOR_ROWS, 2 nq)."""
    board = np.zeros((SENSOR_ROWS, 2 * nq))
    board[EVERY] = 1.0
    return board


def no_equipment(nq: int, nu: int) -> Equipment:
    """Return the equipment of a crane whose drives and sensors are perfect and which has brakes."""
    nothing = np.empty(0)
    return Equipment(drive_board(nu), sensor_board(nq), Faults(nothing, nothing, nothing, nothing, nothing))
