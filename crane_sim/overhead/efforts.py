"""Which joints take commands: the axes that a force drives, then the hoist that one drives."""

from crane_sim.jit import generic
from crane_sim.overhead.axes import ForceAxis
from crane_sim.overhead.hoists import PrescribedHoist


@generic
def driven(trolley, hoist, x, i):
    """Return the actuated joints' share of the coordinates from x[i] on as a tuple, the trolley's first."""
    return wound(hoist, x, i + 1)


@driven.register(ForceAxis)
def _(trolley, hoist, x, i):
    return (x[i], *wound(hoist, x, i + 1))


@generic
def efforts(trolley, hoist, row):
    """Return the efforts in the array `row` as a tuple, the trolley's first."""
    return wound(hoist, row, 0)


@efforts.register(ForceAxis)
def _(trolley, hoist, row):
    return (row[0], *wound(hoist, row, 1))


@generic
def wound(hoist, row, i):
    """Return entry i of the row as a tuple for a hoist that takes an effort, empty for others."""
    return (row[i],)


@wound.register(type(None))
@wound.register(PrescribedHoist)
def _(hoist, row, i):
    return ()
