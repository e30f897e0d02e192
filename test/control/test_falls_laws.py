"""Laws on a load on elastic falls below every support: LQR brings it to rest at the target, others refuse it."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import SceneError, load_scene

ENDS = [[x, y, 0.0] for x in (0.2, -0.2) for y in (0.3, -0.3)]
COMMON = {
    "duration": 4.0,
    "falls": {"top": ENDS, "bottom": [[0.7 * x, 0.9 * y, 0.0] for x, y, _ in ENDS], "axial_stiffness": 4e4},
    "payload": {"mass": 100.0, "inertia": [30.0, 20.0, 40.0], "attachment": [0.05, 0.02, 0.5]},
    "control": {"law": "lqr", "period": 0.05},
    "integrator": {"method": "dop853", "rtol": 1e-4, "atol": 1e-4},
}
TOWER = {"slew": {"drive": "force", "inertia": 5e3}, "trolley": {"mass": 80.0}, "initial": {"q": [0.4, 6.0, 2.0]}}
BENT = {"vertical": {"stiffness": 1e5}, "jib": {"mass": 50.0, "centre": 3, "inertia": 80}}  # by 0.12 rad, 0.7 m
CRANES: dict[str, Any] = {
    "tower": TOWER | {"reference": {"q": [0.45, 6.2, 2.2]}},
    "bent tower": TOWER | {"crane": "tower", "flexibility": BENT, "reference": {"q": [0.45, 6.2, 2.2]}},
    "mobile": {
        "boom": {"mass": 100.0, "centre": 2.0, "inertia": 80.0},
        "superstructure": {"inertia": 600.0, "foot": [0.5, 1.2]},
        "telescope": {"mass": 60.0, "centre": 1.5, "inertia": 40.0},
        "initial": {"q": [0.4, 0.6, 7.0, 2.0]},
        "reference": {"q": [0.45, 0.62, 7.1, 2.2]},
    },
    "knuckle": {
        "boom": {"length": 5.0, "mass": 80.0, "inertia": 170.0},
        "jib": {"length": 4.0, "mass": 60.0, "inertia": 80.0},
        "tower": {"inertia": 200.0},
        "initial": {"q": [0.4, 0.6, -0.2, 2.0]},
        "reference": {"q": [0.45, 0.63, -0.17, 2.2]},
    },
    "pendulum": {"initial": {"tip": [1.0, 2.0, 3.0], "length": 2.0}, "reference": {"q": [1.1, 2.1]}},
}


def scene(name: str, changes: Any = None) -> Any:
    """Return the scene of a crane that is to move its load to a target near by."""
    return load_scene({"crane": name} | COMMON | CRANES[name], changes or {})


@pytest.mark.parametrize("name", CRANES)
def test_lqr_brings_the_load_to_its_target(name: str) -> None:
    """Below any support, also one that the load bends, the sampled law is stable and all joints reach their target."""
    crane = scene(name)
    law: Any = crane.law
    assert abs(law.poles).max() < 1.0
    run = crane_sim.simulate(crane)
    away = np.abs(run.q - law.target).max(axis=1)
    # the slowest mode takes 10 s: in 4 s the distance falls at least to a fifth, and nearly all motion is gone
    assert away[-1] < 0.2 * away[0] and np.abs(run.v[-1]).max() < 0.1
    assert run.summary["min_rope_tension"] > 0.0


@pytest.mark.parametrize("law", ["energy", "adaptive", "anti_swing"])
@pytest.mark.parametrize("name", ["tower", "mobile", "knuckle", "pendulum"])
def test_laws_of_swing_angles_refuse_falls(name: str, law: str) -> None:
    """A law that needs swing angles of one rope is refused in one line that says why."""
    with pytest.raises(SceneError, match=rf"control.law = '{law}'") as error:
        scene(name, {"control": {"law": law}})
    line = str(error.value)
    assert "\n" not in line and "cannot be built" not in line
    assert any(
        part in line for part in ("there is none for", "the scene has falls", "not for crane", "swings by angles")
    )
