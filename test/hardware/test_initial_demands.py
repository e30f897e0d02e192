"""The start of drives: delay, lag, rate limit act on the first demand; drives hold their load."""

from math import exp, inf
from typing import Any

import numpy as np
import pytest

from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate

MASS, FORCE, END = 20.0, 10.0, 2.0  # kg, N, s
LATE_STEP: dict[str, Any] = {
    "crane": "overhead",
    "duration": END,
    "trolley": {"mass": MASS},
    "cable": {"lengths": [1.0], "node_masses": [1e-9]},
}
FOLLOWS = {"drive": "velocity", "servo": {"gain": inf, "max_acceleration": 1.0}}
# m: a = 0.5 (1 - exp(-t / 0.5)) m/s²
LAGGED = 0.5 * (END**2 / 2.0 - 0.5 * END + 0.25 * (1.0 - exp(-END / 0.5)))
STEPS: tuple[tuple[dict[str, Any], float, float], ...] = (  # (drive, step, m after 2 s)
    ({"delay": 0.5}, FORCE, 0.5625),
    ({"lag": 0.5}, FORCE, LAGGED),
    ({"rate_limit": 5.0}, FORCE, 1.0 / 3.0),
    ({"delay": 0.5, "lag": 1e-9}, FORCE, 0.5625),
    (FOLLOWS | {"delay": 0.5}, 1.0, 1.0),
    ({"delay": 0.5, "initial_demand": FORCE}, FORCE, 1.0),
    ({"lag": 0.5, "initial_demand": FORCE}, FORCE, 1.0),
)


@pytest.mark.parametrize(
    ("case", "by_law"),
    [
        (0, False),
        (0, True),
        (1, True),
        (2, False),
        (3, False),
        (4, True),
        (4, False),
        (5, True),
        (6, False),
    ],
)
def test_a_step_at_the_start(case: int, by_law: bool) -> None:
    """From rest the first demand passes the drive as a later one, unless the field says else.

    It is that of an input or of a law.
    """
    drive, step, position = STEPS[case]
    inputs = {} if by_law else {"inputs": {"trolley": {"kind": "constant", "value": step}}}
    law = (lambda t, q, v: (step,)) if by_law else None
    run = simulate(LATE_STEP | inputs | {"actuators": {"trolley": drive}}, law=law)
    # m, of the steps and of the nanogram of load
    assert run.q[-1, 0] == pytest.approx(position, abs=1e-8)
    assert run.summary["initial_demand"] == {"trolley": drive.get("initial_demand", 0.0)}


HOISTS: tuple[dict[str, Any], ...] = (
    {
        "crane": "overhead",
        "trolley": {"drive": "fixed"},
        "cable": {"lengths": [3.0], "node_masses": [10.0]},
        "hoist": {"drive": "force", "inertia": 20.0},
    },
    {
        "crane": "bridge",
        "trolley": {"mass": 600.0},
        "bridge": {"mass": 900.0},
        "rope": {"drive": "force"},
        "payload": {"mass": 2000.0},
        "initial": {"q": [0.0, 0.0, 8.0, 0.0, 0.0]},
    },
)


@pytest.mark.parametrize("lateness", [{"delay": 0.1}, {"lag": 0.1}, {"rate_limit": 1.0}], ids=str)
@pytest.mark.parametrize("document", HOISTS, ids=[document["crane"] for document in HOISTS])
def test_a_hoist_holds_its_load(document: dict[str, Any], lateness: dict[str, Any]) -> None:
    """A drum's drive carries the load, which stays where it is, until it gets another demand."""
    joint = "hoist" if "hoist" in document else "rope"
    scene = load_scene(document | {"duration": 0.1, "actuators": {joint: lateness}})
    mass = (
        document["cable"]["node_masses"][0] if "cable" in document else document["payload"]["mass"]
    )
    weight, index = mass * 9.81, scene.actuated.index(joint)
    command = tuple(-weight if name == joint else 0.0 for name in scene.actuated)
    run = simulate(scene, law=lambda t, q, v: command)
    # of the differences of an energy
    assert run.summary["initial_demand"][joint] == pytest.approx(-weight, rel=1e-10)
    assert run.q == pytest.approx(np.tile(run.q[0], (len(run.q), 1)), abs=1e-9)
    assert run.u[0, index] == pytest.approx(-weight, rel=1e-10)


def test_a_boom_holds_its_weight_and_a_position_is_kept() -> None:
    """Booms begin with the torques of their weights, of the load too.

    A point that is moved begins where it is.
    """
    boom = load_scene(
        "knuckle_setpoint", {"control": None, "reference": None, "actuators": {"all": {"lag": 0.2}}}
    )
    held = Plant(boom).summary()["initial_demand"]
    assert held["slew"] == pytest.approx(0.0, abs=1e-9) and held["boom"] > 0.0 > held["rope"]
    point = {"tip": [0.3, 0.1, 2.5]}
    servo = {
        "suspension": {"drive": "servo", "kp": 676.0, "kd": 36.4},
        "actuators": {"all": {"delay": 0.1}},
        "initial": point,
    }
    moved = load_scene("pendulum_free", servo)
    assert Plant(moved).summary()["initial_demand"] == {"tip_x": 0.3, "tip_y": 0.1}
