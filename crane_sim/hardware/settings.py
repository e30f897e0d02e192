"""Hardware configuration of a scene, in numbers."""

from typing import Any, NamedTuple

import numpy as np

from crane_sim.hardware.faults import JOINT_STUCK, Faults
from crane_sim.hardware.payloads import PayloadFault
from crane_sim.hardware.records import ideal_drives, ideal_sensors


class BrakeSettings(NamedTuple):
    """The brakes of a scene; None is computed from the crane (`crane_sim.simulation.hardware`)."""

    capacity: tuple[float, ...] | None = None  # (nu,), in the units of the efforts
    frequency: float | None = None  # rad/s, of a joint on its brake's spring
    damping: float = 0.7  # of the critical one


class HardwareConfig(NamedTuple):
    """Hardware configuration of a scene; every run copies the records of drives and sensors."""

    drives: Any  # records of DRIVE (nu,)
    sensors: Any  # records of SENSOR (2 nq,)
    faults: Faults
    names: tuple[str, ...] = ()  # of the faults
    payload_fault: PayloadFault | None = None
    brake: BrakeSettings = BrakeSettings()
    servos: Any = None  # records of SERVO (nu,), None where all drives are commanded efforts
    ideal: bool = True  # nothing but brakes, which do nothing until they are applied

    @property
    def can_stick(self) -> bool:
        """Whether a fault or a limit switch applies a brake."""
        return JOINT_STUCK in self.faults.kind or self.has_limit_switches

    @property
    def has_limit_switches(self) -> bool:
        """Whether a joint has limit switches."""
        return bool(np.isfinite([self.drives.switch_low, self.drives.switch_high]).any())

    def may_brake(self, end: float) -> bool:
        """Return whether a limit switch, or a fault before time `end` [s], applies a brake."""
        stuck = self.faults.kind == JOINT_STUCK
        return self.has_limit_switches or bool((self.faults.begin[stuck] < end).any())


def ideal_hardware(nq: int, nu: int) -> HardwareConfig:
    """Return the configuration of ideal drives and sensors, with brakes."""
    nothing = np.empty(0)
    return HardwareConfig(
        ideal_drives(nu), ideal_sensors(nq), Faults(nothing, nothing, nothing, nothing, nothing)
    )
