"""Implementations of `crane_sim.system` functions that several models of overhead cranes share."""

from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.models.energy_meter import Meter, meter_entry
from crane_sim.models.guards import TAUT, Guard, decode, friction_event
from crane_sim.models.overhead import energies, layout_of, mode_of_stopped_axis, smallest_guard, switch
from crane_sim.models.overhead.double import DoubleCrane
from crane_sim.models.overhead.elastic import ElasticCrane, dimensions, node_vector
from crane_sim.models.overhead.modes import describe_switch, make_switching
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import RodCrane
from crane_sim.models.overhead.spatial import SpatialCrane
from crane_sim.models.overhead.spring import SpringCrane
from crane_sim.models.supports.actuation import actuated_entries, effort_tuple
from crane_sim.models.supports.friction import first_not_none, step_control_of
from crane_sim.models.supports.hoist import HOIST, PrescribedHoist, limit_hoist
from crane_sim.models.supports.rails import ForceAxis, PrescribedAxis, has_friction
from crane_sim.models.wind_kink import pressed_point, wind_kink_guard, with_kink_switching
from crane_sim.numerics.elementary import sincos
from crane_sim.numerics.jit import generic


@system.joints.register(PlanarCrane)
@system.joints.register(SpatialCrane)
@system.joints.register(ElasticCrane)
def _(p, x):
    nq, _, _ = layout_of(p)
    return x[:nq].copy(), x[nq : 2 * nq].copy()


@system.joints.register(DoubleCrane)
@system.joints.register(SpringCrane)
def _(p, x):
    return (x[0], x[1], x[2]), (x[3], x[4], x[5])


@system.state.register(DoubleCrane)
@system.state.register(SpringCrane)
def _(p, t, q, v):
    return (q[0], q[1], q[2], v[0], v[1], v[2], *meter_entry(p.energy_meter, 0.0))


@system.position_count.register(PlanarCrane)
@system.position_count.register(SpatialCrane)
@system.position_count.register(ElasticCrane)
def _(p):
    return layout_of(p)[0]


@system.acceleration.register(PlanarCrane)
@system.acceleration.register(SpatialCrane)
@system.acceleration.register(ElasticCrane)
def _(p, t, x, u):
    nq, _, _ = layout_of(p)
    return system.rhs(p, t, x, u)[nq : 2 * nq].copy()


@system.kinetic.register(PlanarCrane)
@system.kinetic.register(SpatialCrane)
@system.kinetic.register(ElasticCrane)
def _(p, x):
    return energies(p, x)[0]


@system.potential.register(PlanarCrane)
@system.potential.register(SpatialCrane)
@system.potential.register(ElasticCrane)
def _(p, x):
    return energies(p, x)[1]


@system.energy_supplied.register(RodCrane)
@system.energy_supplied.register(DoubleCrane)
@system.energy_supplied.register(SpringCrane)
@system.energy_supplied.register(PlanarCrane)
@system.energy_supplied.register(SpatialCrane)
@system.energy_supplied.register(ElasticCrane)
def _(p, x):
    nq, _, modes = layout_of(p)
    return x[2 * nq] if modes > 2 * nq else 0.0


@system.actuated_joints.register(RodCrane)
@system.actuated_joints.register(PlanarCrane)
def _(p, x):
    nq, _, _ = layout_of(p)
    return actuated_entries(p.trolley, None, p.hoist, x, 0, 1), actuated_entries(p.trolley, None, p.hoist, x, nq, 1)


@system.actuated_joints.register(DoubleCrane)
@system.actuated_joints.register(SpringCrane)
def _(p, x):
    return actuated_entries(p.trolley, None, None, x, 0, 1), actuated_entries(p.trolley, None, None, x, 3, 1)


@system.actuated_joints.register(SpatialCrane)
@system.actuated_joints.register(ElasticCrane)
def _(p, x):
    (nq, _, _), axes = layout_of(p), dimensions(p.bridge) - 1
    q = actuated_entries(p.trolley, p.bridge, p.hoist, x, 0, axes)
    return q, actuated_entries(p.trolley, p.bridge, p.hoist, x, nq, axes)


@system.efforts_from_row.register(RodCrane)
@system.efforts_from_row.register(PlanarCrane)
def _(p, row):
    return effort_tuple(p.trolley, None, p.hoist, row)


@system.efforts_from_row.register(DoubleCrane)
@system.efforts_from_row.register(SpringCrane)
def _(p, row):
    return effort_tuple(p.trolley, None, None, row)


@system.efforts_from_row.register(SpatialCrane)
@system.efforts_from_row.register(ElasticCrane)
def _(p, row):
    return effort_tuple(p.trolley, p.bridge, p.hoist, row)


@system.saturate.register(RodCrane)
@system.saturate.register(PlanarCrane)
@system.saturate.register(SpatialCrane)
@system.saturate.register(ElasticCrane)
def _(p, u):
    return limit_hoist(p.hoist, u)


@system.link_count.register(PlanarCrane)
@system.link_count.register(SpatialCrane)
@system.link_count.register(ElasticCrane)
def _(p):
    return len(p.cable.masses)


@system.point_count.register(RodCrane)
@system.point_count.register(DoubleCrane)
@system.point_count.register(SpringCrane)
@system.point_count.register(PlanarCrane)
@system.point_count.register(SpatialCrane)
@system.point_count.register(ElasticCrane)
def _(p):
    return 1 + system.link_count(p)


@system.switching.register(RodCrane)
def _(p):
    return switching_in_plane(p)


@system.switching.register(PlanarCrane)
def _(p):
    return with_kink_switching(p.wind, switching_in_plane(p))


@generic
def switching_in_plane(p):
    """Return the result of `system.switching` for a crane in the plane, without the kink of a wind."""
    rubs, step_control = (
        has_friction(p.trolley) or has_friction(p.hoist),
        first_not_none(step_control_of(p.trolley), step_control_of(p.hoist)),
    )
    return make_switching(p.event_limits, rubs, layout_of(p)[0], step_control)


@system.guard.register(PlanarCrane)
@system.guard.register(SpatialCrane)
@system.guard.register(ElasticCrane)
def _(p, t, x, u, work):
    return smallest_guard(p, t, x, system.effort(u, p, t, x), work)


@system.kink_guard.register(PlanarCrane)
@system.kink_guard.register(SpatialCrane)
@system.kink_guard.register(ElasticCrane)
def _(p, value, t0, x0, t, x):
    return wind_kink_guard(p.wind, p, value, t0, x0, t, x)


@pressed_point.register(PlanarCrane)
def _(p, x):
    nq, first, _ = layout_of(p)
    px, pz = x[0], 0.0
    for k in range(len(p.cable.masses)):
        length = p.cable.lengths[k] if k > 0 or first == 1 else x[1]
        s, c = sincos(x[first + k])
        px, pz = px + length * s, pz - length * c
    return px, 0.0, pz


@pressed_point.register(SpatialCrane)
def _(p, x):
    _, first, _ = layout_of(p)
    px, py, pz = x[0], x[1], 0.0
    for k in range(len(p.cable.masses)):
        length, i = p.cable.lengths[k] if k > 0 or first == 2 else x[2], first + 3 * k
        px, py, pz = px + length * x[i], py + length * x[i + 1], pz + length * x[i + 2]
    return px, py, pz


@pressed_point.register(ElasticCrane)
def _(p, x):
    return node_vector(p, x, len(p.cable.masses), 0)


@system.apply_reset_map.register(RodCrane)
@system.apply_reset_map.register(PlanarCrane)
@system.apply_reset_map.register(SpatialCrane)
@system.apply_reset_map.register(ElasticCrane)
def _(p, t, x, u, number):
    return switch(p, t, x, system.effort(u, p, t, x), number)


@switch.register(PlanarCrane)
@switch.register(SpatialCrane)
def _(p, t, x, tau, number):
    nq, first, modes = layout_of(p)
    kind, axis, _ = decode(number)
    x = x.copy()
    if kind == Guard.PAYLOAD:
        before = sum(energies(p, x))
        x[len(x) - 1] += 1.0
        x[2 * nq] += sum(energies(p, x)) - before  # the payload takes its energy along
        return x, number, True
    if kind == Guard.FRICTION:
        rate, mode = (nq + first - 1, len(x) - 2) if axis == HOIST else (nq + axis, modes + axis)
        mode_before = x[mode]
        x[rate], x[mode] = (0.0 if mode_before != 0.0 else x[rate]), 0.0
        x[mode] = mode_of_stopped_axis(p, t, x, tau, axis, mode_before)
        return x, friction_event(axis, x[mode]), True
    return x, number, False


@system.describe_event.register(RodCrane)
@system.describe_event.register(PlanarCrane)
@system.describe_event.register(SpatialCrane)
def _(p, number):
    return describe_switch(p.event_limits, number)


@system.describe_event.register(ElasticCrane)
def _(p, number):
    kind, link, outcome = decode(number)
    if kind == Guard.LINK:
        return f"link {link + 1} {'pulls' if outcome == TAUT else 'went slack'}", ""
    return describe_switch(p.event_limits, number)


@system.with_meter.register(RodCrane)
@system.with_meter.register(DoubleCrane)
@system.with_meter.register(PlanarCrane)
@system.with_meter.register(SpatialCrane)
def _(p, held):
    return p._replace(energy_meter=Meter()) if works_between_samples(p) or not held else p


@system.with_meter.register(SpringCrane)
@system.with_meter.register(ElasticCrane)
def _(p, held):
    return p._replace(energy_meter=Meter()) if np.any(p.cable.damping) or works_between_samples(p) or not held else p


def works_between_samples(p: Any) -> bool:
    """Return whether work is done besides that of held efforts at samples: by motions, friction, forces, base, wind."""
    parts = [getattr(p, name, None) for name in ("trolley", "bridge", "hoist")]
    imposed = any(isinstance(part, PrescribedAxis | PrescribedHoist) for part in parts)
    rubs = any(isinstance(part, ForceAxis) and part.friction is not None for part in parts)
    others = ("joints", "forces", "event_limits", "base", "wind")
    return imposed or rubs or any(getattr(p, name, None) is not None for name in others)
