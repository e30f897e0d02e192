"""Friction of a support's joints, by events or by bristles: a linked list of those that have some, unrolled by type.

Each one has a float of the state, a mode (`friction`) or the deflection of bristles (`lugre`), in the list's order.
"""

from typing import Any, NamedTuple

from crane_sim.models.guards import Guard, encode, smaller_guard
from crane_sim.models.supports.friction import (
    Friction,
    breakaway_mode,
    contact_effort,
    contact_rate,
    either,
    friction_guard,
    initial_contact,
    is_held,
    retake_of,
)
from crane_sim.models.supports.lugre import LuGre
from crane_sim.numerics.jit import lean_generic
from crane_sim.numerics.states import replace_entry


class JointContacts(NamedTuple):
    """Friction of one joint, and that of the joints after it."""

    joint: int  # index of the support's coordinate
    friction: Friction | LuGre
    rest: Any = None  # JointContacts, None at the end


@lean_generic
def list_length(contacts):
    """Return the number of joints with friction."""
    return 0


@list_length.register(JointContacts)
def _(contacts):
    return 1 + list_length(contacts.rest)


@lean_generic
def contact_entries(contacts, x, i):
    """Return the list's floats of the state, which stand in x from index i on, as a tuple."""
    return ()


@contact_entries.register(JointContacts)
def _(contacts, x, i):
    return (x[i], *contact_entries(contacts.rest, x, i + 1))


@lean_generic
def without_held(contacts, ratio, floats, k):
    """Return the ratios (n,) with 0 for joints that friction holds; floats: of the state, the list's from k on."""
    return ratio


@without_held.register(JointContacts)
def _(contacts, ratio, floats, k):
    if is_held(contacts.friction, floats[k]):
        ratio = replace_entry(ratio, contacts.joint, 0.0)
    return without_held(contacts.rest, ratio, floats, k + 1)


@lean_generic
def add_contact_efforts(contacts, tau, rates, floats, k):
    """Return the efforts tau plus those of friction; rates: of the joints (n,)."""
    return tau


@add_contact_efforts.register(JointContacts)
def _(contacts, tau, rates, floats, k):
    i = contacts.joint
    tau = replace_entry(tau, i, tau[i] + contact_effort(contacts.friction, rates[i], floats[k]))
    return add_contact_efforts(contacts.rest, tau, rates, floats, k + 1)


@lean_generic
def write_list_rates(contacts, rates, floats, k, out):
    """Write the derivatives of the list's floats into the end of `out`."""


@write_list_rates.register(JointContacts)
def _(contacts, rates, floats, k, out):
    out[len(out) - len(floats) + k] = contact_rate(contacts.friction, rates[contacts.joint], floats[k])
    write_list_rates(contacts.rest, rates, floats, k + 1, out)


@lean_generic
def fill_contacts(contacts, rates, x):
    """Write the list's floats of joints at these rates into the end of state x."""


@fill_contacts.register(JointContacts)
def _(contacts, rates, x):
    x[len(x) - list_length(contacts)] = initial_contact(contacts.friction, rates[contacts.joint])
    fill_contacts(contacts.rest, rates, x)


@lean_generic
def mode_at(friction, v, contact):
    """Return the float of a joint's friction after a jump of its rate to v: bristles stay as they are."""
    return contact


@mode_at.register(Friction)
def _(friction, v, contact):
    return initial_contact(friction, v)


@lean_generic
def fill_modes(contacts, rates, x):
    """Write the modes of joints at these rates into the end of state x; bristles stay as they are."""


@fill_modes.register(JointContacts)
def _(contacts, rates, x):
    i = len(x) - list_length(contacts)
    x[i] = mode_at(contacts.friction, rates[contacts.joint], x[i])
    fill_modes(contacts.rest, rates, x)


@lean_generic
def any_in_list_held(contacts, floats, k):
    """Return whether friction holds a joint."""
    return False


@any_in_list_held.register(JointContacts)
def _(contacts, floats, k):
    return is_held(contacts.friction, floats[k]) or any_in_list_held(contacts.rest, floats, k + 1)


@lean_generic
def contact_guards(contacts, best, rates, loads, floats, held, k):
    """Return the smallest one of `best` and of the guards of joints that slip (held False) or stick (held True).

    Args:
        contacts: the list.
        best: the smallest of the other guards.
        rates, loads: of the joints (n,), what would accelerate those that stick.
        floats: of the state, the list's from k on.
        held: whether the guards are those of joints that stick.
        k: see there.
    """
    return best


@contact_guards.register(JointContacts)
def _(contacts, best, rates, loads, floats, held, k):
    i = contacts.joint
    if is_held(contacts.friction, floats[k]) == held:
        value = friction_guard(contacts.friction, rates[i], floats[k], loads[i])
        best = smaller_guard(best, value, encode(Guard.FRICTION, i))
    return contact_guards(contacts.rest, best, rates, loads, floats, held, k + 1)


@lean_generic
def place_in_list(contacts, joint):
    """Return the index in the list of a joint that has friction."""
    return 0


@place_in_list.register(JointContacts)
def _(contacts, joint):
    return 0 if contacts.joint == joint else 1 + place_in_list(contacts.rest, joint)


@lean_generic
def mode_of_stopped_joint(contacts, joint, failed, load):
    """Return the mode of a joint at rest under a load after its guard has failed in mode `failed`."""
    return 0.0


@mode_of_stopped_joint.register(JointContacts)
def _(contacts, joint, failed, load):
    if contacts.joint == joint:
        return breakaway_mode(contacts.friction, failed, load)
    return mode_of_stopped_joint(contacts.rest, joint, failed, load)


@retake_of.register(JointContacts)
def _(part):
    return either(retake_of(part.friction), retake_of(part.rest))
