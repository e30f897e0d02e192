"""An accurate and fast crane simulator of ROS 2 nodes.

    scene = crane_sim.load_scene("knuckle_setpoint")
    run = crane_sim.simulate(scene)
    run.t, run.q, run.v, run.u, run.payload, run.summary

Names are imported when they are first used, so that a node pays only for what it needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from crane_sim.batch import Batch, simulate_batch
    from crane_sim.explain import SceneError
    from crane_sim.functions import acceleration, energy
    from crane_sim.plant import SimulationError
    from crane_sim.rollout import Rollout, simulate
    from crane_sim.scene import Scene, load_scene

_HOMES = {
    "Batch": "batch",
    "simulate_batch": "batch",
    "SceneError": "explain",
    "acceleration": "functions",
    "energy": "functions",
    "SimulationError": "plant",
    "Scene": "scene",
    "load_scene": "scene",
    "Rollout": "rollout",
    "simulate": "rollout",
}
__all__ = [
    "Batch",
    "Rollout",
    "Scene",
    "SceneError",
    "SimulationError",
    "acceleration",
    "energy",
    "load_scene",
    "simulate",
    "simulate_batch",
]


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'crane_sim' has no attribute {name!r}")
    return getattr(import_module(f"crane_sim.{_HOMES[name]}"), name)
