"""Which joints take commands: the axes that a force drives, then the hoist that one drives.

`driven` and `efforts` are for a trolley alone, `driven_both` and `efforts_both` for a trolley on a bridge.
"""

from crane_sim.jit import generic, kernel
from crane_sim.overhead.axes import ForceAxis, demands
from crane_sim.overhead.hoists import PrescribedHoist


@kernel
def driven(trolley, hoist, x, i):
    """Return the actuated joints' share of the coordinates from x[i] on as a tuple, the trolley's first."""
    return (*pushed(trolley, x, i), *wound(hoist, x, i + 1))


@kernel
def driven_both(trolley, bridge, hoist, x, i):
    """Return the actuated joints' share of the coordinates from x[i] on as a tuple: trolley, bridge, hoist."""
    return (*pushed(trolley, x, i), *pushed(bridge, x, i + 1), *wound(hoist, x, i + 2))


@kernel
def efforts(trolley, hoist, row):
    """Return the efforts in the array `row` as a tuple, the trolley's first."""
    return (*pushed(trolley, row, 0), *wound(hoist, row, demands(trolley)))


@kernel
def efforts_both(trolley, bridge, hoist, row):
    """Return the efforts in the array `row` as a tuple: trolley, bridge, hoist."""
    first, last = demands(trolley), demands(trolley) + demands(bridge)
    return (*pushed(trolley, row, 0), *pushed(bridge, row, first), *wound(hoist, row, last))


@generic
def pushed(axis, row, i):
    """Return entry i of the row as a tuple for an axis that takes an effort, empty for others."""
    return ()


@pushed.register(ForceAxis)
def _(axis, row, i):
    return (row[i],)


@generic
def wound(hoist, row, i):
    """Return entry i of the row as a tuple for a hoist that takes an effort, empty for others."""
    return (row[i],)


@wound.register(type(None))
@wound.register(PrescribedHoist)
def _(hoist, row, i):
    return ()
