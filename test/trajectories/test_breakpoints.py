"""Functions of time that begin late or last short are not stepped over by a crane at rest."""

from typing import Any

import numpy as np
import pytest

from crane_sim import load_scene, simulate, simulate_batch
from crane_sim.simulation.plant import Plant

TROLLEY, PAYLOAD, ROPE = 50.0, 100.0, 5.0  # kg, kg, m
PULSE = {"kind": "table", "times": [6.0, 6.02, 6.04], "values": [0.0, 5000.0, 0.0]}  # s, N


def scene(**groups: Any) -> dict[str, Any]:
    """Return a scene of a crane at rest with further groups."""
    cable = {"lengths": [ROPE], "node_masses": [PAYLOAD]}
    return {"crane": "overhead", "duration": 6.5, "cable": cable} | groups


def late_motion(method: str, start: float = 6.0) -> dict[str, Any]:
    """Return a scene whose trolley moves a tenth of a metre, from `start` on, for 0.2 s."""
    motion = {"kind": "smooth", "from": 0.0, "to": 0.1, "start": start, "duration": 0.2}
    return scene(trolley={"drive": "prescribed", "motion": motion}, integrator={"method": method})


@pytest.mark.parametrize("method", ["dop853", "dopri5", "gauss16"])
def test_a_motion_after_a_rest_takes_place(method: str) -> None:
    """A crane that rested for 6 s follows its prescribed trolley, and rests in every row before."""
    run = simulate(late_motion(method))
    before, after = run.t <= 6.0, run.t >= 6.2
    assert np.all(run.q[before] == 0.0)
    # m: the trolley is integrated with the payload
    assert run.q[after, 0] == pytest.approx(0.1, abs=1e-9)
    assert np.abs(run.q[after, 1]).max() > 1e-3  # rad: the payload swings


def test_a_short_pulse_has_its_impulse() -> None:
    """After a pulse of force the crane's momentum is its integral, to the steps' tolerance."""
    run = simulate(scene(trolley={"drive": "force", "mass": TROLLEY}, inputs={"trolley": PULSE}))
    (speed, rate), angle = run.v[-1], run.q[-1, 1]
    momentum = (TROLLEY + PAYLOAD) * speed + PAYLOAD * ROPE * np.cos(angle) * rate
    assert momentum == pytest.approx(5000.0 * 0.02, rel=1e-8)  # N s; steps are accurate to 1e-11


def test_a_motion_that_jumps_in_acceleration_costs_no_search() -> None:
    """Steps up to a spline's first instant do not see its acceleration.

    If they did, they would search for it in 3300 evaluations.
    """
    motion = {"kind": "table", "times": [6.0, 6.2, 6.4], "values": [0.0, 0.1, 0.0]}
    run = simulate(scene(trolley={"drive": "prescribed", "motion": motion}))
    assert run.q[-1, 0] == pytest.approx(0.0, abs=1e-12) and run.summary["rhs_evaluations"] < 1000


def test_brakes_that_are_released_give_the_inputs_back() -> None:
    """A plant without hardware that has braked follows its inputs again, a table's or none."""
    for document in (
        late_motion("dop853"),
        scene(trolley={"drive": "force", "mass": TROLLEY}, inputs={"trolley": PULSE}),
    ):
        plant = Plant(load_scene(document))
        for braking in (False, True, False):
            plant.braking = braking
            plant.advance()
        assert plant.k == 3 and np.all(np.isfinite(plant.q))


def test_plant_and_batch_take_the_same_steps() -> None:
    """A plant by periods and cranes in a batch end in the states of `simulate` bit for bit."""
    document = late_motion("dop853")
    run, plant = simulate(document), Plant(load_scene(document))
    for _ in range(load_scene(document).steps):
        plant.advance()
    assert np.array_equal(plant.q, run.q[-1]) and np.array_equal(plant.v, run.v[-1])
    batch = simulate_batch(document, {"trolley.motion.start": [6.0, 6.1]})
    assert np.array_equal(batch.q[0], run.q[-1]) and batch.q[1, 0] == pytest.approx(0.1, abs=1e-9)
