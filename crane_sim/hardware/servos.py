"""Servo drives: joints that follow a speed or a position, as frequency converters drive them.

A reference generator (`reference_profiles`) turns the command, held for a period, into a reference
x_r, v_r. The speed loop is a PI controller with gain K and integral time T:

    effort = K (v_r - v) + K/T integral of (v_r - v) dt = K (v_r - v) + K/T (x_r + c - x)

The integral of a speed is a position, so the loop is a damper and a spring to the moving reference
and has no state of its own within a period; the offset c holds the integral at the start of the
period. The effort is then limited as that of any drive. Anti-windup is clamping (Astrom and
Hagglund, Advanced PID Control, ISA 2006, section 3.5): where the effort is limited at the end of a
period, an integral that has grown in the direction of the limit is put back to that at the start of
the period.

A position loop adds the speed k_x (x_r - x), which it samples once a period, to v_r: a cascade.

With an infinite gain the effort is that which makes the joint's acceleration the reference's
(`ideal_servos`).
"""

from typing import Any, NamedTuple

from crane_sim import system
from crane_sim.hardware.brakes import clip
from crane_sim.hardware.reference_profiles import (
    PHASES,
    Bounds,
    phase_distance,
    plan_position,
    plan_velocity,
)
from crane_sim.numerics.jit import routine

COMMANDS = ("effort", "velocity", "position")
"""Kinds of drives by what they are commanded; compiled code takes their indices."""
EFFORT, VELOCITY, POSITION = range(3)


class Servos(NamedTuple):
    """Servo drives of a crane."""

    loops: Any  # records of SERVO (nu,)
    phases: Any  # (nu, PHASES, 4), of the references
    ideal: Any  # `ideal_servos.IdealServos`, None where every gain is finite


def reference_at(loop, t):
    """Return (position, velocity, acceleration) of the reference at t [s], in its present phase."""
    s = t - loop.phase_begin
    a = loop.phase_acceleration + s * loop.phase_jerk
    v = loop.phase_velocity + s * (loop.phase_acceleration + s * 0.5 * loop.phase_jerk)
    half = 0.5 * loop.phase_acceleration + s * loop.phase_jerk / 6.0
    return loop.phase_position + s * (loop.phase_velocity + s * half), v, a


def loop_effort(loop, drive, t):
    """Return the effort of a speed loop at time t [s] before limits.

    The joint's motion is in the record `drive`.
    """
    x, v, _ = reference_at(loop, t)
    offset = loop.offset + loop.correction * (t - loop.begin)
    return loop.gain * (v + loop.correction - drive.velocity) + loop.stiffness * (
        x + offset - drive.position
    )


def demanded_effort(servos, drive, i, t, effort):
    """Return the effort that the drive of joint i commands at time t [s].

    It is `effort` unless it is a servo drive.
    """
    if servos is None:
        return effort
    loop = servos.loops[i]
    if loop.kind == EFFORT:
        return effort
    return 0.0 if loop.ideal else min(max(loop_effort(loop, drive, t), drive.low), drive.high)


@routine
def plan_references(servos, drives, p, t, x, first):
    """Give servo drives the commands in `drives.effort`; return whether one is limited.

    The time is t [s], the state x.

    At the `first` period the references begin with the joints' motion.
    """
    (q, v), limited = system.actuated_joints(p, x), False
    for i in range(len(drives)):
        loop, drive = servos.loops[i], drives[i]
        if loop.kind != EFFORT:
            command = clip(drive.effort, loop.max_speed) if loop.kind == VELOCITY else drive.effort
            limited = limited or command != drive.effort
            if first or loop.restarts:
                begin_reference(loop, q[i], v[i], t)
            if first or loop.restarts or command != loop.command:
                plan_reference(loop, servos.phases, i, t, command)
            enter_phase(loop, servos.phases, i, t, 0.0)
            loop.begin, loop.restarts = t, False
            if loop.kind == POSITION:
                loop.correction = clip(
                    loop.position_gain * (reference_at(loop, t)[0] - q[i]), loop.max_speed
                )
            drive.position, drive.velocity = q[i], v[i]
            limited = limited or not (
                loop.ideal or drive.low <= loop_effort(loop, drive, t) <= drive.high
            )
            drive.effort, drive.target = 0.0, 0.0
    return limited


def begin_reference(loop, position, velocity, t):
    """Begin the reference at time t [s] with the joint's motion.

    The loop begins with the effort of the integral.
    """
    loop.phase_begin, loop.phase_position, loop.phase_velocity = t, position, velocity
    loop.phase_acceleration, loop.phase_jerk = 0.0, 0.0
    loop.offset = loop.integral / loop.stiffness if loop.stiffness > 0.0 else 0.0


def plan_reference(loop, phases, i, t, command):
    """Plan the reference of joint i from its present motion at time t [s] for a new command."""
    x, v, a = reference_at(loop, t)
    bounds = Bounds(loop.max_speed, loop.max_acceleration, loop.max_jerk)
    if loop.kind == POSITION:
        plan_position(phases, i, v, a, command - x, bounds)
    else:
        plan_velocity(phases, i, v, a, command, bounds)
    loop.command, loop.plan_begin, loop.plan_position = command, t, x


def enter_phase(loop, phases, i, t, least):
    """Enter the phase of joint i's plan that holds at time t [s].

    One that ends before t + `least` has passed.
    """
    begin, x, k = loop.plan_begin, loop.plan_position, 0
    while k < PHASES - 1 and begin + phases[i, k, 0] <= t + least:
        s, v, a, jerk = phases[i, k, 0], phases[i, k, 1], phases[i, k, 2], phases[i, k, 3]
        begin, x, k = begin + s, x + phase_distance(s, v, a, jerk), k + 1
    loop.phase_begin, loop.phase_position, loop.phase_velocity = begin, x, phases[i, k, 1]
    loop.phase_acceleration, loop.phase_jerk, loop.phase_end = (
        phases[i, k, 2],
        phases[i, k, 3],
        begin + phases[i, k, 0],
    )


def enter_phases(servos, t, end, least):
    """Enter the references' phases at time t [s]; return the instant [s] where one ends first.

    It is at most `end`.

    Instants nearer than `least` [s] to each other count as one.
    """
    if servos is None:
        return end
    for i in range(len(servos.loops)):
        loop = servos.loops[i]
        if loop.kind != EFFORT:
            enter_phase(loop, servos.phases, i, t, least)
            end = loop.phase_end if loop.phase_end < end - least else end
    return end


def latch_servos(servos, drives, t):
    """Move servo integrals to the end of a period, t [s], at which `drives` were evaluated.

    The transfer between brake and drive is bumpless: a drive begins with the brake's effort, and
    the other way round.
    """
    if servos is None:
        return
    for i in range(len(drives)):
        loop, drive = servos.loops[i], drives[i]
        if loop.kind != EFFORT and drive.engaged:
            loop.restarts, loop.integral = True, drive.effort
        elif loop.kind != EFFORT:
            latch_integral(loop, drive, t)


def latch_integral(loop, drive, t):
    """Move a speed loop's integral to a period's end, clamped where the effort is limited."""
    x = reference_at(loop, t)[0]
    offset = loop.offset + loop.correction * (t - loop.begin)
    integral = loop.stiffness * (x + offset - drive.position)
    demand, increment = loop_effort(loop, drive, t), integral - loop.integral
    shortfall = (
        demand * drive.effort_fraction - drive.effort if drive.effort_fraction > 0.0 else demand
    )
    if loop.stiffness > 0.0 and shortfall * increment > 0.0:
        offset = drive.position + loop.integral / loop.stiffness - x
    else:
        loop.integral = integral
    loop.offset = offset
