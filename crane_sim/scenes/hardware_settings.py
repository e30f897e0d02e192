"""The hardware of a scene in numbers, checked against its joints."""

from collections.abc import Sequence
from math import inf, nan
from typing import Any

import numpy as np

from crane_sim.files.errors import SceneError, unknown_key
from crane_sim.hardware.faults import KINDS, Faults
from crane_sim.hardware.payloads import PayloadFault
from crane_sim.hardware.records import ideal_drives, ideal_sensors
from crane_sim.hardware.servos import COMMANDS
from crane_sim.hardware.settings import BrakeSettings, HardwareConfig
from crane_sim.scenes.schema.hardware import (
    ALL,
    FAULTS,
    MAX_PERIODS,
    ActuatorGroup,
    BrakeGroup,
    EffortLoss,
    PayloadChange,
    SensorGroup,
    group_name,
    merge_groups,
)
from crane_sim.scenes.schema.motors import motor_of
from crane_sim.scenes.schema.scene_file import SceneFile
from crane_sim.scenes.servo_settings import servos_of

CLOSE = 1e-6  # of a period: smaller deviations are rounding errors


class Periods:
    """Turns seconds into whole control periods.

    Attributes:
        rounded: lines on times that were not a whole number of them.
    """

    def __init__(self, period: float) -> None:
        """Take the period [s]."""
        self._period = period
        self.rounded: list[str] = []

    def of(self, what: str, seconds: float, least: int = 0) -> int:
        """Return the periods in a time [s], at least `least`; `what` names the key in messages.

        Raises:
            SceneError: there are too many.
        """
        exact = seconds / self._period
        if exact > MAX_PERIODS:
            raise SceneError(
                f"{what}: {seconds:g} s is more than {MAX_PERIODS} periods of {self._period:g} s"
            )
        periods = max(least, round(exact))
        if abs(periods - exact) > CLOSE:
            line = f"{what}: {seconds:g} s is taken as {periods * self._period:g} s"
            self.rounded += [line] if line not in self.rounded else []
        return periods


def equipment_of(file: SceneFile, period: float) -> tuple[HardwareConfig | None, dict[str, Any]]:
    """Return (the hardware of a scene with this control period [s] or None, notes on it).

    Raises:
        SceneError: a joint is unknown, or a group does not fit the crane.
    """
    ideal = not (file.sensors or file.actuators or file.faults)
    if ideal and file.brake in (None, BrakeGroup()):
        return None, {}
    _refuse_continuous_law(file)
    _check_joints("sensors", file.sensors, (ALL, *file.joint_names))
    _check_joints("actuators", file.actuators, (ALL, *file.actuated))
    periods = Periods(period)
    changes = any(isinstance(fault, PayloadChange) for fault in file.faults.values())
    if changes and getattr(file, "events", ()):
        raise SceneError(
            "faults: a payload's change and events: both set the payload's mass; take one of them"
        )
    equipment = HardwareConfig(
        drives=_drives(file, periods),
        sensors=_sensors(file, periods),
        faults=_faults(file),
        names=tuple(file.faults),
        payload_fault=PayloadFault(file.payload_mass) if changes else None,
        brake=_brakes(file),
        servos=servos_of(file),
        ideal=ideal,
    )
    rounded = {"rounded": periods.rounded} if periods.rounded else {}
    held = list(stateful_joints(equipment, file.actuated)) if _has_inputs(file) else []
    return equipment, rounded | ({"held_inputs": held} if held else {})


def _refuse_continuous_law(file: SceneFile) -> None:
    """Raise SceneError for groups that act once a period where the law is continuous."""
    groups = [name for name in ("sensors", "actuators", "faults") if getattr(file, name)]
    if groups and file.control is not None and file.control.period == "continuous":
        raise SceneError(
            f"{groups[0]}: act once a period, and control.period is 'continuous'; give it a number "
            "of seconds"
        )


def _has_inputs(file: SceneFile) -> bool:
    return getattr(file, "inputs", None) is not None


def is_nonideal(equipment: HardwareConfig | None) -> bool:
    """Return whether groups between law and crane may change efforts or measurements."""
    return equipment is not None and not equipment.ideal


def varies_within_period(equipment: HardwareConfig | None, duration: float) -> bool:
    """Return whether held commands give efforts that change within a period of a run.

    The run has that duration [s].
    """
    if equipment is None:
        return False
    drives = equipment.drives
    return bool(drives.has_state.any() or np.isfinite(drives.peak).any()) or equipment.may_brake(
        duration
    )


def stateful_joints(equipment: HardwareConfig | None, actuated: Sequence[str]) -> tuple[str, ...]:
    """Return the actuated joints whose drives have a state: lag, rate limit or servo loops."""
    states = () if equipment is None else zip(actuated, equipment.drives.has_state, strict=True)
    return tuple(joint for joint, has_state in states if has_state)


def commands_of(equipment: HardwareConfig | None, nu: int) -> tuple[str, ...]:
    """Return the commands of the drives of actuated joints (nu,): effort, velocity or position."""
    servos = equipment.servos if equipment is not None else None
    return ("effort",) * nu if servos is None else tuple(COMMANDS[kind] for kind in servos.kind)


def _check_joints(group: str, groups: dict[str, Any], known: tuple[str, ...]) -> None:
    for name in groups:
        if name not in known:
            raise SceneError(f"{group}: {unknown_key(name, known, 'joint')}")


def _drives(file: SceneFile, periods: Periods) -> Any:
    drives = ideal_drives(len(file.actuated))
    for drive, joint in zip(drives, file.actuated, strict=True):
        group = merge_groups(file.actuators, joint, ActuatorGroup)
        drive.low, drive.high = group.limit or (-inf, inf)
        drive.rate_limit = group.rate_limit or inf
        drive.lag, drive.deadband = group.lag, group.deadband
        drive.has_state = group.drive != "effort" or group.lag > 0.0 or group.rate_limit is not None
        drive.initial_demand = nan if group.initial_demand is None else group.initial_demand
        drive.switch_low, drive.switch_high = _limit_switches(file, joint, group)
        motor = motor_of(file, joint)
        if motor is not None:
            drive.peak, drive.base_speed = (
                motor.ratio * motor.torque,
                motor.base_speed / motor.ratio,
            )
            drive.no_load_speed = motor.no_load_speed / motor.ratio
        drive.delay = periods.of(
            f"actuators.{group_name(file.actuators, joint, 'delay')}.delay", group.delay
        )
    return drives


def _limit_switches(file: SceneFile, joint: str, group: ActuatorGroup) -> tuple[float, float]:
    """Return a joint's limit switches, infinite without; SceneError where one is of no use."""
    if group.limit_switches is None:
        return -inf, inf
    (low, high), start = group.limit_switches, file.initial_q[file.joint_names.index(joint)]
    key = (
        f"actuators.{group_name(file.actuators, joint, 'limit_switches')}.limit_switches = "
        f"{[low, high]}"
    )
    if not low <= start <= high:
        raise SceneError(f"{key}: the {joint} starts outside of them, at {start:g}")
    for limit in file.limits:
        if limit.joint == joint and not (limit.low < low and high < limit.high):
            raise SceneError(
                f"{key}: must be within {limit.key} = {[limit.low, limit.high]}, where the run ends"
            )
    return low, high


def _sensors(file: SceneFile, periods: Periods) -> Any:
    nq = len(file.joint_names)
    sensors = ideal_sensors(nq)
    for j, joint in enumerate(file.joint_names):
        group = merge_groups(file.sensors, joint, SensorGroup)
        both = [j, j + nq]
        sensors.noise[both], sensors.bias[both], sensors.quantum[both] = (
            group.noise,
            group.bias,
            group.quantisation,
        )
        sensors.delay[both] = periods.of(
            f"sensors.{group_name(file.sensors, joint, 'delay')}.delay", group.delay
        )
        sensors.dropout[both] = group.dropout
        if group.rate is not None:
            name = f"sensors.{group_name(file.sensors, joint, 'rate')}.rate"
            sensors.every[both] = periods.of(name, 1.0 / group.rate, least=1)
    return sensors


def _faults(file: SceneFile) -> Faults:
    rows = [_fault(file, name, fault) for name, fault in file.faults.items()]
    return Faults(*np.array(rows, dtype=float).reshape(-1, 5).T.copy())


def _fault(file: SceneFile, name: str, fault: Any) -> tuple[float, float, float, float, float]:
    """Return (kind, index, value, begin, end) of a fault."""
    kind = list(FAULTS.values()).index(type(fault))
    times = inf if fault.at is None else fault.at, inf if fault.until is None else fault.until
    if isinstance(fault, PayloadChange):
        return kind, -1.0, fault.mass, *times
    known = file.joint_names if KINDS[kind].startswith("sensor") else file.actuated
    if fault.joint not in known:
        raise SceneError(f"faults.{name}.joint: {unknown_key(fault.joint, known, 'joint')}")
    index = known.index(fault.joint)
    if not isinstance(fault, EffortLoss):
        return kind, index, 0.0, *times
    if file.effort_units[index] == "m":
        raise SceneError(
            f"faults.{name}: the effort of {fault.joint} is a position, of which no part can be "
            "lost"
        )
    return kind, index, fault.factor, *times


def _brakes(file: SceneFile) -> BrakeSettings:
    group, nu = file.brake or BrakeGroup(), len(file.actuated)
    if group.capacity is not None and len(group.capacity) != nu:
        joints = ", ".join(file.actuated)
        raise SceneError(
            f"brake.capacity: has {len(group.capacity)} values, the actuated joints are {joints}"
        )
    return BrakeSettings(group.capacity, group.frequency, group.damping)
