"""Functions of `crane_sim.system` that several models of overhead cranes share."""

from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.models.energy_meter import Meter, meter_entry
from crane_sim.models.overhead import layout_of
from crane_sim.models.overhead.double import DoubleCrane
from crane_sim.models.overhead.events import describe_switch, initial_modes, switching_of
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import RodCrane
from crane_sim.models.overhead.spring import SpringCrane
from crane_sim.models.supports.hoist import PrescribedHoist, hoist_entry, limit_hoist
from crane_sim.models.supports.rails import ForceAxis, PrescribedAxis
from crane_sim.models.wind_kink import kink_guard, pressed_point

OF_TUPLES = RodCrane, DoubleCrane, SpringCrane
ALL = *OF_TUPLES, PlanarCrane

system.kink_guard.register(PlanarCrane)(kink_guard)
system.switching.register(RodCrane, PlanarCrane)(switching_of)
system.describe_event.register(RodCrane, PlanarCrane)(describe_switch)
pressed_point.register(PlanarCrane)(PlanarCrane.payload_position)


@system.state.register(*OF_TUPLES)
def state_tuple(p, t, q, v):
    """Return the state, a tuple, with the modes that follow from velocities."""
    n = range(layout_of(p)[0])
    rates = (*[v[i] for i in n], *meter_entry(p.energy_meter, 0.0), *initial_modes(p, t, v))
    return (*[q[i] for i in n], *rates)


@system.joints.register(*OF_TUPLES)
def entries_of_joints(p, x):
    """Return positions and velocities of a state that is a tuple."""
    nq, _, _ = layout_of(p)
    return x[:nq], x[nq : 2 * nq]


@system.acceleration.register(*OF_TUPLES)
def entries_of_acceleration(p, t, x, u):
    """Return the accelerations of a model whose state is a tuple."""
    nq, _, _ = layout_of(p)
    return system.rhs(p, t, x, u)[nq : 2 * nq]


@system.joints.register(PlanarCrane)
def copies_of_joints(p, x):
    """Return positions and velocities of a state that is an array."""
    nq, _, _ = layout_of(p)
    return x[:nq].copy(), x[nq : 2 * nq].copy()


@system.acceleration.register(PlanarCrane)
def copies_of_acceleration(p, t, x, u):
    """Return the accelerations of a model whose state is an array."""
    nq, _, _ = layout_of(p)
    return system.rhs(p, t, x, u)[nq : 2 * nq].copy()


@system.position_count.register(PlanarCrane)
def count_positions(p):
    """Return the number of positions."""
    return layout_of(p)[0]


@system.link_count.register(PlanarCrane)
def count_links(p):
    """Return the number of links."""
    return len(p.cable.masses)


@system.point_count.register(*ALL)
def count_points(p):
    """Return the number of points of trolley and nodes."""
    return 1 + system.link_count(p)


@system.energy_supplied.register(*ALL)
def energy_supplied(p, x):
    """Return the meter's reading [J]."""
    return 0.0 if p.energy_meter is None else x[2 * layout_of(p)[0]]


@system.actuated_joints.register(*ALL)
def actuated_joints(p, x):
    """Return positions and velocities of what takes an effort."""
    nq, _, _ = layout_of(p)
    return actuated_entries(p, x, 0, 1), actuated_entries(p, x, nq, nq + 1)


@system.efforts_from_row.register(*ALL)
def efforts_from_row(p, row):
    """Return the efforts on trolley and hoist."""
    return actuated_entries(p, row, 0, 1 if isinstance(p.trolley, ForceAxis) else 0)


def actuated_entries(p, row, trolley, hoist):
    """Return those of two entries of a row, by index, whose joints take an effort."""
    first = (row[trolley],) if isinstance(p.trolley, ForceAxis) else ()
    return (*first, *hoist_entry(p.hoist, row, hoist))


@system.saturate.register(RodCrane, PlanarCrane)
def limit_efforts(p, u):
    """Return what the hoist can apply."""
    return limit_hoist(p.hoist, u)


@system.with_meter.register(*ALL)
def with_meter(p, held):
    """Return the crane with a meter where work is done that samples of efforts do not show."""
    return p._replace(energy_meter=Meter()) if works_between_samples(p) or not held else p


def works_between_samples(p: Any) -> bool:
    """Return whether work is done besides that of held efforts at samples.

    That is by motions, friction, forces, base, wind and dampers.
    """
    parts = p.trolley, p.hoist
    imposed = any(isinstance(part, PrescribedAxis | PrescribedHoist) for part in parts)
    rubs = any(isinstance(part, ForceAxis) and part.friction is not None for part in parts)
    others = ("joints", "forces", "event_limits", "base", "wind", "drag", "force")
    damped = np.any(getattr(p.cable, "damping", 0.0))
    return (
        bool(damped)
        or imposed
        or rubs
        or any(getattr(p, name, None) is not None for name in others)
    )
