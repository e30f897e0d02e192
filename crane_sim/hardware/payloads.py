"""Payload faults: the same crane with a payload of another mass."""

from typing import NamedTuple


class PayloadFault(NamedTuple):
    """Marks a crane whose payload faults may change."""

    nominal_mass: float  # kg, of the payload without them


def apply_payload_fault(fault, p, mass):
    """Return the crane p with a payload of this mass [kg].

    Scenes without faults of the payload have p itself.

    All masses of scheduled changes become this one: scenes with faults of the payload have no
    events that change it.
    """
    if fault is None:
        return p
    if hasattr(p, "load"):
        return p._replace(load=p.load._replace(mass=mass))
    p = p._replace(cable=p.cable.with_payload(mass))
    if getattr(p, "event_limits", None) is None:
        return p
    masses = p.event_limits.masses.copy()
    masses[:] = mass
    return p._replace(event_limits=p.event_limits._replace(masses=masses))
