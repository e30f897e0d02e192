"""The group `flexibility`: start, drawing, what laws and brakes know of it, contradictions."""

from math import asin, cos, sin
from typing import Any

import numpy as np
import pytest
from metric_rows import metrics_of
from urdf_kinematics import link_position

import crane_sim
from crane_sim import system
from crane_sim.description import urdf
from crane_sim.numerics.states import leaves
from crane_sim.scenes.scene import load_scene
from crane_sim.simulation.derived import world_points
from crane_sim.simulation.hardware import joint_mechanics

LATERAL, VERTICAL = (
    {"stiffness": 8.2e7, "damping_ratio": 0.01},
    {"stiffness": 3.3e8, "damping_ratio": 0.01},
)
JIB = {"jib": {"mass": 10.5e3, "centre": 30.0, "inertia": 3.15e6}}
BOTH = {"lateral": LATERAL, "vertical": VERTICAL}
SCENES: dict[str, tuple[str, Any]] = {
    "tower": ("tower_flexible_jib", {"flexibility": BOTH | JIB}),
    "mobile": (
        "mobile_lift",
        {"flexibility": BOTH, "payload.inertia": None, "payload.attachment": None},
    ),
}
FREE = {"control": None, "reference": None}


def load_bent(name: str, changes: Any = FREE) -> Any:
    """Return a scene with a crane that bends."""
    scene, group = SCENES[name]
    return load_scene(scene, {**group, **changes})


@pytest.mark.parametrize("modes", [("lateral", "vertical"), ("lateral",), ("vertical",)])
@pytest.mark.parametrize("name", SCENES)
def test_the_urdf_bends_as_the_model_does(name: str, modes: tuple[str, ...]) -> None:
    """Hook and load are where the model puts them, from the joint positions and the URDF alone."""
    rigid = {f"flexibility.{mode}": None for mode in BOTH if mode not in modes}
    scene = load_bent(name, FREE | rigid)
    q = np.array(scene.initial_q) + np.random.default_rng(3).uniform(
        0.05, 0.2, len(scene.initial_q)
    )
    i = scene.joint_names.index("link_2_x")
    q[i : i + 3] /= np.linalg.norm(q[i : i + 3])
    nodes, _ = world_points(scene.model, 0.0, q, np.zeros_like(q))
    document, joints = urdf(scene), dict(zip(scene.joint_names, q, strict=True))
    for k, link in ((-2, "node_1"), (-1, "payload_link")):
        # rounding of 60 m
        assert link_position(document, joints, link) == pytest.approx(nodes[k], abs=1e-12)


def held(scene: Any) -> Any:
    """Return the accelerations at the start under efforts that hold the actuated joints."""
    p, n = scene.model, len(scene.actuated)
    x = system.state(p, 0.0, np.array(scene.initial_q), np.array(scene.initial_v))

    def driven(u: Any) -> Any:
        return system.acceleration(p, 0.0, x, tuple(map(float, u)))

    free = driven(np.zeros(n))
    mobility = np.column_stack([driven(unit)[:n] - free[:n] for unit in np.eye(n)])
    return driven(-np.linalg.solve(mobility, free[:n]))


@pytest.mark.parametrize("name", SCENES)
def test_a_scene_starts_at_rest_under_its_weight(name: str) -> None:
    """Held by its drives nothing moves; a boom that is bent at the start otherwise does."""
    scene = load_bent(name)
    largest = abs(held(scene)).max()
    assert largest < 1e-8  # rad/s² or m/s²: rounding of some 1e7 N m over 1e5 kg m²
    bent = load_bent(name, FREE | {"flexibility.vertical.deflection": 0.01})
    assert bent.initial_q[-2:] == (0.0, 0.01)
    assert abs(held(bent)).max() > 1e-2


def test_the_deflection_at_rest_is_that_of_weights_on_a_spring() -> None:
    """The spring balances jib, trolley and hanging masses; damping is the ratio times critical."""
    scene = load_bent("tower", FREE | {"flexibility.vertical.rest": 0.01})
    angle, (_, radius) = scene.initial_q[-1], scene.initial_q[:2]
    moment = 9.81 * cos(angle) * (10.5e3 * 30.0 + (550.0 + 4450.0) * radius)
    assert 3.3e8 * (angle - 0.01) == pytest.approx(-moment, rel=1e-12)
    inertia = 10.5e3 * 30.0**2 + 3.15e6 + 550.0 * radius**2
    damping = scene.model.support.structure.vertical.damping
    assert damping == pytest.approx(2.0 * 0.01 * np.sqrt(3.3e8 * inertia), rel=1e-12)
    nodes, tip = world_points(
        scene.model, 0.0, np.array(scene.initial_q), np.zeros(len(scene.initial_q))
    )
    assert asin(nodes[tip][2] / radius) == pytest.approx(angle, rel=1e-12)


@pytest.mark.parametrize("name", SCENES)
def test_laws_and_brakes_take_the_crane_for_rigid(name: str) -> None:
    """Rigid joints come first, the law is the rigid crane's, brakes too but for the posture."""
    rigid, bent = load_bent(name, {"flexibility": None}), load_bent(name, {})
    assert bent.joint_names[: len(rigid.joint_names)] == rigid.joint_names
    assert bent.joint_names[len(rigid.joint_names) :] == (
        "lateral_deflection",
        "vertical_deflection",
    )
    for got, expected in zip(leaves(bent.law), leaves(rigid.law), strict=True):
        np.testing.assert_array_equal(got, expected)
    for got, expected in zip(joint_mechanics(bent), joint_mechanics(rigid), strict=True):
        np.testing.assert_allclose(got, expected, rtol=0.05)  # the weight bends it by 0.03 rad


def test_a_law_can_know_that_the_jib_bends() -> None:
    """LQR with `flexibility` in its nominal crane is stable about the deflection at the target."""
    weights = {"nominal": {"flexibility": SCENES["tower"][1]["flexibility"]}, "q": None, "r": None}
    law: Any = load_bent("tower", {f"control.{key}": value for key, value in weights.items()}).law
    angle = law.target[-1]
    moment = 9.81 * cos(angle) * (10.5e3 * 30.0 + (550.0 + 4450.0) * 40.0)
    # accelerations at rest are below 1e-9 rad/s²
    assert 3.3e8 * angle == pytest.approx(-moment, rel=1e-9)
    # on the trolley
    assert law.rows[1].effort == pytest.approx(5000.0 * 9.81 * sin(angle), rel=1e-9)
    assert abs(law.poles).max() < 1.0


def test_a_summary_has_the_largest_deflections() -> None:
    """They are the largest angles, in degrees, whichever way the structure bends."""
    scene = load_bent("mobile")
    q = np.tile(scene.initial_q, (4, 1))
    q[:, -2:] = [[0.0, 0.01], [-0.02, 0.0], [0.01, -0.03], [0.0, 0.01]]
    metrics = metrics_of(scene, q)
    assert metrics["peak_lateral_deflection_deg"] == pytest.approx(np.degrees(0.02))
    assert metrics["peak_vertical_deflection_deg"] == pytest.approx(np.degrees(0.03))


REJECTED = [
    ("tower", {"flexibility": JIB}, "flexibility: needs `lateral`, `vertical` or both"),
    ("mobile", {"flexibility": {}}, "flexibility: needs `lateral`, `vertical` or both"),
    (
        "mobile",
        {"flexibility": BOTH | JIB},
        "flexibility.jib: belongs to crane: tower; here is crane: mobile",
    ),
    ("tower", {"flexibility.jib": None}, "flexibility.jib: is missing"),
    (
        "tower",
        {"slew.inertia": 10e6},
        "slew.inertia = 1e+07: must be greater than that of flexibility.jib, 1.26",
    ),
    (
        "tower",
        {"slew": {"drive": "locked"}},
        "flexibility: belongs to a jib that a drive slews, slew.drive is",
    ),
    (
        "mobile",
        {"flexibility.lateral.stiffness": 0.0},
        "flexibility.lateral.stiffness = 0.0: must be greater",
    ),
    (
        "mobile",
        {"flexibility.vertical.stiffness": 2e5},
        "flexibility.vertical.stiffness = 200000: bends by more",
    ),
    (
        "mobile",
        {"flexibility.vertical.damping": 1.0},
        "flexibility.vertical: unknown key 'damping'",
    ),
    (
        "mobile",
        {"integrator": {"method": "rk4", "step": 0.02}, "flexibility.lateral.stiffness": 1e13},
        "integrator.step = 0.02: too large for the stiffest motion",
    ),
]


@pytest.mark.parametrize(("name", "changes", "line"), REJECTED)
def test_a_structure_that_cannot_be_is_refused(name: str, changes: Any, line: str) -> None:
    """Each contradiction is one line that begins with the key."""
    with pytest.raises(crane_sim.SceneError) as error:
        load_bent(name, FREE | changes)
    assert line in str(error.value) and "\n" not in str(error.value)
