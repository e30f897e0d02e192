"""Payload faults: the same crane with a payload of another mass."""

from typing import NamedTuple

from crane_sim.models.falls.crane import FallsCrane
from crane_sim.models.overhead.double import DoubleCrane
from crane_sim.models.overhead.elastic import ElasticCrane
from crane_sim.models.overhead.modes import EventLimits
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import RodCrane
from crane_sim.models.overhead.spatial import SpatialCrane
from crane_sim.models.overhead.spring import SpringCrane
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.numerics.jit import generic
from crane_sim.numerics.states import replace_field


class PayloadFault(NamedTuple):
    """Marks a crane whose payload faults may change."""

    nominal_mass: float  # kg, of the payload without them


@generic
def apply_payload_fault(fault, p, mass):
    """Return the crane p with a payload of this mass [kg]; p itself in scenes without faults of the payload."""
    return p


@apply_payload_fault.register(PayloadFault)
def _(fault, p, mass):
    return replace_payload(p, mass)


@generic
def replace_payload(p, mass):
    """Return the crane p with a payload of this mass [kg]."""
    raise NotImplementedError


@generic
def replace_last(masses, mass):
    """Return an array of node masses with another last one."""
    masses = masses.copy()
    masses[len(masses) - 1] = mass
    return masses


@generic
def replace_event_masses(limits, mass):
    """Return the limits of the events of a crane with this payload [kg] from now on.

    All masses of scheduled changes become this one: scenes with faults of the payload have no events that change it.
    """
    return limits


@replace_event_masses.register(EventLimits)
def _(s, mass):
    masses = s.masses.copy()
    for i in range(len(masses)):
        masses[i] = mass
    return replace_field(s, "masses", masses)


@replace_payload.register(Crane)
@replace_payload.register(SuspendedCrane)
@replace_payload.register(FallsCrane)
def _(p, mass):
    return replace_field(p, "load", replace_field(p.load, "mass", mass))


@replace_payload.register(RodCrane)
def _(p, mass):
    p = replace_field(p, "cable", replace_field(p.cable, "payload", mass))
    return replace_field(p, "event_limits", replace_event_masses(p.event_limits, mass))


@replace_payload.register(DoubleCrane)
def _(p, mass):
    return replace_field(p, "cable", replace_field(p.cable, "mass2", mass))


@replace_payload.register(SpringCrane)
def _(p, mass):
    return replace_field(p, "cable", replace_field(p.cable, "mass", mass))


@replace_payload.register(PlanarCrane)
@replace_payload.register(SpatialCrane)
@replace_payload.register(ElasticCrane)
def _(p, mass):
    p = replace_field(p, "cable", replace_field(p.cable, "masses", replace_last(p.cable.masses, mass)))
    return replace_field(p, "event_limits", replace_event_masses(p.event_limits, mass))
