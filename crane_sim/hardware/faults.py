"""Faults: which are active, by schedule or override, and their effects on sensors and drives."""

from typing import Any, NamedTuple

from crane_sim.hardware.brakes import engage
from crane_sim.numerics.jit import routine

KINDS = ("sensor_stuck", "sensor_loss", "effort_loss", "stuck", "payload")
"""Names of the kinds of faults; compiled functions take their indices."""
SENSOR_STUCK, SENSOR_LOSS, EFFORT_LOSS, JOINT_STUCK, PAYLOAD = range(5)
SCHEDULED = -1.0
"""Override that leaves a fault to its schedule; others are 0, off, and 1, on."""


class Faults(NamedTuple):
    """The faults that a scene may have (n,)."""

    kind: Any  # index in KINDS
    joint: Any  # index of the joint, of the actuated joint for faults of drives
    value: Any  # factor of the effort, mass of the payload [kg]
    begin: Any  # s; infinite: only by override
    end: Any  # s


class FaultLog(NamedTuple):
    """Log of activated and cleared faults."""

    rows: Any  # (capacity, 3): s, number of the fault, 1 on or 0 off
    total: Any  # (1,), how many there were


@routine
def update_active(faults, overrides, active, log, t, slack):
    """Fill `active` (n,) with 1 for faults active at time t [s], else 0, and log the changes.

    A fault is active in every period that begins at or after its time; `slack` [s] is the tolerance
    for rounding of t.
    """
    for i in range(len(active)):
        scheduled = faults.begin[i] <= t + slack < faults.end[i]
        value = overrides[i] if overrides[i] != SCHEDULED else 1.0 if scheduled else 0.0
        if value != active[i]:
            n = int(log.total[0])
            if n < len(log.rows):
                log.rows[n, 0], log.rows[n, 1], log.rows[n, 2] = t, i, value
            log.total[0] += 1.0
            active[i] = value


@routine
def apply_to_sensors(faults, active, sensors):
    """Apply the active faults to the sensors."""
    nq = len(sensors) // 2
    for j in range(2 * nq):
        sensors[j].stuck, sensors[j].lost = False, False
    for i in range(len(active)):
        if active[i] > 0.0 and faults.kind[i] <= SENSOR_LOSS:
            joint = int(faults.joint[i])
            for j in (joint, joint + nq):
                if faults.kind[i] == SENSOR_STUCK:
                    sensors[j].stuck = True
                else:
                    sensors[j].lost = True


@routine
def apply_to_drives(faults, active, drives, braking):
    """Apply the active faults to the drives; engage all brakes if `braking`.

    The drives' records have their positions.

    A drive whose limit switch has tripped is off, and its brake engaged. Losses of effort at one
    joint multiply.

    Returns:
        whether that changes a drive or a brake
    """
    changed = False
    for j in range(len(drives)):
        drive, engaged, factor = drives[j], braking or drives[j].tripped, 1.0
        for i in range(len(active)):
            if active[i] > 0.0 and faults.joint[i] == j:
                factor *= faults.value[i] if faults.kind[i] == EFFORT_LOSS else 1.0
                engaged = engaged or faults.kind[i] == JOINT_STUCK
        if engaged and not drive.engaged:
            engage(drive, drive.delivered_effort)
        changed = changed or engaged != drive.engaged or factor != drive.effort_fraction
        drive.engaged, drive.effort_fraction = engaged, factor
    return changed


@routine
def compute_payload_mass(faults, active, mass):
    """Return the payload's mass [kg] by its last active fault; `mass` if it has none."""
    for i in range(len(active)):
        if active[i] > 0.0 and faults.kind[i] == PAYLOAD:
            mass = faults.value[i]
    return mass
