"""What several models of overhead cranes answer alike: efforts of their drives, and the size of their cables."""

from crane_sim import system
from crane_sim.models.overhead.elastic import ElasticCrane
from crane_sim.models.overhead.planar import PlanarCrane
from crane_sim.models.overhead.rod import RodCrane
from crane_sim.models.overhead.spatial import SpatialCrane
from crane_sim.models.supports.actuation import effort_tuple, efforts_both
from crane_sim.models.supports.hoist import hoist_limited


@system.efforts_from_row.register(RodCrane)
@system.efforts_from_row.register(PlanarCrane)
def _(p, row):
    return effort_tuple(p.trolley, p.hoist, row)


@system.efforts_from_row.register(SpatialCrane)
@system.efforts_from_row.register(ElasticCrane)
def _(p, row):
    return efforts_both(p.trolley, p.bridge, p.hoist, row)


@system.saturate.register(RodCrane)
@system.saturate.register(PlanarCrane)
@system.saturate.register(SpatialCrane)
@system.saturate.register(ElasticCrane)
def _(p, u):
    return hoist_limited(p.hoist, u)


@system.link_count.register(PlanarCrane)
@system.link_count.register(SpatialCrane)
@system.link_count.register(ElasticCrane)
def _(p):
    return len(p.cable.masses)


@system.point_count.register(PlanarCrane)
@system.point_count.register(SpatialCrane)
@system.point_count.register(ElasticCrane)
def _(p):
    return 1 + len(p.cable.masses)
