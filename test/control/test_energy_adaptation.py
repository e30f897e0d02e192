"""The energy law that estimates the payload's mass: final error, proof, memory, settings.

Settings are those that are rejected.
"""

from math import exp
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_control.knuckle_energy import EnergyLaw, compute_lyapunov
from crane_sim.laws import with_initial_state
from crane_sim.simulation.linearisation import state_matrices
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import Rollout, simulate

G, SCENE = 9.81, "knuckle_unknown_load"
FIXED_GAINS = {"kp": [30, 10, 10, 1], "kd": [50, 30, 50, 10]}  # of the law without estimation


def run_without_adaptation(mass: float, nominal_mass: float) -> Rollout:
    """Return the run of the law without estimation, at this nominal mass [kg].

    The gains are those of the paper.
    """
    control = {
        "law": "energy",
        "period": 0.01,
        **FIXED_GAINS,
        "nominal": {"payload": {"mass": nominal_mass}},
    }
    return simulate(
        crane_sim.load_scene("knuckle_setpoint", {"payload.mass": mass, "control": control})
    )


@pytest.mark.long
@pytest.mark.parametrize("mass", [0.8, 1.2])
def test_the_law_reaches_its_target_with_any_mass(mass: float) -> None:
    """With masses up to 20 % off the law reaches its target.

    It swings less than a law with the true mass.
    """
    run = simulate(crane_sim.load_scene(SCENE, {"payload.mass": mass}))
    error = np.abs(run.q[-1, :4] - np.array(run.scene.reference))
    assert np.degrees(error[:3]).max() < 0.5 and error[3] < 0.01
    wrong_mass, true_mass = run_without_adaptation(mass, 1.0), run_without_adaptation(mass, mass)
    assert run.summary["peak_swing_deg"] < min(
        r.summary["peak_swing_deg"] for r in (wrong_mass, true_mass)
    )
    assert np.degrees(abs(wrong_mass.q[-1, 1] - wrong_mass.scene.reference[1])) > 10.0  # pyright: ignore


def record_mass_estimates(
    mass: float, seconds: float, changes: dict[str, Any]
) -> tuple[Any, list[tuple[float, ...]]]:
    """Return (the law, [t, a, p, m̂] at every command) of a run.

    The law is called from Python; see the law.
    """
    scene = crane_sim.load_scene(SCENE, {"payload.mass": mass, **changes})
    law, plant, records = with_initial_state(scene.law), Plant(scene), []
    for _ in range(round(seconds / scene.period)):
        plant.advance(law(plant.t, plant.q, plant.v))
        records.append((law.estimator.previous[0], *law.estimator.filters, law.estimator.mass[0]))
    return law, records


@pytest.mark.parametrize("mass", [0.5])
def test_the_estimate_converges_as_in_the_proof(mass: float) -> None:
    """The difference of both filters decays at the filters' rate, for any motion of the crane."""
    _, records = record_mass_estimates(mass, 8.0, {"initial.v": [0.3, 0.2, -0.1, 0.2, 1.0, -0.5]})
    t, a, p, estimate = np.array(records).T
    # the mean of -n_z over a period is taken from its ends: h² / 12 of its second derivative, 2 /
    # s² at the worst
    assert np.allclose(p - mass * a, (1.0 - mass) * G * np.exp(-2.0 * t), rtol=0, atol=5e-5 * G)
    assert estimate[-1] == pytest.approx(mass, abs=5e-5)
    assert np.ptp(a) > 0.5  # the payload did heave


def proof_function(law: Any, mass: float, t: float, q: Any, v: Any) -> float:
    """Return W [J] of the proof for the true mass [kg]."""
    nominal, winch, kd = law.nominal, law.parameters.rope, law.parameters.kd
    true = EnergyLaw(law.parameters, nominal._replace(load=nominal.load._replace(mass=mass)))
    value, _ = compute_lyapunov(true, t, tuple(q), tuple(v))
    # B
    bound = (
        nominal.support.boom.length**2 / kd[1]
        + nominal.support.jib.length**2 / kd[2]
        + 1.0 / winch.kd
    )
    # f - m a
    filter_error = (nominal.load.mass - mass) * nominal.gravity * exp(-law.filter_rate * t)
    return value + 0.5 * bound / law.filter_rate * filter_error**2


@pytest.mark.parametrize("mass", [1.2])
def test_lyapunov_function_decreases(mass: float) -> None:
    """W of the proof decreases throughout, while V alone increases with the mass error.

    The error is that of the mass estimate.
    """
    run = simulate(crane_sim.load_scene(SCENE, {"payload.mass": mass, "duration": 15.0}))
    law: Any = run.scene.law
    w = np.array([proof_function(law, mass, *row) for row in zip(run.t, run.q, run.v, strict=True)])
    # the estimation error is zero by then
    v_energy = np.array(
        [proof_function(law, mass, 1e9, q, v) for q, v in zip(run.q, run.v, strict=True)]
    )
    assert np.all(np.diff(w) < 0.0)
    assert w[-1] < 0.06 * w[0]
    assert np.max(v_energy - np.minimum.accumulate(v_energy)) > 0.01
    initial_offset = 0.5 * (25.0 / 30.0 + 16.0 / 50.0 + 1.0 / 10.0) / 2.0 * ((1.0 - mass) * G) ** 2
    assert w[0] - v_energy[0] == pytest.approx(initial_offset)


def test_compiled_loop_and_external_stepping_agree() -> None:
    """Commands to a plant stepped from outside are those of `simulate` bit for bit, twice.

    ROS steps a plant so.
    """
    run = simulate(SCENE, duration=2.0)
    again = simulate(run.scene)  # begins with the initial estimate
    law, plant = with_initial_state(run.scene.law), Plant(run.scene)
    for row in run.u[:-1]:
        command = law(plant.t, plant.q, plant.v)
        assert command == law(plant.t, plant.q, plant.v) == tuple(row)  # the same state twice
        plant.advance(command)
    assert np.array_equal(run.q, again.q) and np.array_equal(run.u, again.u)


def test_no_estimator_update_while_the_rope_is_slack() -> None:
    """While the payload falls the estimate is held; a compressive winch command is zero."""
    law: Any = with_initial_state(crane_sim.load_scene(SCENE).law)
    q, h, masses = (0.0, 0.5, -0.2, 2.0, 0.0, 0.0), 0.01, []
    for k in range(100):  # a second in which the payload falls freely below a crane at rest
        law(k * h, q, (0.0, 0.0, 0.0, G * k * h, 0.0, 0.0))
        masses.append(law.estimator.mass[0])
    assert law.estimator.filters[0] == pytest.approx(G * exp(-2.0 * 0.99))
    half_life = 35  # commands until exp(-2 t) is a half
    assert len(set(masses[:half_life])) == half_life and set(masses[half_life:]) == {
        masses[half_life - 1]
    }
    assert law(1.0, (*q[:3], 0.2, 0.0, 0.0), (0.0, 0.0, 0.0, -20.0, 0.0, 0.0))[3] > 0.0
    assert law.estimator.winch_effort[0] == 0.0


def test_reach_saturates_the_slew_alone() -> None:
    """With `reach` the slew's proportional effort is kp e / √(1 + (e/r)²).

    Other joints are unchanged.
    """
    scene = crane_sim.load_scene(SCENE, {"payload.mass": 1.0})
    law, q = scene.law, (-2.0, 0.4, -0.3, 1.8, 0.0, 0.0)
    assert law is not None
    linear = crane_sim.load_scene("knuckle_setpoint", {"control.kp": [30, 10, 10, 2]}).law
    assert linear is not None
    bounded, free = law(0.0, q, (0.0,) * 6), linear(0.0, q, (0.0,) * 6)
    e = np.pi / 4 + 2.0
    assert bounded[0] == pytest.approx(30.0 * e / np.sqrt(1.0 + (e / 0.3) ** 2), rel=1e-14)
    assert bounded[1:] == pytest.approx(free[1:], rel=1e-14)


def test_poles_of_the_plain_law_about_its_target() -> None:
    """At its target the law without estimation has the swing poles of an independent result.

    The law is linearised numerically.
    """
    scene = crane_sim.load_scene("knuckle_setpoint")
    assert scene.reference and scene.law
    law, step, target = scene.law, 1e-5, np.array([*scene.reference, 0.0, 0.0])
    a, b = state_matrices(scene, target, np.array(law(0.0, tuple(target), (0.0,) * 6)))
    rows = [
        (np.concatenate([target, np.zeros(6)]) + d)
        for d in np.vstack([step * np.eye(12), -step * np.eye(12)])
    ]
    efforts = np.array([law(0.0, tuple(z[:6]), tuple(z[6:])) for z in rows])
    poles = np.linalg.eigvals(a + b @ ((efforts[:12] - efforts[12:]).T / (2.0 * step)))
    swings = sorted(pole for pole in poles if pole.imag > 2.0)
    assert np.all(poles.real < 0.0)
    # given to two digits of the damping and three of the frequency
    assert [z.real for z in swings] == pytest.approx([-0.084, -0.070], abs=6e-4)
    assert [z.imag for z in swings] == pytest.approx([3.17, 2.74], abs=6e-3)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"rope": {"drive": "locked"}}, "possible: rope.drive = 'force'"),
        (
            {"control.period": "continuous"},
            "a law that estimates the mass has memory; give a period",
        ),
        ({"gravity": 0.0}, "without weight the mass cannot be estimated"),
        (
            {"control.adaptation": {"rate": 0.0}},
            "control.adaptation.rate = 0.0: must be greater than 0",
        ),
    ],
    ids=["locked", "continuous", "gravity", "rate"],
)
def test_rejected_settings_of_the_estimator(changes: dict[str, Any], message: str) -> None:
    """A winch without force, no gravity, no commands, bad settings: single-line errors.

    Settings out of range are bad; the errors name the key.
    """
    with pytest.raises(crane_sim.SceneError) as caught:
        crane_sim.load_scene(SCENE, changes)
    assert message in str(caught.value) and "\n" not in str(caught.value)
