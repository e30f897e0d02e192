"""Scenes with a rigid load that general multibody engines model beside us, and their references."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from crane_bench.speed.cases import ReferenceSolution
from crane_bench.speed.crane_sim_engine import CraneSimEngine
from crane_bench.speed.engine import sweep_values
from crane_bench.speed.sweep import angle_between
from crane_sim.integrators.dop853 import DOP853, RK8
from crane_sim.scenes.scene import Scene, load_scene


class BodyCase(NamedTuple):
    """One of the scenes."""

    id: str
    scene: str  # of the catalogue
    title: str
    changes: Mapping[str, Any] = {}  # of the scene, by dotted key


_TORQUE = {
    "kind": "table",
    "times": [0, 2, 8, 10, 30, 32, 38, 40],
    "values": [0, 6e4, 6e4, 0, 0, -6e4, -6e4, 0],
}
_FORCE = {
    "kind": "table",
    "times": [0, 2, 6, 8, 24, 26, 30, 32],
    "values": [0, 500, 500, 0, 0, -1000, -1000, 0],
}
_RATE = {"kind": "table", "times": [0, 10, 12, 20, 22], "values": [0, 0, -0.3, -0.3, 0]}
_RAMPS = {"slew": _TORQUE, "trolley": _FORCE, "rope": _RATE}
_NO_LAW = {
    "control": None,
    "reference": None,
    "actuators": {},
    "wind": None,
    "payload.windage": None,
}

CASES = (
    BodyCase("hook", "bridge_hook_and_sling", "bridge crane, a body on hook block and sling"),
    BodyCase("falls", "spreader_skew", "a body on four elastic falls, let go at a skew"),
    BodyCase(
        "slew",
        "tower_gust",
        "tower crane under ramps, without wind and law",
        _NO_LAW | {"inputs": _RAMPS},
    ),
)
FINE = (RK8(1.0 / 128.0), DOP853(1e-12, 1e-14))
"""Two methods whose difference at the end bounds the error of the first one, the reference; its
steps end at kinks."""
STEPS = [1.0 / round(1.0 / step) for step in sweep_values(0.5, 1.0 / 512.0, 6)]
"""Our steps [s]: whole parts of a second, as the kinks of all inputs are at whole seconds."""


def body_scene(case: BodyCase) -> Scene:
    """Return the scene of a case."""
    return load_scene(case.scene, case.changes)


def make_reference(simulator: CraneSimEngine) -> tuple[ReferenceSolution, float]:
    """Return (the reference, the bound of its attitude's error [rad])."""
    best, other = (simulator.make_run(method)(1) for method in FINE)
    bound = float(np.linalg.norm(best.payload - other.payload))
    assert best.attitude is not None and other.attitude is not None
    return ReferenceSolution(best.payload, bound, None, best.attitude), angle_between(
        best.attitude, other.attitude
    )
