"""Payload faults: the same crane with a payload of another mass."""

from typing import NamedTuple

from crane_sim.models.overhead.double import DoubleCrane
from crane_sim.models.overhead.rod import RodCrane
from crane_sim.models.overhead.spring import SpringCrane


class PayloadFault(NamedTuple):
    """Marks a crane whose payload faults may change."""

    nominal_mass: float  # kg, of the payload without them


def apply_payload_fault(fault, p, mass):
    """Return the crane p with a payload of this mass [kg]; p itself in scenes without faults of the payload.

    All masses of scheduled changes become this one: scenes with faults of the payload have no events that change it.
    """
    if fault is None:
        return p
    if hasattr(p, "load"):
        return p._replace(load=p.load._replace(mass=mass))
    p = p._replace(cable=replace_payload(p, mass))
    if getattr(p, "event_limits", None) is None:
        return p
    masses = p.event_limits.masses.copy()
    masses[:] = mass
    return p._replace(event_limits=p.event_limits._replace(masses=masses))


def replace_payload(p, mass):
    """Return the cable of an overhead crane with another payload [kg]."""
    if isinstance(p, DoubleCrane):
        return p.cable._replace(mass2=mass)
    if isinstance(p, SpringCrane):
        return p.cable._replace(mass=mass)
    if isinstance(p, RodCrane):
        return p.cable._replace(payload=mass)
    if isinstance(p.cable.masses, tuple):
        return p.cable._replace(masses=(*p.cable.masses[:-1], mass))
    masses = p.cable.masses.copy()
    masses[len(masses) - 1] = mass
    return p.cable._replace(masses=masses)
