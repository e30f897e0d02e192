"""Layout of the state of a crane whose load hangs below a support, with a hoist or without.

A state is one array [support, (length), what hangs, and their rates, (energy supplied), modes]. The
modes are those of falls or links, that of the winch, where it has friction, the number of exchanges
of the load, where it has any, then those of contact, drives and joints. Parameters of such a crane
have methods `hanging_coordinates`, `cable_modes` and `fixed_length`.
"""

from crane_sim.models.contact.surface import count_contact_modes
from crane_sim.models.energy_meter import meter_size
from crane_sim.models.supports.hoist import hoist_coordinates, hoist_modes
from crane_sim.models.supports.support import coordinate_count, drive_count, friction_state_count


def layout_of(p):
    """Return (number nq of coordinates, index of the first below the hoist, of the first mode)."""
    first = coordinate_count(p.support) + hoist_coordinates(p.hoist)
    nq = first + p.hanging_coordinates()
    return nq, first, 2 * nq + meter_size(p.energy_meter)


def rope_length(p, x):
    """Return (length [m], its rate [m/s]) that the hoist changes.

    It is that of the first link, or the unstretched one of all falls.
    """
    if p.hoist is None:
        return p.fixed_length(), 0.0
    nq, first, _ = layout_of(p)
    return x[first - 1], x[nq + first - 1]


def winch_index(p):
    """Return the index of the winch's mode, where it has friction."""
    return layout_of(p)[2] + p.cable_modes()


def exchange_index(p):
    """Return the index of the number of exchanges, where the model has it."""
    return winch_index(p) + hoist_modes(p.hoist)


def contact_index(p):
    """Return the index of the load's first mode of contact, or, without any, of what follows."""
    return exchange_index(p) + (0 if p.exchange is None else 1)


def state_size(p):
    """Return the number of entries of the state."""
    contact = count_contact_modes(getattr(p, "contact", None))
    return contact_index(p) + contact + drive_count(p.support) + friction_state_count(p.support)
