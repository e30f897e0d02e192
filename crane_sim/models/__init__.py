"""Models of cranes: supports, cables, loads, the cranes composed of them, and closed forms that are faster.

Importing any module of this package imports all models, so that every model is registered with the functions of
`crane_sim.system`.
"""

from crane_sim.models import hanging
from crane_sim.models.elastic import bands
from crane_sim.models.falls import outputs as falls_outputs
from crane_sim.models.overhead import outputs as overhead_outputs
from crane_sim.models.overhead import planar_outputs
from crane_sim.models.single_rope import crane, modes
from crane_sim.models.suspended import joints, outputs

__all__ = [
    "bands",
    "crane",
    "falls_outputs",
    "hanging",
    "joints",
    "modes",
    "outputs",
    "overhead_outputs",
    "planar_outputs",
]
