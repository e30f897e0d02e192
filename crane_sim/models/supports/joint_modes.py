"""Modes of a support's joints: friction, bristles, drives in their play; guards and resets.

A joint sticks or slides (modes of `friction`), or its friction has bristles (`lugre`), whose
deflections are states.
"""

from typing import Any

from crane_sim.models.guards import Guard, decode, encode, smaller_guard, travel_guard
from crane_sim.models.supports.backlash import drive_guard, drives_of, mode_of, outcome_of, shaft_of
from crane_sim.models.supports.friction import Friction, step_control_of
from crane_sim.models.supports.support import (
    Support,
    SupportState,
    drive_count,
    first_friction_state,
    frictions_of,
)
from crane_sim.models.supports.support_dynamics import constraint_effort
from crane_sim.system import EVENT_LOG_CAPACITY, EventStepControl, Switching


def write_friction_rates(support: Support, state: SupportState, out: Any) -> None:
    """Write the derivatives of the friction states into the end of `out`."""
    first = first_friction_state(support, out)
    for k, (i, friction) in enumerate(frictions_of(support)):
        out[first + k] = friction.state_rate(state.v[i], state.friction[k])


def initialize_modes(support: Support, x: Any, state: SupportState) -> None:
    """Write the initial modes of drives and friction into the end of a crane's state x."""
    first = first_friction_state(support, x)
    for k, (i, drive) in enumerate(drives_of(support.drives)):
        shaft = shaft_of(drive, state.drives[k], state.q[i], state.v[i])
        x[first - drive_count(support) + k] = mode_of(shaft)
    for k, (i, friction) in enumerate(frictions_of(support)):
        x[first + k] = friction.initial_state(state.v[i])


def reset_friction_modes(support: Support, x: Any, state: SupportState) -> None:
    """Write the friction modes after a velocity jump into the end of x; bristles stay."""
    first = first_friction_state(support, x)
    for k, (i, friction) in enumerate(frictions_of(support)):
        if isinstance(friction, Friction):
            x[first + k] = friction.initial_state(state.v[i])


def any_joint_sticks(support: Support, state: SupportState) -> Any:
    """Return whether friction holds a joint."""
    result = False
    for (_, friction), friction_state in zip(frictions_of(support), state.friction, strict=True):
        result = result or friction.sticks(friction_state)
    return result


def support_guard(support: Support, best: Any, state: SupportState) -> Any:
    """Return the smallest one of `best` and of travel limits, plays and slipping joints.

    See `models.guards`.
    """
    for i, limits in enumerate(support.structure.mechanism().limits):
        best = travel_guard(limits, best, state.q[i], encode(Guard.TRAVEL, i))
    for (i, friction), friction_state in zip(frictions_of(support), state.friction, strict=True):
        if not friction.sticks(friction_state):
            value = friction.guard(state.v[i], friction_state, state.v[i])
            best = smaller_guard(best, value, encode(Guard.FRICTION, i))
    for k, (i, drive) in enumerate(drives_of(support.drives)):
        value = drive_guard(drive, state.drives[k], state.q[i], state.v[i])
        best = smaller_guard(best, value, encode(Guard.BACKLASH, k))
    return best


def sticking_guard(support: Support, best: Any, state: SupportState, moved: Any) -> Any:
    """Return the smallest one of `best` and of the guards of joints that friction holds.

    Args:
        support, best, state: the support, the smallest other guard, and the support's state.
        moved: the SupportMotion.
    """
    for (i, friction), friction_state in zip(frictions_of(support), state.friction, strict=True):
        if friction.sticks(friction_state):
            held = constraint_effort(moved.dynamics, moved.net, moved.accelerations, i)
            value = friction.guard(state.v[i], friction_state, held)
            best = smaller_guard(best, value, encode(Guard.FRICTION, i))
    return best


def friction_state_index(support: Support, x: Any, joint: Any) -> Any:
    """Return the index of a joint's friction state in a crane's state x."""
    first, index = first_friction_state(support, x), len(x) - 1
    for k, (i, _) in enumerate(frictions_of(support)):
        if i == joint:
            index = first + k
    return index


def mode_after_guard(support: Support, joint: Any, mode_before: Any, moved: Any) -> Any:
    """Return the mode of a joint at rest after its guard has failed in mode `mode_before`.

    `moved` is the SupportMotion with the joint held.
    """
    mode = mode_before
    for i, friction in frictions_of(support):
        if isinstance(friction, Friction) and i == joint:
            held = constraint_effort(moved.dynamics, moved.net, moved.accelerations, i)
            mode = friction.breakaway_mode(mode_before, held)
    return mode


def with_support_switching(support: Support, switching: Any) -> Any:
    """Return the result of `system.switching`: `switching` for a support that does not switch."""
    if support.drives is not None:
        return Switching(EVENT_LOG_CAPACITY, 0, EventStepControl())
    if support.frictions is None:
        return switching
    control = switching.step_control if isinstance(switching, Switching) else None
    own = step_control_of(*support.frictions)
    return Switching(EVENT_LOG_CAPACITY, 0, own if control is None else control)


def switch_drive(support: Support, x: Any, state: SupportState, number: Any) -> Any:
    """Return the result of `system.apply_reset_map` after the guard of a drive failed.

    It is that in the support's state.
    """
    _, which, _ = decode(number)
    y, mode = x.copy(), 0.0
    for k, (i, drive) in enumerate(drives_of(support.drives)):
        if k == which:
            mode = mode_of(shaft_of(drive, state.drives[k], state.q[i], state.v[i]))
    y[first_friction_state(support, x) - drive_count(support) + which] = mode
    return y, encode(Guard.BACKLASH, which, outcome_of(mode)), True
