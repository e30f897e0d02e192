"""Faults: effect and schedule of each, and runs with all hardware, equal by every way to run."""

from typing import Any

import numpy as np
import pytest
from hardware_scenes import MASS, history, rod

from crane_sim import orchestration
from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.batch import simulate_batch
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate

BENCH = "overhead_bench"
COARSE = {"integrator": {"method": "rk4", "step": 0.005}}
"""The method of `rod`: another one would be compiled as well."""


def constant(t: float) -> float:
    """Return the demand of 4 N."""
    return 4.0


def test_faults_of_sensors_and_drives() -> None:
    """A stuck sensor repeats its last value, a lost one shows 0.

    Weak drives have the product of their factors.

    Each acts only while it is active.
    """
    faults = {
        "frozen": {"kind": "sensor_stuck", "joint": "trolley", "at": 0.1, "until": 0.2},
        "blind": {"kind": "sensor_loss", "joint": "swing_1", "at": 0.145, "until": 0.3},
        "weak": {
            "kind": "effort_loss",
            "joint": "trolley",
            "factor": 0.25,
            "at": 0.2,
            "until": 0.4,
        },
        "hot": {"kind": "effort_loss", "joint": "trolley", "factor": 0.5, "at": 0.3, "until": 0.5},
    }
    true, measured, applied = history(rod(faults=faults), 60, constant)
    k = np.arange(60)
    frozen, blind = (k >= 10) & (k < 20), (k >= 15) & (k < 30)
    weak, hot = (k >= 20) & (k < 40), (k >= 30) & (k < 50)
    assert np.array_equal(measured[:, 0], np.where(frozen, true[9, 0], true[:, 0]))
    assert np.array_equal(measured[:, [1, 3]], np.where(blind[:, None], 0.0, true[:, [1, 3]]))
    assert np.array_equal(applied, 4.0 * np.where(weak, 0.25, 1.0) * np.where(hot, 0.5, 1.0))


def test_a_stuck_joint_stops_and_is_freed() -> None:
    """A joint held by its brake rests whatever is commanded, and moves when the fault ends."""
    held = {"kind": "stuck", "joint": "trolley", "at": 1.0, "until": 2.0}
    true, _, applied = history(rod(faults={"held": held}), 300, lambda t: 12.0)
    # the payload swings, and bends the brake
    assert abs(true[95, 2]) > 0.3 and np.max(abs(true[160:200, 2])) < 5e-3
    assert np.max(abs(true[160:200, 1])) > 0.02
    assert true[250, 2] > 0.3 and set(applied[:100]) == set(applied[200:]) == {12.0}


def test_another_payload() -> None:
    """After a change the crane moves as with the other payload; the energy audit counts it."""
    plant, reference = (
        Plant(rod(faults={"drop": MASS | {"at": 0.5}})),
        Plant(rod(payload={"mass": 2.0})),
    )
    for _ in range(50):
        plant.advance((4.0,))
    reference.reset(plant.q, plant.v)
    for _ in range(100):
        plant.advance((4.0,))
        reference.advance((4.0,))
    assert plant.q == pytest.approx(reference.q, abs=1e-12) and plant.v == pytest.approx(
        reference.v, abs=1e-12
    )
    summary = plant.summary()
    # the method's own error; 0.8 if the change's energy were not counted
    assert summary["energy_audit_max"] < 1e-6
    assert summary["faults"] == [{"t": 0.5, "name": "drop", "on": True}]


def test_manually_set_faults() -> None:
    """A fault without time needs an override; overrides outrank schedules, a reset clears them."""
    plant = Plant(rod(faults={"late": {"kind": "sensor_loss", "joint": "trolley"}}))
    for on in (False, True, False):
        plant.set_fault("late", on)
        plant.advance((4.0,))
        assert (plant.seen[0][0] == 0.0) == on and plant.q[0] != 0.0
    plant.set_fault("late", True)
    plant.reset()
    plant.advance((4.0,))
    assert plant.seen[0] == plant.q
    with pytest.raises(ValueError, match="unknown fault 'lat', did you mean 'late'"):
        plant.set_fault("lat", True)
    with pytest.raises(ValueError, match="the scene has none"):
        Plant(load_scene("overhead_swing")).set_fault("late", True)


def test_all_ways_to_run_give_the_same_bits() -> None:
    """A compiled run, one with a Python law, and a plant stepped by hand end with the same bits."""
    scene = load_scene(BENCH, COARSE)
    law: Any = scene.law
    compiled = simulate(scene).summary
    python = simulate(scene, law=lambda t, q, v: law(t, q, v)).summary
    plant = Plant(scene)
    for _ in range(2):  # the second time after a restart
        plant.reset()
        for _ in range(scene.steps):
            plant.advance(law(plant.t, *plant.seen))
        stepped = plant.summary()
        assert all(stepped[key] == compiled[key] == python[key] for key in stepped)
    assert (
        compiled["energy_audit_max"] < 1e-6
        and compiled["lost_samples"] > 0
        and len(compiled["faults"]) == 10
    )
    other = simulate(load_scene(BENCH, COARSE | {"seed": 2})).summary
    assert other["state_sha256"] != compiled["state_sha256"]


def test_energies_follow_the_current_payload() -> None:
    """Energies are those of the payload at that time, at periods and at given sample times."""
    scene = rod(faults={"drop": MASS | {"at": 0.5, "until": 0.8}})
    run = simulate(scene, sample_times=[0.1, 0.4995, 0.5, 0.7995, 0.8, 0.9])
    first, heavy, light, still_light, again, end = run.energy
    # neither driven nor damped: the method's own error
    assert heavy == pytest.approx(first, rel=1e-6) and still_light == pytest.approx(light, rel=1e-6)
    # J
    assert end == pytest.approx(again, rel=1e-6) and abs(light - heavy) > 10.0 < abs(again - light)
    assert np.array_equal(simulate(scene).energy[[10, 50, 80, 90]], run.energy[[0, 2, 4, 5]])


def test_hardware_is_refused_where_it_is_not_simulated() -> None:
    """Batches and continuous laws reject sensors, actuators, faults, but accept a brake alone."""
    with pytest.raises(SceneError, match="sensors, actuators and faults: a batch has none"):
        simulate_batch(BENCH, {"seed": [1, 2]})
    with pytest.raises(
        SceneError, match=r"sensors: act once a period, and control\.period is 'continuous'"
    ):
        load_scene("knuckle_continuous", {"sensors": {"all": {"noise": 1.0}}})
    with pytest.raises(SceneError, match="both set the payload's mass"):
        load_scene("overhead_drop", {"faults": {"drop": MASS}})
    with pytest.raises(SceneError, match="is a position, of which no part can be lost"):
        load_scene(
            "offshore_vision", {"faults": {"weak": {"kind": "effort_loss", "joint": "tip_x"}}}
        )
    assert load_scene(BENCH, {"control.law": "lqr"}).hardware is not None
    plain, braked = (
        simulate(load_scene("overhead_swing", {"duration": 1.0} | g)) for g in ({}, {"brake": {}})
    )
    assert plain.summary["state_sha256"] == braked.summary["state_sha256"]


@pytest.mark.slow
@pytest.mark.parametrize("name", [BENCH, "knuckle_bench"])
def test_lockstep_is_simulate(name: str) -> None:
    """Over DDS, with all the scene's hardware, a run ends in the bits of `simulate`."""
    there, here = orchestration.run(load_scene(name), record=None), simulate(name).summary
    same = (
        "state_sha256",
        "faults",
        "lost_samples",
        "saturated_steps",
        "energy_audit_error",
        "rhs_evaluations",
    )
    assert {key: there.get(key) for key in same} == {key: here.get(key) for key in same}
    assert here["energy_audit_error"] < 1e-10  # of the method's tolerance, as without hardware


SLOW_KINDS = (
    *("overhead_spatial", "overhead_hoist_chain", "overhead_elastic", "overhead_spring"),
    *("overhead_chain_50", "overhead_rods"),
)


@pytest.mark.parametrize(
    "name", ["overhead_chain", *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW_KINDS)]
)
def test_every_model_takes_another_payload(name: str) -> None:
    """On every kind of crane a payload change leaves the audit small, and the motion differs.

    The audit is as small as without a change.
    """
    summaries = [
        simulate(
            load_scene(name, {"duration": 1.0, "events": [], "faults": {"other": MASS | times}})
        ).summary
        for times in ({}, {"at": 0.5})
    ]
    assert summaries[1]["energy_audit_error"] < 10.0 * summaries[0]["energy_audit_error"] + 1e-11
    assert summaries[0]["state_sha256"] != summaries[1]["state_sha256"]
