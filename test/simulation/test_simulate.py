"""Whole runs without ROS: reference trajectories, conservation, repeatability, results."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.simulation.plant import Plant, SimulationError
from crane_sim.simulation.rollout import simulate

REFERENCE = json.loads((Path(__file__).parents[1] / "data" / "knuckle.json").read_text())[
    "trajectories"
]
LIMITED: dict[str, Any] = {
    "crane": "overhead",
    "duration": 30.0,
    "trolley": {"drive": "force", "mass": 20.0, "limits": [-1.0, 1.0]},
    "cable": {"lengths": [3.0], "node_masses": [10.0]},
    "inputs": {"trolley": {"kind": "sine", "amplitude": 8.0, "frequency": 0.3}},
}
"""An open-loop scene: its steps are longer than its periods."""
FRICTION = {1: "paper", 2: "quadratic", 3: "linear"}


def scene_of(case: dict[str, Any]) -> crane_sim.Scene:
    """Return the scene of a reference trajectory, with the default integrator."""
    p, control = case["params"], case["control"]
    document: dict[str, Any] = {
        "crane": "knuckle",
        "duration": 20.0,
        "gravity": p["g"],
        "boom": {"length": p["l_B"], "mass": p["m_B"], "inertia": p["I_B"]},
        "jib": {"length": p["l_J"], "mass": p["m_J"], "inertia": p["I_J"]},
        "tower": {"inertia": p["I_tot"]},
        "payload": {"mass": p["m"]},
        "initial": {"q": case["x0"]["q"], "v": case["x0"]["qd"]},
    }
    if control["kind"] == "energy":
        document["reference"] = {"q": control["ref"]}
        gains = {"kp": control["kp"], "kd": control["kd"]}
        document["control"] = {"law": "energy", "period": "continuous", **gains}
    else:
        names = ("slew", "boom", "jib", "rope")
        document["inputs"] = {
            n: {"kind": "constant", "value": u} for n, u in zip(names, control["u"], strict=True)
        }
    return crane_sim.load_scene(document)


@pytest.mark.parametrize("case", REFERENCE, ids=[case["name"] for case in REFERENCE])
def test_reference_trajectories(case: dict[str, Any]) -> None:
    """With default settings, published 40-digit trajectories are met to 1e-9 for 20 s."""
    times = [sample["t"] for sample in case["samples"]]
    run = simulate(scene_of(case), sample_times=times)
    assert np.allclose(run.q, [sample["q"] for sample in case["samples"]], rtol=0, atol=1e-9)
    assert np.allclose(run.v, [sample["qd"] for sample in case["samples"]], rtol=0, atol=1e-9)
    assert np.allclose(
        run.payload, [sample["payload_pos"] for sample in case["samples"]], rtol=0, atol=1e-9
    )
    assert np.allclose(run.energy, [sample["E"] for sample in case["samples"]], rtol=0, atol=1e-8)
    # gains up to 50
    assert np.allclose(run.u, [sample["u"] for sample in case["samples"]], rtol=0, atol=1e-7)


def test_springs_conserve_energy() -> None:
    """With springs and no losses the total energy is constant to the integrator's tolerance."""
    run = simulate("knuckle_springs", duration=5.0)
    scale = np.ptp(run.derived.potential)
    # 1e-11 relative a step, some 100 steps
    assert np.max(np.abs(run.energy - run.energy[0])) < 1e-10 * scale


@pytest.mark.slow
def test_the_payload_passes_the_pole() -> None:
    """A payload that loops through theta2 = 90 degrees keeps rope length and energy.

    Angles stay finite.
    """
    run = simulate("knuckle_pole")
    assert np.max(np.abs(run.q[:, 5])) > np.radians(89.0)  # it gets there
    assert np.ptp(np.unwrap(2.0 * np.arctan2(*_plane(run).T)) / 2.0) > 2.0 * np.pi  # and goes round
    assert np.isfinite(run.q).all() and np.isfinite(run.v).all()
    assert np.max(np.abs(run.q[:, 3] - 1.0)) < 1e-14  # put back after every step
    assert run.summary["energy_audit_error"] < 1e-11  # losses and work accounted for


def _plane(run: crane_sim.Rollout) -> np.ndarray:
    """Return the rope's direction in the plane that it started in, (K, 2)."""
    rope = run.payload - run.tip
    return rope[:, [0, 2]]


def test_exactly_at_the_pole_everything_is_finite() -> None:
    """At theta2 = 90 degrees itself, joint coordinates and accelerations are finite."""
    scene = crane_sim.load_scene(
        "knuckle_pole", {"initial.q": [0, 0.5, 0, 1, 0, "90 deg"], "initial.v": [0, 0, 0, 0, 0, 3]}
    )
    plant = Plant(scene)
    plant.advance((0.0, 10000.0, 5000.0))
    assert np.isfinite([*plant.q, *plant.v]).all()
    assert np.isfinite(
        crane_sim.acceleration(scene, scene.initial_q, scene.initial_v, [0.0] * 3)
    ).all()


@pytest.mark.parametrize("name", ["knuckle_setpoint", "knuckle_losses"])
def test_compiled_and_python_loops_agree_bit_for_bit(name: str) -> None:
    """A law called from Python every period and the compiled loop give the same bits."""
    scene = crane_sim.load_scene(name, {"duration": 2.0})
    law = scene.law
    assert law is not None
    times = np.linspace(0.0, 2.0, 77)
    compiled = simulate(scene, sample_times=times)
    called = simulate(scene, law=lambda t, q, v: law(t, q, v), sample_times=times)
    assert np.array_equal(compiled.q, called.q) and np.array_equal(compiled.v, called.v)
    assert np.array_equal(compiled.u, called.u) and np.array_equal(compiled.tension, called.tension)
    same = ("state_sha256", "rhs_evaluations", "saturated_steps", "energy_audit_max", "peak_effort")
    assert [compiled.summary[key] for key in same] == [called.summary[key] for key in same]


def test_sample_times_do_not_change_the_steps() -> None:
    """Other instants leave steps and states as they are; instants of the grid have its states."""
    plain = simulate("knuckle_setpoint", duration=3.0)
    sampled = simulate("knuckle_setpoint", duration=3.0, sample_times=[0.0, 1.0, 1.2345, 3.0])
    assert sampled.summary == plain.summary
    assert np.array_equal(sampled.q[[0, 1, 3]], plain.q[[0, 100, 300]])
    before, after = plain.q[123], plain.q[124]
    # monotone there, but for the curvature in 10 ms
    inside = np.minimum(before, after) - 1e-6 <= sampled.q[2]
    assert inside.all() and (sampled.q[2] <= np.maximum(before, after) + 1e-6).all()


@pytest.mark.parametrize("times", [[-1.0], [1.0, 0.5], [99.0], [float("nan")]], ids=str)
def test_impossible_sample_times_are_rejected(times: list[float]) -> None:
    """Instants outside the run, backwards or not numbers are errors that name themselves."""
    with pytest.raises(ValueError, match="sample_times"):
        simulate("knuckle_setpoint", duration=2.0, sample_times=times)


def test_fixed_steps_span_periods() -> None:
    """Without control a step spans as many periods as fit; a plant passes the same states.

    The plant steps period by period.
    """
    changes = {"duration": 0.45, "integrator": {"method": "rk8", "step": 0.125}}
    scene = crane_sim.load_scene("overhead_swing", changes)
    run, plant = simulate(scene), Plant(scene)
    assert run.stats["steps"] == 4  # of twelve periods of 10 ms, the last of nine
    for _ in range(scene.steps):
        plant.advance()
    assert plant.summary()["state_sha256"] == run.summary["state_sha256"]
    exact = simulate(scene, overrides={"integrator": {"method": "dop853", "rtol": 1e-12}})
    # (w h)^9 / 9! is 2e-9 a step, w = 3.6 rad/s, of a small swing; at 60 degrees the next terms are
    # as large
    assert np.max(np.abs(run.q - exact.q)) < 1e-7


def test_efforts_after_steps_that_span_periods() -> None:
    """Efforts given in the middle of a step act from their period on, as with shorter steps."""
    ends = []
    for step in (0.05, 0.01):
        plant = Plant(
            crane_sim.load_scene("overhead_swing", {"integrator": {"method": "rk8", "step": step}})
        )
        for efforts in (None, None, (50.0,), (50.0,)):
            plant.advance(efforts)
        ends.append([*plant.q, *plant.v])
    # of steps of 20 ms; the force has moved the trolley by 2 mm
    np.testing.assert_allclose(*ends, atol=1e-11)


@pytest.mark.parametrize("braking", [False, True], ids=["effort", "brakes"])
def test_a_step_that_went_on_to_a_limit_ends_no_run(braking: bool) -> None:
    """Efforts and brakes before a limit that a step has reached act as after short steps.

    The step is one of the scene's own source.
    """
    ends = []
    for method in (
        {"method": "auto"},
        {"method": "rk8", "step": 0.01},
    ):  # steps of 0.01 s end with their period
        plant = Plant(crane_sim.load_scene(LIMITED | {"integrator": method}))
        while plant.t < 4.195:
            plant.advance()
        plant.braking = braking
        for _ in range(12):  # under brakes the limit is reached 0.17 s later
            plant.advance(None if braking else (-400.0,))
        ends.append([*plant.q, *plant.v])
    # the tolerance of a step; the effort moves the trolley by 0.1 m
    np.testing.assert_allclose(*ends, atol=1e-9)


def test_events_that_did_not_happen_are_not_listed() -> None:
    """What a step found after brakes began is no event.

    Under the brakes the trolley does not slip.
    """
    friction, source = (
        {"trolley": {"coulomb": 20.0, "static": 30.0}},
        {"kind": "sine", "amplitude": 60, "frequency": 3},
    )
    changes = {
        "trolley": {"drive": "force", "mass": 20.0},
        "inputs": {"trolley": source},
        "friction": friction,
    }
    plant = Plant(crane_sim.load_scene(LIMITED | changes))
    while plant.t < 0.055:
        plant.advance()
    # the step has passed the instant at which the force exceeds 30 N
    assert plant.integration.event_log.total == 1
    plant.braking = True
    for _ in range(60):
        plant.advance()
    assert (plant.summary()["event_count"], plant.summary()["events"]) == (0, [])


def test_a_rope_cannot_push() -> None:
    """A negative tension that is demanded is applied as a slack rope and counted.

    The equations themselves take any effort.
    """
    carry = {"slew": 0.0, "boom": 190.0, "jib": 90.0}
    pushed = simulate("knuckle_setpoint", law=lambda t, q, v: (*carry.values(), 25.0), duration=0.5)
    assert pushed.summary["saturated_steps"] == 50 and pushed.summary["min_rope_tension"] == 0.0
    assert np.all(pushed.u[:, 3] == 0.0)
    scene = crane_sim.load_scene("knuckle_setpoint")
    at_rest = (scene.initial_q, scene.initial_v)
    slack, push = (
        crane_sim.acceleration(scene, *at_rest, [*carry.values(), u])[3] for u in (0.0, 25.0)
    )
    assert push > slack + 20.0


def test_open_loop_inputs_cannot_push_either() -> None:
    """An open-loop input that asks the rope to push is limited as well."""
    inputs = {"rope": {"kind": "constant", "value": 5.0}}
    run = simulate(
        crane_sim.load_scene(
            "knuckle_setpoint", {"control": None, "inputs": inputs, "duration": 0.1}
        )
    )
    assert np.all(run.u[:, 3] == 0.0)


def test_inputs_follow_their_functions() -> None:
    """Sine, table and polynomial inputs are applied as their formulas say."""
    inputs = {
        "slew": {
            "kind": "sine",
            "offset": 1.0,
            "amplitude": 2.0,
            "frequency": 3.0,
            "phase": "30 deg",
        },
        "boom": {"kind": "polynomial", "coefficients": [190.0, 1.0, -0.5]},
        "jib": {"kind": "table", "times": [0.2, 0.4, 0.5], "values": [90.0, 95.0, 91.0]},
        "rope": {"kind": "constant", "value": -9.81},
    }
    scene = crane_sim.load_scene(
        "knuckle_setpoint", {"control": None, "inputs": inputs, "duration": 0.6}
    )
    run = simulate(scene)
    t = run.t
    expected = [
        1.0 + 2.0 * np.sin(3.0 * t + np.radians(30.0)),
        190.0 + t - 0.5 * t**2,
        np.interp(t, [0.2, 0.4, 0.5], [90.0, 95.0, 91.0]),
        np.full_like(t, -9.81),
    ]
    assert np.allclose(run.u.T, expected, rtol=1e-14)


def test_the_published_manoeuvre() -> None:
    """The paper's manoeuvre has the values known for the corrected law.

    They are peak and residual swing, settling times and efforts.
    """
    run = simulate("knuckle_setpoint")
    degrees = np.degrees(np.abs(run.q[:, 4:]).max(axis=0))
    # known to 3 digits for the continuous law, here 10 ms
    assert degrees == pytest.approx([9.07, 3.80], abs=0.03)
    assert run.summary["residual_swing_deg"] == pytest.approx(0.68, abs=0.01)
    *joints, rope = run.summary["settling_time"].values()
    # it arrives in the last 40 ms
    assert joints == pytest.approx([26.8, 32.5, 25.4], abs=0.2) and rope is None
    assert list(run.summary["peak_effort"].values()) == pytest.approx(
        [23.6, 215, 98.6, 10.3], rel=5e-3
    )


def test_a_run_that_fails_says_where() -> None:
    """A step too coarse for the scene ends in one line with the time."""
    coarse = {"integrator": {"method": "rk4", "step": 0.01}, "springs.boom.stiffness": 1e9}
    stiff = crane_sim.load_scene("knuckle_springs", coarse)
    with pytest.raises(crane_sim.SimulationError, match=r"t = .* s: the state is not finite"):
        simulate(stiff)


@pytest.mark.parametrize(
    "groups", [{}, {"sensors": {"all": {"delay": 0.02}}}], ids=["plain", "hardware"]
)
def test_a_failed_run_of_a_law_in_python_is_kept(groups: dict[str, Any]) -> None:
    """The error of a run whose law is Python has the run so far, with a plant's bits."""
    push = {"inputs": {"trolley": {"kind": "constant", "value": 100.0}}, "duration": 3.0} | groups
    scene = crane_sim.load_scene(LIMITED | push).with_external_commands()
    with pytest.raises(
        SimulationError, match="t = .* s: the trolley reached its travel limit"
    ) as stopped:
        simulate(scene, law=lambda t, q, v: (100.0,))
    run, plant = stopped.value.run, Plant(scene)
    assert run.summary["error"] == str(stopped.value)
    for k in range(len(run.t) - 1):
        assert (*plant.q, *plant.v) == (*run.q[k], *run.v[k])
        plant.advance((100.0,))
    with pytest.raises(SimulationError):
        plant.advance((100.0,))
    assert run.commands.tolist() == [[100.0]] * plant.k
    assert [what for _, what in run.events] == ["the trolley reached its travel limit"]


@pytest.mark.slow
def test_a_law_that_blows_up_ends_the_run() -> None:
    """Under an effort that no step can follow a run ends with one line."""
    with pytest.raises(SimulationError, match="too fast or too stiff"):
        simulate("offshore_resonant", lambda t, q, v: (1e60, 0.0))
