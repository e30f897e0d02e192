"""Models of cranes: supports, cables, loads, cranes composed of them, and faster closed forms.

Importing any module of this package imports all models, so that every model is registered with the
functions of `crane_sim.system`.
"""

from crane_sim.models.elastic import bands
from crane_sim.models.hanging import events
from crane_sim.models.overhead import outputs
from crane_sim.models.single_rope import crane, modes

__all__ = ["bands", "crane", "events", "modes", "outputs"]
