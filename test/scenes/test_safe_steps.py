"""Fixed steps: a scene's required frequency is just above that of its fastest small motion."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.scenes.schema.backlash import Drive, shaft_frequency
from crane_sim.simulation.linearisation import equilibrium, state_matrices

KEYS = ("control", "inputs", "actuators", "friction", "lugre", "backlash", "base_motion", "events")
FIXED = {"integrator": {"method": "rk4", "step": 1e-5}, "duration": 1.0}
FREE: dict[str, Any] = dict.fromkeys(KEYS) | FIXED
STEEP = {"initial.q": [0.0, 0.9, -0.9, 1.0, 0.0, 0.0]}
VISCOUS = {"coulomb": 0.0, "static": 0.0, "viscous": 1e4}
CASES: dict[str, tuple[str, dict[str, Any]]] = {
    "hook and sling": ("bridge_hook_and_sling", {}),
    "light hook": ("bridge_hook_and_sling", {"links.0.mass": 1.0}),
    "hook below a knuckle boom": ("knuckle_hook_and_sling", {}),
    "one rope": ("knuckle_setpoint", STEEP),
    "a load heavier than the crane": ("knuckle_setpoint", STEEP | {"payload.mass": 100.0}),
    "long boom": ("mobile_lift", {}),
    "driven point": ("pendulum_free", {}),
    "torsion": (
        "tower_beam_turns",
        {"rope.torsion.damping": 6e6, "payload.inertia": [2e4, 2e4, 2e4]},
    ),
    "falls": ("spreader_skew", {"falls.relaxation": 0.0}),
    "damped falls": ("spreader_skew", {"falls.relaxation": 0.5}),
    "viscous friction": (
        "knuckle_setpoint",
        {"friction": {"boom": VISCOUS, "jib": VISCOUS}, "initial.q": [0, 0, 0, 2, 0, 0]},
    ),
}


def required(scene: crane_sim.Scene) -> float:
    """Return the largest frequency or rate [rad/s] that a scene's method has to bear."""
    frequency = scene.file.requirements().frequency
    assert frequency is not None
    return frequency


@pytest.mark.parametrize("name", CASES)
def test_the_requirement_bounds_the_fastest_small_motion(name: str) -> None:
    """The largest eigenvalue of the crane at rest, from differences, is just below the bound."""
    source, changes = CASES[name]
    scene = crane_sim.load_scene(source, FREE | {"reference": None} | changes)
    scene = crane_sim.load_scene(
        scene, {"reference": {"q": list(scene.initial_q[: len(scene.actuated)])}}
    )
    a, _ = state_matrices(scene, *equilibrium(scene))
    largest, bound = np.abs(np.linalg.eigvals(a)).max(), required(scene)
    assert largest <= bound * (1.0 + 1e-4)  # the quotients' error, and the crane's slow motions
    assert bound <= 1.25 * largest, bound / largest


def test_the_shafts_of_drives_are_bounded_with_their_damping() -> None:
    """Of two drives touching a joint, frequency and decay rate are just below the bound."""
    for stiffness, damping in ((4e6, 1e3), (4e6, 1e6)):
        drives = [
            Drive(inertia=m, play=1e-3, stiffness=stiffness, damping=damping) for m in (2e3, 1e3)
        ]
        # of joint and drives
        springs = np.array([[2.0, -1.0, -1.0], [-1.0, 1.0, 0.0], [-1.0, 0.0, 1.0]])
        # the joint as heavy as its heaviest drive
        inverse = np.diag([1.0 / 2e3, 1.0 / 2e3, 1.0 / 1e3])
        a = np.block(
            [
                [np.zeros((3, 3)), np.eye(3)],
                [-stiffness * inverse @ springs, -damping * inverse @ springs],
            ]
        )
        largest = np.abs(np.linalg.eigvals(a)).max()
        assert largest <= shaft_frequency({"bridge": drives}) <= 1.25 * largest


@pytest.mark.parametrize("mass", [1.0, 100.0])
def test_an_overhead_crane_is_judged_by_all_of_its_payloads(mass: float) -> None:
    """With an event to another payload the requirement is the larger one of both payloads' own."""
    free = FREE | {"payload": {"mass": 10.0}, "reference": None}
    one, other = (
        required(crane_sim.load_scene("overhead_chain", free | {"payload.mass": m}))
        for m in (10.0, mass)
    )
    event = {"events": [{"at": 0.5, "set": {"payload": {"mass": mass}}}]}
    assert required(crane_sim.load_scene("overhead_chain", free | event)) == max(one, other)


@pytest.mark.parametrize(
    ("scene", "changes", "step"),
    [
        ("knuckle_setpoint", {}, 5.0),
        ("pendulum_free", {}, 5.0),
        ("bridge_hook_and_sling", {"links.0.mass": 1.0}, 0.05),
        ("spreader_skew", {"falls.relaxation": 0.5}, 0.05),
        ("tandem_play", {"backlash.bridge.0.damping": 1e6}, 0.005),
        (
            "overhead_chain",
            {"payload": {"mass": 10.0}, "events": [{"at": 0.5, "set": {"payload": {"mass": 1e5}}}]},
            0.005,
        ),
    ],
)
def test_unstable_steps_are_refused(scene: str, changes: dict[str, Any], step: float) -> None:
    """A step beyond the safe one is refused, and the one that the line names is taken."""
    whole = (
        FREE
        | {"backlash": crane_sim.load_scene(scene).document.get("backlash"), "reference": None}
        | changes
    )
    with pytest.raises(
        crane_sim.SceneError, match=f"integrator.step = {step:g}: too large for the stiffest"
    ) as refused:
        crane_sim.load_scene(scene, whole | {"integrator": {"method": "rk4", "step": step}})
    safe = float(str(refused.value).partition("method is ")[2].split()[0])
    crane_sim.load_scene(scene, whole | {"integrator": {"method": "rk4", "step": 0.99 * safe}})
