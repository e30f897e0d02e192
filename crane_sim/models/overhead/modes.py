"""Switching and terminal events of an overhead crane: friction, limits, a slack link, changes of the payload.

Modes stand at the end of the state: one for the friction of each axis (0 sticks, else the direction of slipping; or the
deflection of its bristles, which has a derivative), then one for that of the hoist, where it has some, then the number
of payload changes up to then.
"""

from typing import Any, NamedTuple

from crane_sim.models.guards import LOWER, UPPER, Guard, decode, describe_friction, encode, smaller_guard
from crane_sim.models.stops import describe_length_event
from crane_sim.models.supports.rails import mode_rate
from crane_sim.numerics.jit import generic, lean_generic, lean_kernel
from crane_sim.system import Switching


class Switches(NamedTuple):
    """Parameters of switching and terminal guards; infinite where there is no limit."""

    lower: tuple[float, float]  # m, of trolley and bridge
    upper: tuple[float, float]
    shortest: float  # m, of the first link
    longest: float
    taut: float  # 1: a run ends when a rigid link goes slack, 0: links are rods that can push
    times: Any  # (changes,) s, when the payload changes
    masses: Any  # (changes + 1,) kg, of the payload before, between and after them


@generic
def switching_of(switches, forces, nq, retake):
    """Return the result of `system.switching` for a crane with these switches.

    Args:
        switches: None for a crane without.
        forces: whether guards need velocities or forces, links that may not go slack apart.
        nq: number of coordinates, which stand first in the state and then their rates.
        retake: of `Switching`.
    """
    return None


@switching_of.register(Switches)
def _(switches, forces, nq, retake):
    return Switching(1000, 0 if forces or switches.taut > 0.0 else nq, retake)


@lean_generic
def mode_of(switches, x, first, i):
    """Return mode number i of state x, whose modes begin at index `first`; 0 for a crane without."""
    return 0.0


@mode_of.register(Switches)
def _(switches, x, first, i):
    return x[first + i]


@lean_generic
def write_mode_rate(switches, axis, v, x, i, out):
    """Write the derivative of the mode x[i] of an axis at velocity v into `out`, where the crane has modes."""


@write_mode_rate.register(Switches)
def _(switches, axis, v, x, i, out):
    out[i] = mode_rate(axis, v, x[i])


@lean_generic
def mode_count(switches, axes):
    """Return the number of floats of the modes of a crane with this number of axes."""
    return 0


@mode_count.register(Switches)
def _(switches, axes):
    return axes + 1


@lean_generic
def payload_mass(switches, x, last, mass):
    """Return the payload's mass [kg], `mass` where it never changes; `last` is the index of the state's last float."""
    return mass


@payload_mass.register(Switches)
def _(switches, x, last, mass):
    return switches.masses[int(x[last])]


@lean_generic
def changes_before(switches, t):
    """Return the number of payload changes before time t."""
    return 0.0


@changes_before.register(Switches)
def _(switches, t):
    changes = 0.0
    for time in switches.times:
        if time < t:
            changes += 1.0
    return changes


@lean_kernel
def limits_guard(switches, best, axis, q):
    """Return the smallest guard, the travel limits of an axis at q counted in."""
    margin = min(q - switches.lower[axis], switches.upper[axis] - q)
    return smaller_guard(best, margin, encode(Guard.TRAVEL, axis))


@lean_kernel
def hoist_guard(switches, best, length):
    """Return the smallest guard, the limits of the first link's length counted in."""
    best = smaller_guard(best, length - switches.shortest, encode(Guard.LENGTH, LOWER))
    return smaller_guard(best, switches.longest - length, encode(Guard.LENGTH, UPPER))


@lean_kernel
def payload_guard(switches, best, t, changes):
    """Return the smallest guard, the next change of the payload counted in."""
    if changes < len(switches.times):
        return smaller_guard(best, switches.times[int(changes)] - t, encode(Guard.PAYLOAD, 0))
    return best


@lean_kernel
def slack_guard(switches, best, tensions, n):
    """Return the smallest guard, the first n tensions, of rigid links, counted in where a slack one ends the run."""
    if switches.taut > 0.0:
        for k in range(n):
            best = smaller_guard(best, tensions[k], encode(Guard.LINK, k))
    return best


def describe_switch(switches: Switches | None, number: int) -> tuple[str, str]:
    """Return texts (meaning of a guard or event, what a user can change)."""
    kind, index, outcome = decode(number)
    if kind == Guard.LINK:
        return (
            f"link {index + 1} went slack, and a rigid link cannot be",
            "take cable.model: elastic with tension_only, or cable.slack: allow if the links are rods",
        )
    if kind == Guard.PAYLOAD:
        return "the payload changed", ""
    if kind == Guard.LENGTH:
        shortest = switches.shortest if switches is not None else 0.0
        return describe_length_event("hoisted link", "hoist", index, shortest)
    axis = ("trolley", "bridge", "hoist")[index]
    if kind == Guard.TRAVEL:
        return f"the {axis} reached its travel limit", f"change {axis}.limits, or what drives the {axis}"
    return describe_friction(axis, outcome), ""
