"""Rigid links with lumped masses in space: unit vectors down the links, tensions, accelerations.

There is no angle, and so no singularity. The tensions solve the same tridiagonal, positive definite
system as in the plane, with scalar products of neighbouring unit vectors in place of cosines.
"""

from math import sqrt
from typing import Any, NamedTuple

from crane_sim.multibody.vectors import add, dot, scale, subtract


class Directions(NamedTuple):
    """Kinematics of the links; the rates are perpendicular to the unit vectors."""

    units: Any  # (N, 3), down the links, world frame
    rates: Any  # (N, 3) 1/s, of the unit vectors
    squared_rates: Any  # (N,) 1/s², squares of the rates
    lengths: Any  # (N,) m
    inv_masses: Any  # (N,) 1/kg, of the node below each link


class SupportEnd(NamedTuple):
    """Acceleration of the first link's upper end and of its length, as functions of its tension."""

    mobility: float  # 1/kg, of the end along the first link
    hoist_inv_mass: float  # 1/kg, of the length; -1 where the bias acceleration is the tension, see
    # `Hoist.response`
    hoist_bias_acc: float  # m/s², acceleration of the length without tension
    rate: float  # m/s, of the length

    def first_inv_mass(self, links):
        """Return the inverse mass [1/kg] of the first link along itself, without the hoist's."""
        return links.inv_masses[0] + self.mobility


def align(x, unit, rate):
    """Return (unit vector, rate across it) nearest to those that begin at x[unit] and x[rate]."""
    n, v = (x[unit], x[unit + 1], x[unit + 2]), (x[rate], x[rate + 1], x[rate + 2])
    n = scale(1.0 / sqrt(dot(n, n)), n)
    return n, subtract(v, scale(dot(n, v), n))


def row_of(array, k):
    """Return row k (3 floats) of an array (N, 3)."""
    return array[k, 0], array[k, 1], array[k, 2]


def scalar_product(units, k, j):
    """Return the scalar product of two rows of an array (N, 3)."""
    return dot(row_of(units, k), row_of(units, j))


def relative_end_acceleration(acc, k):
    """Return the relative acceleration (3 floats) of link k's ends."""
    return subtract(row_of(acc, k + 1), row_of(acc, k))


def constraint_acceleration(links, acc, k):
    """Return the relative acceleration [m/s²] along link k that its tension has to balance."""
    along = dot(row_of(links.units, k), relative_end_acceleration(acc, k))
    return links.lengths[k] * links.squared_rates[k] + along


def solve_tensions(links, top, acc, tension, ratio):
    """Fill the tensions (N,) [N]: eliminate downwards, substitute upwards.

    Args:
        links: kinematics of the links.
        top: the first link's upper end.
        acc: accelerations of nodes 0 to N without tensions (N + 1, 3) [m/s²], world frame.
        tension, ratio: to fill; the second one is of the elimination.
    """
    n, inv_masses = len(tension), links.inv_masses
    upper = -scalar_product(links.units, 0, 1) * inv_masses[0] if n > 1 else 0.0
    if top.hoist_inv_mass < 0.0:
        # the tension of a massless winch does not depend on the second link
        tension[0], ratio[0] = top.hoist_bias_acc, 0.0
    else:
        inverse = 1.0 / (top.first_inv_mass(links) + top.hoist_inv_mass)
        tension[0], ratio[0] = (
            (constraint_acceleration(links, acc, 0) - top.hoist_bias_acc) * inverse,
            upper * inverse,
        )
    for k in range(1, n):
        inverse = 1.0 / (inv_masses[k - 1] + inv_masses[k] - upper * ratio[k - 1])
        tension[k] = (constraint_acceleration(links, acc, k) - upper * tension[k - 1]) * inverse
        upper = -scalar_product(links.units, k, k + 1) * inv_masses[k] if k + 1 < n else 0.0
        ratio[k] = upper * inverse
    for k in range(n - 2, -1, -1):
        tension[k] -= ratio[k] * tension[k + 1]


def hoisted_length_acceleration(links, top, acc, tension):
    """Return the acceleration [m/s²] of the first length."""
    if top.hoist_inv_mass >= 0.0:
        return top.hoist_bias_acc + top.hoist_inv_mass * tension[0]
    free = constraint_acceleration(links, acc, 0) - top.first_inv_mass(links) * tension[0]
    return (
        free + scalar_product(links.units, 0, 1) * links.inv_masses[0] * tension[1]
        if len(tension) > 1
        else free
    )


def project_across(unit, vector):
    """Return the part of a vector across a unit vector."""
    return subtract(vector, scale(dot(unit, vector), unit))


def add_pull_across(units, k, j, pull, total):
    """Return `total` with the part across link k of a pull along link j.

    It is exact where both links nearly agree.
    """
    unit = row_of(units, k)
    return add(total, scale(pull, project_across(unit, subtract(row_of(units, j), unit))))


def direction_accelerations(links, top, acc, tension, out, at):
    """Write the unit vectors' second derivatives [1/s²] into out[at : at + 3 N].

    Other arguments as in `solve_tensions`.

    `acc` has the first link's pull on its upper end, which does not move along the link alone.
    The pulls of a link's neighbours are projected across it one by one, which avoids cancellation
    under a heavy payload.
    """
    n, units, inv_masses = len(tension), links.units, links.inv_masses
    relative = relative_end_acceleration(acc, 0)
    coriolis = 2.0 * top.rate / links.lengths[0]
    for k in range(n):
        total = project_across(row_of(units, k), relative)
        if k > 0:
            total = add_pull_across(units, k, k - 1, inv_masses[k - 1] * tension[k - 1], total)
        if k + 1 < n:
            total = add_pull_across(units, k, k + 1, inv_masses[k] * tension[k + 1], total)
            relative = relative_end_acceleration(acc, k + 1)
        inverse = 1.0 / links.lengths[k]
        for c in range(3):
            bias = links.squared_rates[k] * units[k, c] + coriolis * links.rates[k, c]
            out[at + 3 * k + c] = total[c] * inverse - bias
        coriolis = 0.0
