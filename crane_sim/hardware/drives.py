"""Actuators: the effort that a drive applies to its joint for a command, within the equations.

A demand is delayed, passes a dead band, is limited, and is then followed by u' = (demand - u) /
lag, within the rate limit. A demand that is held for a period gives that equation a solution in
closed form: a ramp while the rate limit binds, then an exponential. The effort is that function of
time, not a staircase. A motor's largest effort is a function of its joint's speed on top: a line
from its base speed to the one at no load, in all four quadrants.

Commands are held. Open-loop inputs are read at every evaluation of the equations, but for drives
with a state of their own (a lag, a rate limit, a servo's loops), whose demand is their value at the
start of the period.
"""

from math import exp, inf
from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.hardware.brakes import clip, compute_brake_effort
from crane_sim.hardware.ideal_servos import solve_efforts
from crane_sim.hardware.servos import demanded_effort, enter_phases, latch_servos, plan_references
from crane_sim.numerics.jit import routine


class Drives(NamedTuple):
    """The source of a period: drives that approach their commands, and brakes."""

    begin: float  # s, of the period
    records: Any  # DRIVE (nu,)
    servos: Any  # `servos.Servos`, None where all drives are commanded efforts
    inputs: Any  # open-loop source of demands; None where all are held


def ramp_time(distance, rate, lag):
    """Return how long [s] the rate limit binds a drive whose command is `distance` away."""
    return max(0.0, distance / rate - lag)


def effort_at(drive, s):
    """Return the effort of a drive, s seconds after the start of the period."""
    start, target, rate, lag = drive.start_effort, drive.target, drive.rate_limit, drive.lag
    change = target - start
    distance, direction = abs(change), 1.0 if change >= 0.0 else -1.0
    ramp = ramp_time(distance, rate, lag)
    if s < ramp:
        return start + direction * rate * s
    if lag == 0.0:
        return target
    remaining = distance if ramp == 0.0 else rate * lag
    return target - direction * remaining * exp(-(s - ramp) / lag)


def set_target(drive, demand):
    """Set the effort that a drive approaches for a demand.

    It is zero within the dead band, and within the drive's limits.
    """
    drive.effort = 0.0 if abs(demand) < drive.deadband else demand
    drive.target = min(max(drive.effort, drive.low), drive.high)


def holds_demand(inputs, drive):
    """Return whether a drive's demand is held for a period.

    Open-loop inputs are held only by a drive with a state of its own.
    """
    return inputs is None or drive.has_state


def read_inputs(inputs, p, drives, t, x):
    """Set the targets of drives that hold no demand, by the inputs at time t [s] and state x."""
    if inputs is None:
        return
    drives.effort[:] = system.demand(inputs, p, t, x)  # limits act, and are counted, behind it
    for i in range(len(drives)):
        if not drives[i].has_state:
            set_target(drives[i], drives[i].effort)


def change_with_period(inputs, drives):
    """Return whether efforts may change at a period's end.

    They may of drives that hold a demand, and of brakes.
    """
    if inputs is None:
        return True
    for i in range(len(drives)):
        if drives[i].has_state or drives[i].engaged:
            return True
    return False


def motor_effort(drive, effort):
    """Return the effort that a motor gives at its joint's speed.

    The largest effort falls linearly to 0 at the no-load speed.
    """
    if drive.peak == inf:
        return effort
    fall = (drive.no_load_speed - abs(drive.velocity)) / (drive.no_load_speed - drive.base_speed)
    return clip(effort, drive.peak * clip(max(0.0, fall), 1.0))


@system.effort.register(Drives)
@routine
def drive_efforts(u, p, t, x):
    """Return the efforts (nu,) of drives and brakes in state x at time t [s]."""
    drives = u.records
    q, v = system.actuated_joints(p, x)
    drives.position[:] = q
    drives.velocity[:] = v
    read_inputs(u.inputs, p, drives, t, x)
    for i in range(len(drives)):
        drive = drives[i]
        approached = (
            effort_at(drive, t - u.begin) if holds_demand(u.inputs, drive) else drive.target
        )
        demanded = demanded_effort(u.servos, drive, i, t, approached)
        effort = motor_effort(drive, drive.effort_fraction * demanded)
        drive.effort = compute_brake_effort(drive) if drive.engaged else effort
    if u.servos is not None and u.servos.ideal is not None:
        solve_efforts(u.servos.ideal, u.servos.loops, drives, p, t, x)
    return system.saturate(p, system.efforts_from_row(p, drives.effort))


@routine
def accept_command(p, u, x, queue, k, command):
    """Set the command (nu,) of period k in state x at its start; return whether it was limited.

    The queue (depth, nu) holds the commands before the first one as well.
    """
    drives = u.records
    depth = len(queue)
    queue[k % depth] = command
    read_inputs(u.inputs, p, drives, u.begin, x)
    for i in range(len(drives)):
        if holds_demand(u.inputs, drives[i]):
            set_target(drives[i], queue[(k - drives[i].delay) % depth, i])
    drives.target[:] = system.saturate(p, system.efforts_from_row(p, drives.target))
    saturated = u.servos is not None and plan_references(u.servos, drives, p, u.begin, x, k == 0)
    for i in range(len(drives)):
        drive = drives[i]
        saturated = saturated or drive.target != drive.effort
        if k == 0:
            drive.delivered_effort = demanded_effort(
                u.servos, drive, i, u.begin, effort_at(drive, 0.0)
            )
    return saturated


def next_breakpoint(u, t, end):
    """Return the first time after t [s] at which a rate limit stops binding, at most `end`."""
    least = 1e-9 * (end - u.begin)  # s: a breakpoint closer to either end is rounding, and ignored
    for i in range(len(u.records)):
        drive = u.records[i]
        break_time = u.begin + ramp_time(
            abs(drive.target - drive.start_effort), drive.rate_limit, drive.lag
        )
        if not drive.engaged and t + least < break_time < end - least:
            end = break_time
    return enter_phases(u.servos, t, end, least)


@routine
def latch_efforts(p, u, t, x):
    """Store the drives' efforts at the end of a period, at time t [s] in state x.

    The next period begins with them.
    """
    u.records.effort[:] = system.effort(u, p, t, x)
    for i in range(len(u.records)):
        drive = u.records[i]
        drive.delivered_effort = drive.effort
        drive.start_effort = drive.effort if drive.engaged else effort_at(drive, t - u.begin)
    latch_servos(u.servos, u.records, t)
