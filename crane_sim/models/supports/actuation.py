"""Actuated joints of an overhead crane: the axes driven by force, then the hoist driven by force.

A crane without a bridge, or without a hoist, gives None for it.
"""

from crane_sim.models.supports.hoist import PrescribedHoist
from crane_sim.models.supports.rails import ForceAxis, input_count
from crane_sim.numerics.jit import generic


def actuated_entries(trolley, bridge, hoist, x, i, axes):
    """Return those of the coordinates from x[i] on, of so many axes and the hoist, that are actuated, as a tuple."""
    return (*axis_entry(trolley, x, i), *axis_entry(bridge, x, i + 1), *hoist_entry(hoist, x, i + axes))


def effort_tuple(trolley, bridge, hoist, row):
    """Return the efforts in the array `row` as a tuple: trolley, bridge, hoist, those that take one."""
    first, last = input_count(trolley), input_count(trolley) + input_count(bridge)
    return (*axis_entry(trolley, row, 0), *axis_entry(bridge, row, first), *hoist_entry(hoist, row, last))


@generic
def axis_entry(axis, row, i):
    """Return entry i of the row as a tuple for an axis that takes an effort, empty for others."""
    return ()


@axis_entry.register(ForceAxis)
def _(axis, row, i):
    return (row[i],)


@generic
def hoist_entry(hoist, row, i):
    """Return entry i of the row as a tuple for a hoist that takes an effort, empty for others."""
    return (row[i],)


@hoist_entry.register(type(None))
@hoist_entry.register(PrescribedHoist)
def _(hoist, row, i):
    return ()
