"""Friction of a support's joints, by events or by bristles: a linked list of those that have some, unrolled by type.

Each has a scalar friction state: its mode (`friction`) or the deflection of bristles (`lugre`), in the list's order.
"""

from typing import Any, NamedTuple

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.supports.friction import (
    Friction,
    breakaway_mode,
    either,
    friction_effort,
    friction_guard,
    friction_state_rate,
    initial_friction_state,
    is_held,
    retake_of,
)
from crane_sim.models.supports.lugre import LuGre
from crane_sim.numerics.jit import lean_generic
from crane_sim.numerics.states import replace_entry


class FrictionList(NamedTuple):
    """Friction of one joint, and that of the joints after it."""

    joint: int  # index of the support's coordinate
    friction: Friction | LuGre
    rest: Any = None  # FrictionList, None at the end


@lean_generic
def list_length(frictions):
    """Return the number of joints with friction."""
    return 0


@list_length.register(FrictionList)
def _(frictions):
    return 1 + list_length(frictions.rest)


@lean_generic
def friction_states(frictions, x, i):
    """Return the friction states of the list, which stand in x from index i on, as a tuple."""
    return ()


@friction_states.register(FrictionList)
def _(frictions, x, i):
    return (x[i], *friction_states(frictions.rest, x, i + 1))


@lean_generic
def without_held(frictions, ratio, floats, k):
    """Return the ratios (n,) with 0 for joints that friction holds; floats: of the state, the list's from k on."""
    return ratio


@without_held.register(FrictionList)
def _(frictions, ratio, floats, k):
    if is_held(frictions.friction, floats[k]):
        ratio = replace_entry(ratio, frictions.joint, 0.0)
    return without_held(frictions.rest, ratio, floats, k + 1)


@lean_generic
def add_friction_efforts(frictions, tau, rates, floats, k):
    """Return the efforts tau plus those of friction; rates: of the joints (n,)."""
    return tau


@add_friction_efforts.register(FrictionList)
def _(frictions, tau, rates, floats, k):
    i = frictions.joint
    tau = replace_entry(tau, i, tau[i] + friction_effort(frictions.friction, rates[i], floats[k]))
    return add_friction_efforts(frictions.rest, tau, rates, floats, k + 1)


@lean_generic
def write_list_rates(frictions, rates, floats, k, out):
    """Write the derivatives of the list's floats into the end of `out`."""


@write_list_rates.register(FrictionList)
def _(frictions, rates, floats, k, out):
    out[len(out) - len(floats) + k] = friction_state_rate(frictions.friction, rates[frictions.joint], floats[k])
    write_list_rates(frictions.rest, rates, floats, k + 1, out)


@lean_generic
def fill_friction_states(frictions, rates, x):
    """Write the list's floats of joints at these rates into the end of state x."""


@fill_friction_states.register(FrictionList)
def _(frictions, rates, x):
    x[len(x) - list_length(frictions)] = initial_friction_state(frictions.friction, rates[frictions.joint])
    fill_friction_states(frictions.rest, rates, x)


@lean_generic
def mode_at(friction, v, friction_state):
    """Return the float of a joint's friction after a jump of its rate to v: bristles stay as they are."""
    return friction_state


@mode_at.register(Friction)
def _(friction, v, friction_state):
    return initial_friction_state(friction, v)


@lean_generic
def fill_modes(frictions, rates, x):
    """Write the modes of joints at these rates into the end of state x; bristles stay as they are."""


@fill_modes.register(FrictionList)
def _(frictions, rates, x):
    i = len(x) - list_length(frictions)
    x[i] = mode_at(frictions.friction, rates[frictions.joint], x[i])
    fill_modes(frictions.rest, rates, x)


@lean_generic
def any_in_list_held(frictions, floats, k):
    """Return whether friction holds a joint."""
    return False


@any_in_list_held.register(FrictionList)
def _(frictions, floats, k):
    return is_held(frictions.friction, floats[k]) or any_in_list_held(frictions.rest, floats, k + 1)


@lean_generic
def smallest_friction_guard(frictions, best, rates, loads, floats, held, k):
    """Return the smallest one of `best` and of the guards of joints that slip (held False) or stick (held True).

    Args:
        frictions: the list.
        best: the smallest of the other guards.
        rates, loads: of the joints (n,), what would accelerate those that stick.
        floats: of the state, the list's from k on.
        held: whether the guards are those of joints that stick.
        k: see there.
    """
    return best


@smallest_friction_guard.register(FrictionList)
def _(frictions, best, rates, loads, floats, held, k):
    i = frictions.joint
    if is_held(frictions.friction, floats[k]) == held:
        value = friction_guard(frictions.friction, rates[i], floats[k], loads[i])
        best = smaller_guard(best, value, encode(Guard.FRICTION, i))
    return smallest_friction_guard(frictions.rest, best, rates, loads, floats, held, k + 1)


@lean_generic
def place_in_list(frictions, joint):
    """Return the index in the list of a joint that has friction."""
    return 0


@place_in_list.register(FrictionList)
def _(frictions, joint):
    return 0 if frictions.joint == joint else 1 + place_in_list(frictions.rest, joint)


@lean_generic
def mode_of_stopped_joint(frictions, joint, failed, load):
    """Return the mode of a joint at rest under a load after its guard has failed in mode `failed`."""
    return 0.0


@mode_of_stopped_joint.register(FrictionList)
def _(frictions, joint, failed, load):
    if frictions.joint == joint:
        return breakaway_mode(frictions.friction, failed, load)
    return mode_of_stopped_joint(frictions.rest, joint, failed, load)


@retake_of.register(FrictionList)
def _(part):
    return either(retake_of(part.friction), retake_of(part.rest))
