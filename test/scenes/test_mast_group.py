"""The group `flexibility.mast`: start, drawing, falls, laws and brakes, contradictions."""

from typing import Any

import numpy as np
import pytest
from metric_rows import metrics_of
from urdf_kinematics import link_position

import crane_sim
from crane_sim import system
from crane_sim.description import urdf
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.derived import world_points
from crane_sim.simulation.hardware import joint_mechanics

SCENE, FREE = "tower_sway", {"inputs": None, "actuators": {}}
EXACT = {"integrator": {"method": "dop853", "rtol": 1e-11, "atol": 1e-12}, "duration": 0.1}
SEA = {
    "heave": {"amplitude": 0.3, "frequency": 1.1},
    "roll": {"amplitude": 0.04, "frequency": 0.9, "phase": 1.0},
}
MASTS = {
    "flexibility": {
        "jib": {"mass": 10.5e3, "centre": 30.0, "inertia": 3.15e6},
        "mast": {"height": 41.0},
    }
}
MASTS["flexibility"]["mast"] |= {"stiffness": 3.8e8, "damping_ratio": 0.01, "mass": 6e3}


def test_the_urdf_sways_as_the_model_does() -> None:
    """Trolley, hook and load are at the model's places by joint positions and URDF alone."""
    scene = load_scene(SCENE, FREE)
    q = np.array(scene.initial_q) + np.random.default_rng(3).uniform(
        0.05, 0.2, len(scene.initial_q)
    )
    i = scene.joint_names.index("link_2_x")
    q[i : i + 3] /= np.linalg.norm(q[i : i + 3])
    nodes, tip = world_points(scene.model, 0.0, q, np.zeros_like(q))
    document, joints = urdf(scene), dict(zip(scene.joint_names, q, strict=True))
    for k, link in ((tip, "trolley_link"), (-2, "node_1"), (-1, "payload_link")):
        # rounding of 60 m
        assert link_position(document, joints, link) == pytest.approx(nodes[k], abs=1e-12)


def held(scene: Any) -> Any:
    """Return the accelerations at the start under efforts that hold slew and trolley."""
    p = scene.model
    x = system.state(p, 0.0, np.array(scene.initial_q), np.array(scene.initial_v))

    def driven(u: Any) -> Any:
        return system.acceleration(p, 0.0, x, tuple(map(float, u)))

    free, units = driven(np.zeros(3)), np.eye(3)[:2]
    mobility = np.column_stack([driven(unit)[:2] - free[:2] for unit in units])
    return driven([*-np.linalg.solve(mobility, free[:2]), 0.0])


@pytest.mark.parametrize("slew", ["0 deg", "35 deg", "-120 deg"])
def test_a_scene_starts_at_rest_under_its_weight(slew: str) -> None:
    """Held by its drives nothing moves, wherever the jib points."""
    scene = load_scene(SCENE, FREE | {"initial.q": [slew, 25.0, 25.0, 0, 0]})
    assert np.linalg.norm(scene.initial_q[-2:]) > 1e-3
    assert abs(held(scene)).max() < 1e-8  # rad/s² or m/s²: rounding of some 1e7 N m over 1e5 kg m²


def test_laws_and_brakes_take_the_crane_for_rigid() -> None:
    """Rigid joints come first, brakes are as rigid but for posture, metrics name both angles."""
    rigid, bent = (load_scene(SCENE, FREE | group) for group in ({"flexibility": None}, {}))
    assert bent.joint_names == (*rigid.joint_names, "mast_x_deflection", "mast_y_deflection")
    for got, expected in zip(joint_mechanics(bent), joint_mechanics(rigid), strict=True):
        # N, of weights on a slope of 0.01
        np.testing.assert_allclose(got[:2], expected[:2], rtol=0.05, atol=500.0)
    metrics = metrics_of(bent, np.array([bent.initial_q]))
    assert {"peak_mast_x_deflection_deg", "peak_mast_y_deflection_deg"} <= metrics.keys()


def test_runs_keep_their_balance_of_energy() -> None:
    """On a moving base, with play, a body and torsion of its rope, the energy balance holds."""
    play = {"slew": [{"inertia": 2e5, "play": 1e-3, "stiffness": 1e9, "damping": 1e7}]}
    body = {"mass": 4e3, "inertia": [2.8e3, 8.9e3, 9.3e3], "attachment": [0.1, 0.0, 0.7]}
    more = {
        "backlash": play,
        "payload": body,
        "rope.torsion": {"stiffness": 6e3},
        "base_motion": SEA,
    }
    run = crane_sim.simulate(
        SCENE, overrides=more | EXACT | {"initial.v": [0.03, 0.2, 0.1, 0.05, 0.1]}
    )
    assert run.summary["energy_audit_max"] < 1e-9 and np.ptp(run.q[:, -2]) > 0.0


def test_a_load_on_falls_sways_with_the_mast() -> None:
    """A load on falls begins at rest below the bent mast; at sea the energy balance holds."""
    scene = load_scene("tower_set_down", MASTS | {"friction": {}, "contact": None, "inputs": {}})
    q, first = np.array(scene.initial_q), scene.joint_names.index("payload_x")
    a = crane_sim.acceleration(scene, q, 0.0 * q, (0.0, 0.0, 0.0))
    assert abs(a[first : first + 7]).max() < 1e-6  # m/s² or 1/s²: a place is rounded to 1e-10 m
    at_sea = EXACT | {"base_motion": SEA, "initial.v": [0.02, 0.3, 0.2]}
    assert crane_sim.simulate(load_scene(scene, at_sea)).summary["energy_audit_max"] < 1e-9


WINDAGE = {"area": 8.0, "drag_coefficient": 1.3, "centre": 30.0}
REJECTED: list[tuple[dict[str, Any], str]] = [
    (
        {"flexibility.lateral": {"stiffness": 1e8}},
        "flexibility.mast: stands beside flexibility.lateral, of a jib on an upright mast",
    ),
    (
        {"flexibility.vertical": {"stiffness": 1e8}},
        "flexibility.mast: stands beside flexibility.vertical, of a jib on an upright",
    ),
    (
        {"actuators": {"slew": {"motor": {"ratio": 50.0, "inertia": 1e-3}}}},
        "flexibility.mast: stands beside actuators.slew.motor.inertia, which would turn with the "
        "mast, too",
    ),
    (
        {"slew.jib_windage": WINDAGE, "wind": {"speed": 9.0, "height": 40.0}},
        "flexibility.mast: stands beside slew.jib",
    ),
    (
        {"slew": {"drive": "locked"}, "inputs": None},
        "flexibility: belongs to a jib that a drive slews, slew.drive is",
    ),
    (
        {"slew.inertia": 10e6},
        "slew.inertia = 1e+07: must be greater than that of flexibility.jib, 1.26",
    ),
    (
        {"flexibility.mast.stiffness": 1e6},
        "flexibility.mast.stiffness = 1e+06: bends by more than 0.5 rad at rest",
    ),
    ({"flexibility.mast.height": 0.0}, "flexibility.mast.height = 0.0: must be greater than 0"),
    (
        {"integrator": {"method": "rk4", "step": 0.05}, "flexibility.mast.stiffness": 3.8e12},
        "integrator.step = 0.05: too large for the stiffest motion",
    ),
]


@pytest.mark.parametrize(("changes", "line"), REJECTED, ids=[line[:60] for _, line in REJECTED])
def test_a_mast_that_cannot_be_is_refused(changes: dict[str, Any], line: str) -> None:
    """Each contradiction is one line that begins with the key."""
    with pytest.raises(crane_sim.SceneError) as error:
        load_scene(SCENE, {"actuators": {}} | changes)
    assert line in str(error.value) and "\n" not in str(error.value)
