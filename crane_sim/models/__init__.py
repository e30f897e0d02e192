"""Models of cranes: supports, cables, loads, the cranes composed of them, and closed forms that are faster.

Importing any module of this package imports all models, so that every model is registered with the functions of
`crane_sim.system`.
"""

from crane_sim.models.overhead import (
    base_energies,
    base_load,
    double,
    elastic,
    elastic_jacobian,
    elastic_outputs,
    node_forces,
    planar,
    rod,
    shared_bodies,
    spatial,
    spring,
)
from crane_sim.models.single_rope import crane, joint_coordinates, modes

__all__ = [
    "base_energies",
    "base_load",
    "crane",
    "double",
    "elastic",
    "elastic_jacobian",
    "elastic_outputs",
    "joint_coordinates",
    "modes",
    "node_forces",
    "planar",
    "rod",
    "shared_bodies",
    "spatial",
    "spring",
]
