"""An accurate and fast crane simulator of ROS 2 nodes.

    scene = crane_sim.load_scene("knuckle_setpoint")
    run = crane_sim.simulate(scene)
    run.t, run.q, run.v, run.u, run.payload, run.summary

load_scene: a scene from a name of the catalogue, a file or a dict, checked.
simulate: one run of a scene; simulate_batch: many, that differ in parameters.
compare: runs of one crane side by side, metrics and differences.
read_recording: a recorded run, as arrays with the names of simulate's; run.plot(), run.show(),
run.to_dataframe().
acceleration, energy: the equations of a scene; linearise: its linear ones about rest; export_c:
them as C source.
identify: parameters of a scene from a recording or a ROS bag of a rig, with confidence intervals.
study.run: many runs as one table (import crane_sim.study).
SceneError: an invalid scene; SimulationError: a run that could not go on.

`__version__` is the version of this package.

Names are imported when they are first used, so that a node pays only for what it needs.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from crane_sim.files.errors import SceneError
    from crane_sim.identification.estimation import Identification, identify
    from crane_sim.recording.comparison import Comparison, compare
    from crane_sim.recording.read import read_recording
    from crane_sim.recording.run import RecordedRun
    from crane_sim.scenes.scene import Scene, load_scene
    from crane_sim.simulation.batch import Batch, simulate_batch
    from crane_sim.simulation.c_export import export_c
    from crane_sim.simulation.dynamics import acceleration, energy
    from crane_sim.simulation.linear_model import LinearModel, linearise
    from crane_sim.simulation.plant import SimulationError
    from crane_sim.simulation.rollout import Rollout, simulate

_HOMES = {
    "Identification": "crane_sim.identification.estimation",
    "identify": "crane_sim.identification.estimation",
    "LinearModel": "crane_sim.simulation.linear_model",
    "linearise": "crane_sim.simulation.linear_model",
    "Batch": "crane_sim.simulation.batch",
    "simulate_batch": "crane_sim.simulation.batch",
    "Comparison": "crane_sim.recording.comparison",
    "compare": "crane_sim.recording.comparison",
    "SceneError": "crane_sim.files.errors",
    "acceleration": "crane_sim.simulation.dynamics",
    "energy": "crane_sim.simulation.dynamics",
    "export_c": "crane_sim.simulation.c_export",
    "SimulationError": "crane_sim.simulation.plant",
    "Scene": "crane_sim.scenes.scene",
    "load_scene": "crane_sim.scenes.scene",
    "RecordedRun": "crane_sim.recording.run",
    "read_recording": "crane_sim.recording.read",
    "Rollout": "crane_sim.simulation.rollout",
    "simulate": "crane_sim.simulation.rollout",
}
__all__ = [
    "Batch",
    "Comparison",
    "Identification",
    "LinearModel",
    "RecordedRun",
    "Rollout",
    "Scene",
    "SceneError",
    "SimulationError",
    "acceleration",
    "compare",
    "energy",
    "export_c",
    "identify",
    "linearise",
    "load_scene",
    "read_recording",
    "simulate",
    "simulate_batch",
]


def __dir__() -> list[str]:
    return sorted([*__all__, *(name for name in globals() if name.startswith("__"))])


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version(__name__)
    if name not in _HOMES:
        raise AttributeError(f"module 'crane_sim' has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)
