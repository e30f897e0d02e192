"""Laws on a load on elastic falls: LQR brings it to rest at the target, others refuse it.

This holds below every support.
"""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import SceneError, acceleration, load_scene
from crane_sim.simulation.linearisation import equilibrium

ENDS = [[x, y, 0.0] for x in (0.2, -0.2) for y in (0.3, -0.3)]
COMMON = {
    "duration": 4.0,
    "falls": {
        "top": ENDS,
        "bottom": [[0.7 * x, 0.9 * y, 0.0] for x, y, _ in ENDS],
        "axial_stiffness": 4e4,
    },
    "payload": {"mass": 100.0, "inertia": [30.0, 20.0, 40.0], "attachment": [0.05, 0.02, 0.5]},
    "control": {"law": "lqr", "period": 0.05},
    "integrator": {"method": "dop853", "rtol": 1e-4, "atol": 1e-4},
}
# by 0.12 rad, 0.7 m
BENT = {"vertical": {"stiffness": 1e5}, "jib": {"mass": 50.0, "centre": 3, "inertia": 80}}
CRANES: dict[str, Any] = {
    "tower": {
        "slew": {"drive": "force", "inertia": 5e3},
        "trolley": {"mass": 80.0},
        "initial": {"q": [0.4, 6.0, 2.0]},
        "flexibility": BENT,
        "reference": {"q": [0.45, 6.2, 2.2]},
    },
    "pendulum": {
        "initial": {"tip": [1.0, 2.0, 3.0], "length": 2.0},
        "reference": {"q": [1.1, 2.1]},
    },
}


def scene(name: str, changes: Any = None) -> Any:
    """Return the scene of a crane that is to move its load to a target near by."""
    return load_scene({"crane": name} | COMMON | CRANES[name], changes or {})


@pytest.mark.parametrize("name", CRANES)
def test_lqr_brings_the_load_to_its_target(name: str) -> None:
    """Below any support the sampled law is stable, and all joints reach their target.

    This holds for one that the load bends, too.
    """
    crane = scene(name)
    law: Any = crane.law
    assert abs(law.poles).max() < 1.0
    run = crane_sim.simulate(crane)
    away = np.abs(run.q - law.target).max(axis=1)
    # the slowest mode takes 10 s: in 4 s the distance falls at least to a fifth, and nearly all
    # motion is gone
    assert away[-1] < 0.2 * away[0] and np.abs(run.v[-1]).max() < 0.1
    assert run.summary["min_rope_tension"] > 0.0


@pytest.mark.parametrize("law", ["energy", "adaptive", "anti_swing"])
@pytest.mark.parametrize("name", CRANES)
def test_laws_of_swing_angles_refuse_falls(name: str, law: str) -> None:
    """A law that needs swing angles of one rope is refused in one line that says why."""
    with pytest.raises(SceneError, match=rf"control.law = '{law}'") as error:
        scene(name, {"control": {"law": law}})
    line = str(error.value)
    assert "\n" not in line and "cannot be built" not in line
    assert any(
        part in line
        for part in (
            "there is none for",
            "the scene has falls",
            "not for crane",
            "swings by angles",
        )
    )


def test_lqr_linearises_an_untwisted_load() -> None:
    """From 40 m off, 20 m lower and a third of a turn, the load at the target rests.

    It faces ahead.

    Falls that are fastened apart have a second equilibrium, twisted by half a turn.
    """
    start = {
        "initial": {"length": 34.0, "trolley": 40.0, "skew": "120 deg"},
        "reference.q": [0.0, 2.0, 14.0],
    }
    gantry = load_scene("spreader_skew", start)
    q, u = equilibrium(gantry)
    # m/s²: rounding of falls that carry 0.5 MN
    assert np.abs(acceleration(gantry, q, 0.0 * q, u)).max() < 1e-8
    assert np.allclose(q[:3], gantry.reference) and q[6] > np.cos(np.radians(1.0))
