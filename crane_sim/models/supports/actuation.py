"""Which joints take commands: the axes that a force drives, then the hoist that one drives.

A crane without a bridge, or without a hoist, gives None for it.

When an overhead crane needs a meter: the work of held efforts follows from samples, all other work does not.
"""

from typing import Any

from crane_sim.models.energy_meter import Meter
from crane_sim.models.supports.hoist import PrescribedHoist
from crane_sim.models.supports.rails import ForceAxis, PrescribedAxis, input_count
from crane_sim.numerics.jit import generic, kernel


@kernel
def actuated_entries(trolley, bridge, hoist, x, i, axes):
    """Return those of the coordinates from x[i] on, of so many axes and the hoist, that are actuated, as a tuple."""
    return (*axis_entry(trolley, x, i), *axis_entry(bridge, x, i + 1), *hoist_entry(hoist, x, i + axes))


@kernel
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


def add_meter(p: Any, held: bool) -> Any:
    """Return the model with a meter where held efforts do not tell all the energy supplied."""
    parts = [getattr(p, name, None) for name in ("trolley", "bridge", "hoist")]
    imposed = any(isinstance(part, PrescribedAxis | PrescribedHoist) for part in parts)
    rubs = any(isinstance(part, ForceAxis) and part.friction is not None for part in parts)
    others = any(getattr(p, name, None) is not None for name in ("joints", "forces", "switches", "base"))
    return p._replace(meter=Meter()) if imposed or rubs or others or not held else p
