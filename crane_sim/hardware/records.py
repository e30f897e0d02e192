"""State and parameters of a run's hardware as structured arrays, a record per drive and sensor.

Compiled functions take an array, or one of its records as an object with these attributes, and
change them in place.
"""

from typing import Any

import numpy as np

DRIVE = np.dtype(
    [
        # brake
        ("stiffness", float),  # of its spring, in units of the effort / joint's
        ("damping", float),
        ("capacity", float),  # largest effort of spring and damper together
        ("anchor", float),  # m or rad, reference that the spring pulls to
        ("position_drive", float),  # 1 for a drive whose effort is a position setpoint, else 0
        ("engaged", np.bool_),
        # limit switches
        ("switch_low", float),  # m or rad
        ("switch_high", float),
        ("tripped", np.bool_),
        ("overtravel", float),  # m or rad, largest distance beyond a switch
        # drive
        ("low", float),  # limits of the effort
        ("high", float),
        ("rate_limit", float),  # of the effort [1/s]
        ("lag", float),  # s
        ("peak", float),  # largest effort of the motor below its base speed
        ("base_speed", float),  # of the joint [1/s]: from there on the largest effort falls
        ("no_load_speed", float),  # of the joint [1/s]: there it is 0
        ("deadband", float),  # commands below it count as 0
        ("delay", np.int64),  # periods
        ("has_state", np.bool_),  # a lag, a rate limit or a servo's loops
        ("initial_demand", float),  # before t = 0; not a number: what holds the joint there
        ("start_effort", float),  # at the start of the period, of lag and rate limit
        (
            "delivered_effort",
            float,
        ),  # at the end of the last period, on the joint: what a brake takes over
        ("target", float),  # effort that is approached
        (
            "effort_fraction",
            float,
        ),  # of the effort, acts on the joint: below 1 by a fault (`effort_loss`)
        # at the last evaluation
        ("effort", float),
        ("position", float),
        ("velocity", float),
    ]
)
"""A drive and its brake."""
SERVO = np.dtype(
    [
        ("kind", np.int64),  # index in `servos.COMMANDS`
        # speed loop
        ("gain", float),  # effort for a deviation of the speed
        ("stiffness", float),  # gain over integral time: effort for a deviation of the position
        ("position_gain", float),  # 1/s, speed for a deviation of the position
        (
            "ideal",
            np.bool_,
        ),  # the gain is infinite: the effort makes the joint follow its reference
        (
            "offset",
            float,
        ),  # m or rad, between reference and spring's end at the start of the period
        ("correction", float),  # m/s or rad/s, of the position loop in this period
        ("integral", float),  # effort of the integral at the start of the period
        ("begin", float),  # s, of the period
        ("restarts", np.bool_),  # the reference begins anew with the joint's motion
        # reference generator
        ("max_speed", float),
        ("max_acceleration", float),
        ("max_jerk", float),
        ("command", float),  # that the plan is for
        ("plan_begin", float),  # s
        ("plan_position", float),  # of the reference at the plan's beginning
        # present phase of the reference
        ("phase_begin", float),  # s
        ("phase_end", float),
        ("phase_position", float),
        ("phase_velocity", float),
        ("phase_acceleration", float),
        ("phase_jerk", float),
    ]
)
"""The reference generator and the loops of a servo drive."""
SENSOR = np.dtype(
    [
        ("noise", float),  # standard deviation
        ("bias", float),
        ("quantum", float),  # step of the digits, 0 without
        ("delay", np.int64),  # periods
        ("every", np.int64),  # periods from one sample to the next
        ("dropout", float),  # probability that a sample is lost
        ("truth", float),  # true joint's position or velocity
        ("sample", float),  # last one
        ("reading", float),  # measured value, for the law and the topics
        ("stuck", np.bool_),  # a fault: the last value is held
        ("lost", np.bool_),  # a fault: the value is zero
    ]
)
"""The sensor of one joint's position or velocity."""
TOTALS = np.dtype(
    [
        ("braking", np.bool_),  # all brakes are to be engaged in the periods that follow
        ("braked", np.int64),  # periods in which they were engaged
        ("saturated", np.int64),  # periods in which a command was limited
        ("lost_samples", np.int64),
        ("payload_mass", float),  # kg, at present; 0 in scenes without faults of the payload
        ("payload_energy", float),  # J, brought by changes of the payload
    ]
)
"""Totals of a run, and the two states that belong to no drive or sensor: engaged brakes and the
payload's mass."""


def make_records(kind: Any, count: int) -> Any:
    """Return records of DRIVE, SERVO, SENSOR or TOTALS (count,), all fields 0."""
    return np.zeros(count, kind).view(np.recarray)


def ideal_drives(nu: int) -> Any:
    """Return records of drives without any effect (nu,)."""
    drives = make_records(DRIVE, nu)
    drives.effort_fraction, drives.rate_limit, drives.low, drives.high = (
        1.0,
        np.inf,
        -np.inf,
        np.inf,
    )
    drives.switch_low, drives.switch_high = -np.inf, np.inf
    drives.peak, drives.no_load_speed, drives.initial_demand = np.inf, np.inf, np.nan
    return drives


def effort_servos(nu: int) -> Any:
    """Return records of servo drives (nu,), none of which is one: all are commanded efforts."""
    servos = make_records(SERVO, nu)
    servos.max_speed, servos.max_acceleration, servos.max_jerk = np.inf, np.inf, np.inf
    return servos


def ideal_sensors(nq: int) -> Any:
    """Return records of sensors that measure the truth: positions, then velocities (2 nq,)."""
    sensors = make_records(SENSOR, 2 * nq)
    sensors.every = 1
    return sensors
