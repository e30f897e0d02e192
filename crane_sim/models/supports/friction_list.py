"""Friction of a support's joints, by events or by bristles: a linked list of those that have some, unrolled by type.

Each has a scalar friction state: its mode (`friction`) or the deflection of bristles (`lugre`), in the list's order.
"""

from typing import Any, NamedTuple

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.supports.friction import (
    Friction,
    breakaway_mode,
    first_not_none,
    friction_effort,
    friction_guard,
    friction_state_rate,
    initial_friction_state,
    joint_sticks,
    step_control_of,
)
from crane_sim.models.supports.lugre import LuGre
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_entry


class FrictionList(NamedTuple):
    """Friction of one joint, and that of the joints after it."""

    joint: int  # index of the support's coordinate
    friction: Friction | LuGre
    rest: Any = None  # FrictionList, None at the end


@generic
def list_length(frictions):
    """Return the number of joints with friction."""
    return 0


@list_length.register(FrictionList)
def _(frictions):
    return 1 + list_length(frictions.rest)


@generic
def read_friction_states(frictions, x, i):
    """Return the friction states of the list, which stand in x from index i on, as a tuple."""
    return ()


@read_friction_states.register(FrictionList)
def _(frictions, x, i):
    return (x[i], *read_friction_states(frictions.rest, x, i + 1))


@generic
def without_sticking(frictions, ratio, states, k):
    """Return the ratios (n,) with 0 for joints that friction holds; states: of friction, the list's from k on."""
    return ratio


@without_sticking.register(FrictionList)
def _(frictions, ratio, states, k):
    if joint_sticks(frictions.friction, states[k]):
        ratio = replace_entry(ratio, frictions.joint, 0.0)
    return without_sticking(frictions.rest, ratio, states, k + 1)


@generic
def add_friction_efforts(frictions, tau, rates, states, k):
    """Return the efforts tau plus those of friction; rates: of the joints (n,)."""
    return tau


@add_friction_efforts.register(FrictionList)
def _(frictions, tau, rates, states, k):
    i = frictions.joint
    tau = replace_entry(tau, i, tau[i] + friction_effort(frictions.friction, rates[i], states[k]))
    return add_friction_efforts(frictions.rest, tau, rates, states, k + 1)


@generic
def write_list_rates(frictions, rates, states, k, out):
    """Write the derivatives of the list's friction states into the end of `out`."""


@write_list_rates.register(FrictionList)
def _(frictions, rates, states, k, out):
    out[len(out) - len(states) + k] = friction_state_rate(frictions.friction, rates[frictions.joint], states[k])
    write_list_rates(frictions.rest, rates, states, k + 1, out)


@generic
def initialize_friction_states(frictions, rates, x):
    """Write the initial friction states of joints at these rates into the end of state x."""


@initialize_friction_states.register(FrictionList)
def _(frictions, rates, x):
    x[len(x) - list_length(frictions)] = initial_friction_state(frictions.friction, rates[frictions.joint])
    initialize_friction_states(frictions.rest, rates, x)


@generic
def mode_after_jump(friction, v, friction_state):
    """Return a joint's friction state after a jump of its rate to v: a mode anew, bristles stay as they are."""
    return friction_state


@mode_after_jump.register(Friction)
def _(friction, v, friction_state):
    return initial_friction_state(friction, v)


@generic
def reset_listed_modes(frictions, rates, x):
    """Write the modes after a velocity jump to these rates into the end of state x; bristles stay as they are."""


@reset_listed_modes.register(FrictionList)
def _(frictions, rates, x):
    i = len(x) - list_length(frictions)
    x[i] = mode_after_jump(frictions.friction, rates[frictions.joint], x[i])
    reset_listed_modes(frictions.rest, rates, x)


@generic
def any_in_list_sticks(frictions, states, k):
    """Return whether friction holds a joint."""
    return False


@any_in_list_sticks.register(FrictionList)
def _(frictions, states, k):
    return joint_sticks(frictions.friction, states[k]) or any_in_list_sticks(frictions.rest, states, k + 1)


@generic
def smallest_friction_guard(frictions, best, rates, efforts, states, sticking, k):
    """Return the smallest one of `best` and of the guards of joints that slip, or of those that stick.

    Args:
        frictions: the list.
        best: the smallest of the other guards.
        rates, efforts: of the joints (n,); the constraint efforts of those that stick.
        states: of friction, the list's from k on.
        sticking: whether the guards are those of joints that stick.
        k: see there.
    """
    return best


@smallest_friction_guard.register(FrictionList)
def _(frictions, best, rates, efforts, states, sticking, k):
    i = frictions.joint
    if joint_sticks(frictions.friction, states[k]) == sticking:
        value = friction_guard(frictions.friction, rates[i], states[k], efforts[i])
        best = smaller_guard(best, value, encode(Guard.FRICTION, i))
    return smallest_friction_guard(frictions.rest, best, rates, efforts, states, sticking, k + 1)


@generic
def place_in_list(frictions, joint):
    """Return the index in the list of a joint that has friction."""
    return 0


@place_in_list.register(FrictionList)
def _(frictions, joint):
    return 0 if frictions.joint == joint else 1 + place_in_list(frictions.rest, joint)


@generic
def mode_of_stopped_joint(frictions, joint, mode_before, effort):
    """Return the mode of a joint at rest under an effort after its guard has failed in mode `mode_before`."""
    return 0.0


@mode_of_stopped_joint.register(FrictionList)
def _(frictions, joint, mode_before, effort):
    if frictions.joint == joint:
        return breakaway_mode(frictions.friction, mode_before, effort)
    return mode_of_stopped_joint(frictions.rest, joint, mode_before, effort)


@step_control_of.register(FrictionList)
def _(part):
    return first_not_none(step_control_of(part.friction), step_control_of(part.rest))
