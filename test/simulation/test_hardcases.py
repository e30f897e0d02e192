"""The catalogue's hard cases against extended precision, and where models stop being valid."""

import numpy as np
import pytest

import crane_sim
from crane_bench.reproduce import hardcases
from crane_sim.simulation.rollout import simulate

REFERENCES = hardcases.hardcase_references()
ELSEWHERE = """overhead_drum overhead_friction_chain overhead_hoist_chain overhead_winch_hook overhead_drop
overhead_steel overhead_spring overhead_pole overhead_pole_chain overhead_spatial overhead_elastic_free overhead_bounce
overhead_bounce_chain overhead_toss overhead_toss_chain overhead_coulomb overhead_rods overhead_winch
knuckle_springs overhead_joints""".split()  # noqa: E501
"""Kinds of crane whose compilation takes long, and that other tests compile in other
combinations."""
SCENES = [
    pytest.param(name, marks=pytest.mark.slow if name in ELSEWHERE else ()) for name in REFERENCES
]


@pytest.mark.long(cases=["overhead_hoist", "overhead_friction", "overhead_chain"])
@pytest.mark.parametrize("scene", SCENES)
def test_a_hard_case_meets_its_reference(scene: str) -> None:
    """All nodes stay within the case's bound at all times, and events happen when they should."""
    case = hardcases.measure_case(scene, REFERENCES[scene])
    assert case.verdict == "holds", case


@pytest.mark.slow
def test_the_tension_of_a_stiff_rope() -> None:
    """The axial vibration of a rope of 1e6 N/m is in phase with its reference after 5500 rad."""
    run = simulate("overhead_spring", sample_times=REFERENCES["overhead_spring"]["t"])
    expected = np.array(REFERENCES["overhead_spring"]["tension"])[:, 0]
    # the bound of 1e-9 m of the positions, times 1e6 N/m; it swings by 390 N
    assert np.ptp(expected) > 300.0 and np.max(np.abs(run.tension - expected)) < 1e-3


def test_heavy_payload_accelerations() -> None:
    """Thirty links below a payload of 1e8 nodes accelerate as 60 digits say, to 1e-12."""
    assert hardcases.heavy_accelerations().verdict == "holds"


@pytest.mark.long
def test_energy_over_a_million_steps() -> None:
    """The long-horizon method keeps a double pendulum's energy to 1e-9 over a million steps."""
    assert hardcases.long_energy().verdict == "holds"


@pytest.mark.parametrize(
    ("scene", "message"),
    [
        (
            "overhead_slack",
            "link 1 went slack, and a rigid link must be taut; take cable.model: elastic",
        ),
        (
            "overhead_limits",
            "the trolley reached its travel limit; change trolley.limits, or what drives the "
            "trolley",
        ),
    ],
)
def test_a_model_that_is_no_longer_valid_ends_the_run(scene: str, message: str) -> None:
    """The run stops with time, cause and remedy in one line, and everything up to there is kept."""
    with pytest.raises(crane_sim.SimulationError) as caught:
        simulate(scene)
    run = caught.value.run
    assert message in str(caught.value) and "\n" not in str(caught.value)
    stopped = run.events[-1][0]
    assert run.t[-1] <= stopped < run.t[-1] + run.scene.period and len(run.t) > 10
    assert np.all(np.isfinite(run.q)) and run.summary["steps"] == len(run.t) - 1


def test_a_light_straight_cable_is_chosen_and_its_error_estimated() -> None:
    """Model auto takes a straight cable for a rod, says so, and its estimate bounds the error.

    The error is the payload's true one.
    """
    cable = {"links": 10, "lengths": 0.3, "node_masses": 0.01}
    document = {
        "crane": "overhead",
        "duration": 3.0,
        "trolley": {"mass": 50.0},
        "payload": {"mass": 100.0},
        "initial": {"angles": 0.4},
    }
    rod, links = (
        simulate(document | {"cable": cable | {"model": model}}) for model in ("auto", "rigid")
    )
    error = np.max(np.linalg.norm(rod.payload - links.payload, axis=1))
    assert rod.summary["model"] == "straight" and len(rod.scene.joint_names) == 2
    assert error < rod.summary["model_error_estimate"] < 10.0 * error


def test_a_bent_cable_is_not_taken_for_a_rod() -> None:
    """Model auto keeps rigid links where the cable starts bent or is not light."""
    cable = {"model": "auto", "links": 3, "lengths": 1.0, "node_masses": 0.01}
    scene = {
        "crane": "overhead",
        "duration": 1.0,
        "trolley": {"mass": 5.0},
        "payload": {"mass": 100.0},
    }
    bent = crane_sim.load_scene(scene | {"cable": cable, "initial": {"angles": [0.1, 0.2, 0.3]}})
    heavy = crane_sim.load_scene(
        scene | {"cable": cable | {"node_masses": 1.0}, "initial": {"angles": 0.1}}
    )
    assert bent.notes["model"] == heavy.notes["model"] == "rigid"


def test_a_step_that_the_stiffest_motion_cannot_bear_is_rejected() -> None:
    """A fixed step beyond the safe one is an error that names it; the safe one stays finite."""
    with pytest.raises(
        crane_sim.SceneError, match="too large for the stiffest motion, .* safe step"
    ) as caught:
        crane_sim.load_scene("overhead_chain", {"integrator": {"method": "rk4", "step": 0.01}})
    safe = float(str(caught.value).split("method is ")[1].split(" s")[0])
    run = simulate(
        crane_sim.load_scene(
            "overhead_chain", {"integrator": {"method": "rk4", "step": 0.99 * safe}}
        )
    )
    # half of what is stable
    assert np.all(np.isfinite(run.q)) and run.summary["energy_audit_error"] < 1e-2
