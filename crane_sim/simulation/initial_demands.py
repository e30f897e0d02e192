"""Demands before a run starts, which a delay, a lag or a rate limit still has at t = 0.

A drive begins with what its scene says, else with what holds its joint: a force or torque carries
the weight on it, a position is the initial one, everything else is zero.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np

from crane_sim import system
from crane_sim.hardware.settings import HardwareConfig
from crane_sim.numerics.jit import entry_point, seldom_called
from crane_sim.scenes.scene import Scene

STEP = 1e-3
"""m or rad, of the differences that give a weight: their error is the fourth power of it."""


@entry_point
@seldom_called
def potential_at(p, q):
    """Return the potential energy [J] at joint positions q (nq,), as if the base were level."""
    return system.potential(p, system.state(p, 0.0, q, 0.0 * q))


def initial_demands(scene: Scene, config: HardwareConfig) -> dict[str, float]:
    """Return the demands before t = 0, by joint, of drives that remember one.

    They are in the units of commands.
    """
    demands = {}
    for i, (joint, drive) in enumerate(zip(scene.actuated, config.drives, strict=True)):
        if drive.delay or drive.lag or np.isfinite(drive.rate_limit):
            given = float(drive.initial_demand)
            demands[joint] = holding_demand(scene, i) if np.isnan(given) else given
    return demands


def holding_demand(scene: Scene, i: int) -> float:
    """Return the demand of actuated joint i that holds it in the scene's initial state."""
    at, unit = scene.joint_names.index(scene.actuated[i]), scene.command_units[i]
    if unit == scene.joint_units[at]:
        return scene.initial_q[at]
    return weight_on(scene.model, scene.initial_q, at) if unit in ("N", "N m") else 0.0


def weight_on(model: Any, q: Sequence[float], joint: int) -> float:
    """Return the effort [N or N m] that carries the weight on a joint at positions q (nq,).

    The other joints are fixed.
    """
    up, further = (_difference(model, q, joint, size) for size in (STEP, 2.0 * STEP))
    return (8.0 * up - further) / (12.0 * STEP)


def _difference(model: Any, q: Sequence[float], joint: int, size: float) -> float:
    """Return the potential energy [J] with a joint moved by `size`, less that moved by -`size`."""
    ahead, behind = np.array(q), np.array(q)
    ahead[joint] += size
    behind[joint] -= size
    return potential_at(model, ahead) - potential_at(model, behind)
