"""Scenes of overhead cranes in space, and planar references turned about the vertical."""

import json
from pathlib import Path
from typing import Any

import numpy as np

import crane_sim
from crane_sim.simulation.rollout import Rollout

DATA = Path(__file__).parents[1] / "data"
REFERENCE = json.loads((DATA / "chain.json").read_text()) | json.loads(
    (DATA / "overhead.json").read_text()
)
TIGHT = {"method": "dop853", "rtol": 1e-13, "atol": 1e-14}


def sine(form: Any = 0.0) -> dict[str, Any]:
    """Return an input from a reference's description, of one kind for all.

    Every other kind would compile a scene anew.
    """
    return {"kind": "sine", "amplitude": 0.0, "frequency": 1.0} | (form or {})


def scene_of(
    masses: Any, lengths: Any, directions: Any, rates: Any = None, **groups: Any
) -> crane_sim.Scene:
    """Return the scene of a chain below a trolley (5 kg) on a bridge (3 kg).

    `groups` replace these.
    """
    document = {
        "crane": "overhead",
        "dimensions": 3,
        "duration": 1.0,
        "trolley": {"drive": "force", "mass": 5.0},
        "bridge": {"drive": "force", "mass": 3.0},
        "cable": {"model": "rigid", "lengths": list(lengths), "node_masses": list(masses)},
        "initial": {"directions": directions, "rates": rates},
        "inputs": {"trolley": sine(), "bridge": sine()},
        "integrator": TIGHT,
    }
    return crane_sim.load_scene(document | groups)


def turned(name: str, azimuth: float, **groups: Any) -> crane_sim.Scene:
    """Return a planar reference at an azimuth [rad]: a massless bridge favours no axis.

    It moves in the vertical plane at this azimuth.
    """
    case = REFERENCE[name]
    spec, (c, s) = case["spec"], (np.cos(azimuth), np.sin(azimuth))
    a, w = np.array(spec["alpha0"]), np.array(spec["alphadot0"])
    directions = np.stack([np.sin(a) * c, np.sin(a) * s, -np.cos(a)], axis=1)
    rates = w[:, None] * np.stack([np.cos(a) * c, np.cos(a) * s, np.sin(a)], axis=1)
    force = sine(spec["F"])
    replaced = {
        "trolley": {"drive": "force", "mass": spec["trolley_mass"]},
        "bridge": {"drive": "force", "mass": 0.0},
        "inputs": {
            "trolley": force | {"amplitude": c * force["amplitude"]},
            "bridge": force | {"amplitude": s * force["amplitude"]},
        },
        "duration": case["t"][-1],
    }
    return scene_of(
        spec["m_i"], spec["l_i"], directions.tolist(), rates.tolist(), **replaced | groups
    )


def error_in_tolerances(run: Rollout, name: str, azimuth: float = 0.0) -> float:
    """Return the nodes' largest position error at a reference's instants by its tolerance [m]."""
    case, (c, s) = REFERENCE[name], (np.cos(azimuth), np.sin(azimuth))
    expected = np.array(case["node_positions_xyz"])
    rotated = np.stack(
        [c * expected[..., 0] - s * expected[..., 1], s * expected[..., 0], expected[..., 2]],
        axis=-1,
    )
    reference = expected if azimuth == 0.0 else rotated
    # 1e-9 m: the integrator's 1e-13 a step, a thousand steps, and the growth of errors along the
    # motion
    return float(
        np.max(np.abs(run.nodes[:, 1:] - reference)) / max(1e-9, 10.0 * case["trusted_abs_error_m"])
    )
