"""When an overhead crane needs a meter: the work of held efforts follows from samples, all other work does not."""

from typing import Any

from crane_sim.meter import Meter
from crane_sim.overhead.axes import ForceAxis, PrescribedAxis
from crane_sim.overhead.hoists import PrescribedHoist


def metered(p: Any, held: bool) -> Any:
    """Return the model with a meter where held efforts do not tell all the energy supplied."""
    parts = [getattr(p, name, None) for name in ("trolley", "bridge", "hoist")]
    imposed = any(isinstance(part, PrescribedAxis | PrescribedHoist) for part in parts)
    rubs = any(isinstance(part, ForceAxis) and part.friction is not None for part in parts)
    others = any(getattr(p, name, None) is not None for name in ("joints", "forces", "switches", "base"))
    return p._replace(meter=Meter()) if imposed or rubs or others or not held else p
