"""A spring and a damper between two bodies that turn about the same axis, or None where they are one."""

from typing import NamedTuple

from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_entry


class Compliance(NamedTuple):
    """A bending mode."""

    stiffness: float  # N m/rad, k
    rest: float  # rad, where the spring is relaxed
    damping: float  # N m s/rad, c


@generic
def compliance_count(compliance):
    """Return the number of coordinates of a compliance: none of a rigid axis."""
    return 0


@compliance_count.register(Compliance)
def _(compliance):
    return 1


@generic
def compliance_entry(compliance, row, i):
    """Return entry i of a row of coordinates, 0 of a rigid axis."""
    return 0.0


@compliance_entry.register(Compliance)
def _(compliance, row, i):
    return row[i]


@generic
def as_entries(compliance, value):
    """Return the value as a tuple, an empty one of a rigid axis."""
    return ()


@as_entries.register(Compliance)
def _(compliance, value):
    return (value,)


@generic
def compliance_effort(compliance, angle, rate):
    """Return the moment [N m] of spring and damper on the outer body."""
    return 0.0


@compliance_effort.register(Compliance)
def _(compliance, angle, rate):
    return -compliance.stiffness * (angle - compliance.rest) - compliance.damping * rate


@generic
def compliance_energy(compliance, angle):
    """Return (energy [J], its derivative [N m]) of the spring."""
    return 0.0, 0.0


@compliance_energy.register(Compliance)
def _(compliance, angle):
    moment = compliance.stiffness * (angle - compliance.rest)
    return 0.5 * moment * (angle - compliance.rest), moment


@generic
def add_elastic(compliance, tau, i, effort):
    """Return efforts tau with this one added to entry i; tau itself of a rigid axis."""
    return tau


@add_elastic.register(Compliance)
def _(compliance, tau, i, effort):
    return replace_entry(tau, i, tau[i] + effort)


@generic
def outer_inertia(compliance, inner, outer):
    """Return the inertia that turns with the outer body: that of both about a rigid axis."""
    return inner + outer


@outer_inertia.register(Compliance)
def _(compliance, inner, outer):
    return outer


@generic
def drive_inertia(compliance, inner, outer):
    """Return the inertia that turns with the drive: that of both about a rigid axis."""
    return inner + outer


@drive_inertia.register(Compliance)
def _(compliance, inner, outer):
    return inner


@generic
def drive_lever(compliance, lever):
    """Return the lever of the drive's body on the tip, given that of the outer one: the same on a rigid axis."""
    return lever


@drive_lever.register(Compliance)
def _(compliance, lever):
    return 0.0


@generic
def axis_accelerations(compliance, effort, elastic, inertia):
    """Return the accelerations (2,) of an axis' drive and of its spring's angle, the latter 0 without a spring.

    Args:
        compliance: of the axis.
        effort: on both bodies [N m].
        elastic: the part of it on the outer one.
        inertia: of inner and outer body (2,) [kg m²].
    """
    return effort / (inertia[0] + inertia[1]), 0.0


@axis_accelerations.register(Compliance)
def _(compliance, effort, elastic, inertia):
    drive = (effort - elastic) / inertia[0]
    return drive, elastic / inertia[1] - drive
