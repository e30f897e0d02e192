"""Another payload below the same crane."""

from typing import NamedTuple

from crane_sim.models.cables.chain import Chain
from crane_sim.models.loads import PointLoad
from crane_sim.models.overhead.double import DoubleCrane, Pair
from crane_sim.models.overhead.elastic import ElasticCrane, Springs
from crane_sim.models.overhead.modes import Switches
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import Line, RodCrane
from crane_sim.models.overhead.spatial import SpatialCrane
from crane_sim.models.overhead.spring import Spring, SpringCrane
from crane_sim.models.single_rope.crane import Crane
from crane_sim.numerics.jit import generic


class PayloadFault(NamedTuple):
    """The presence of faults that change the payload."""

    mass: float  # kg, of the payload without them


@generic
def with_payload(reload, p, mass):
    """Return the crane p with a payload of this mass [kg]; as it is where no fault changes it."""
    return p


@with_payload.register(PayloadFault)
def _(reload, p, mass):
    return replace_payload(p, mass)


@generic
def replace_payload(p, mass):
    """Return the crane p with a payload of this mass [kg]."""
    raise NotImplementedError


@generic
def last_replaced(masses, mass):
    """Return an array of node masses with another last one."""
    masses = masses.copy()
    masses[len(masses) - 1] = mass
    return masses


@generic
def switches_with(switches, mass):
    """Return the switches of a crane with this payload."""
    return switches


@switches_with.register(Switches)
def _(s, mass):
    masses = s.masses.copy()
    for i in range(len(masses)):
        masses[i] = mass
    return Switches(s.lower, s.upper, s.shortest, s.longest, s.taut, s.times, masses)


@replace_payload.register(Crane)
def _(p, mass):
    load, friction = PointLoad(mass), p.swing_friction
    return Crane(p.support, p.cable, load, p.gravity, friction, p.drag, p.meter, p.base, p.force, p.stops)


@replace_payload.register(RodCrane)
def _(p, mass):
    c = p.cable
    cable = Line(c.length, c.mass, c.first, c.second, mass, c.reach, c.nodes)
    return RodCrane(p.trolley, cable, p.hoist, p.gravity, switches_with(p.switches, mass), p.meter)


@replace_payload.register(DoubleCrane)
def _(p, mass):
    c = p.cable
    return DoubleCrane(p.trolley, Pair(c.mass1, mass, c.length1, c.length2), p.gravity, p.meter)


@replace_payload.register(SpringCrane)
def _(p, mass):
    c = p.cable
    return SpringCrane(p.trolley, Spring(mass, c.length, c.stiffness, c.damping), p.gravity, p.meter)


@replace_payload.register(PlanarCrane)
def _(p, mass):
    cable, switches = Chain(last_replaced(p.cable.masses, mass), p.cable.lengths), switches_with(p.switches, mass)
    return PlanarCrane(p.trolley, cable, p.hoist, p.gravity, p.joints, p.rods, p.forces, switches, p.meter, p.base)


@replace_payload.register(SpatialCrane)
def _(p, mass):
    cable, switches = Chain(last_replaced(p.cable.masses, mass), p.cable.lengths), switches_with(p.switches, mass)
    axes = p.trolley, p.bridge
    return SpatialCrane(*axes, cable, p.hoist, p.gravity, p.forces, switches, p.meter, p.base, p.share)


@replace_payload.register(ElasticCrane)
def _(p, mass):
    c, switches = p.cable, switches_with(p.switches, mass)
    cable = Springs(last_replaced(c.masses, mass), c.lengths, c.stiffness, c.damping, c.tension_only)
    return ElasticCrane(p.trolley, p.bridge, cable, p.hoist, p.gravity, p.forces, switches, p.meter, p.base, p.share)
