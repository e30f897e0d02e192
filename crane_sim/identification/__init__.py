"""Identification: parameters of a scene from a measured run, with confidence intervals.

    data = read_measurements("runs/rig.mcap", crane_sim.load_scene("overhead_energy"))
    result = identify("overhead_energy", data, ["cable.lengths.0", "trolley.mass"])
    result.estimates, result.correlation, result.warnings

`measurements` reads positions and commands, `shooting` predicts them with their sensitivities,
`estimation` fits.
"""

from crane_sim.identification.estimation import Estimate, Identification, identify
from crane_sim.identification.measurements import (
    Measurements,
    from_recording,
    from_rollout,
    read_measurements,
)

__all__ = [
    "Estimate",
    "Identification",
    "Measurements",
    "from_recording",
    "from_rollout",
    "identify",
    "read_measurements",
]
