"""The energy law that weighs its load: where it ends, what its proof says, what it remembers and what it refuses."""

from math import exp
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_control.linearisation import linearise
from crane_sim.laws import fresh
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import Rollout, simulate

G, SCENE = 9.81, "knuckle_unknown_load"
PLAIN = {"kp": [30, 10, 10, 1], "kd": [50, 30, 50, 10]}  # of the manoeuvre that this one is compared with


def plain(mass: float, believed: float) -> Rollout:
    """Return the manoeuvre under the plain law with the paper's gains, which believes in another mass."""
    control = {"law": "energy", "period": 0.01, **PLAIN, "nominal": {"payload": {"mass": believed}}}
    return simulate(crane_sim.load_scene("knuckle_setpoint", {"payload.mass": mass, "control": control}))


@pytest.mark.parametrize("mass", [0.8, 0.9, 1.1, 1.2])
def test_the_law_ends_on_its_target_whatever_it_lifts(mass: float) -> None:
    """Whatever it lifts, up to 20 % off, the law ends on its target and swings less than the plain one that knows."""
    run = simulate(crane_sim.load_scene(SCENE, {"payload.mass": mass}))
    error = np.abs(run.q[-1, :4] - np.array(run.scene.reference))
    assert np.degrees(error[:3]).max() < 0.5 and error[3] < 0.01
    wrong, told = plain(mass, 1.0), plain(mass, mass)
    assert run.summary["peak_swing_deg"] < min(r.summary["peak_swing_deg"] for r in (wrong, told))
    assert np.degrees(abs(wrong.q[-1, 1] - wrong.scene.reference[1])) > 10.0  # pyright: ignore


def weighed(mass: float, seconds: float, changes: dict[str, Any]) -> tuple[Any, list[tuple[float, ...]]]:
    """Return (the law, [t, a, p, m̂] at every command) of a run that asks the law from Python, period by period."""
    scene = crane_sim.load_scene(SCENE, {"payload.mass": mass, **changes})
    law, plant, seen = fresh(scene.law), Plant(scene), []
    for _ in range(round(seconds / scene.period)):
        plant.advance(law(plant.t, plant.q, plant.v))
        seen.append((law.estimator.previous[0], *law.estimator.filters, law.estimator.mass[0]))
    return law, seen


@pytest.mark.parametrize("mass", [0.5, 1.1])
def test_the_estimate_comes_to_the_mass_as_the_proof_says(mass: float) -> None:
    """What tells the filters apart fades with the filters' rate, whatever the crane does meanwhile."""
    _, seen = weighed(mass, 8.0, {"initial.v": [0.3, 0.2, -0.1, 0.2, 1.0, -0.5]})
    t, a, p, estimate = np.array(seen).T
    # the mean of -n_z over a period is taken from its ends: h² / 12 of its second derivative, 2 / s² at the worst
    assert np.allclose(p - mass * a, (1.0 - mass) * G * np.exp(-2.0 * t), rtol=0, atol=5e-5 * G)
    assert estimate[-1] == pytest.approx(mass, abs=5e-5)
    assert np.ptp(a) > 0.5  # the payload did heave


@pytest.mark.parametrize("mass", [0.8, 1.2])
def test_w_never_rises(mass: float) -> None:
    """The energy of the proof falls all the time, where the plain law's energy alone rises with what is not weighed."""
    run = simulate(crane_sim.load_scene(SCENE, {"payload.mass": mass, "duration": 15.0}))
    law: Any = run.scene.law
    joints = [(tuple(q), tuple(v)) for q, v in zip(run.q, run.v, strict=True)]
    w = np.array([law.lyapunov_of(mass, t, *state) for t, state in zip(run.t, joints, strict=True)])
    plain_energy = np.array([law.lyapunov_of(mass, 1e9, *state) for state in joints])  # all is weighed by then
    assert np.all(np.diff(w) < 0.0)
    assert w[-1] < 0.06 * w[0]
    assert np.max(plain_energy - np.minimum.accumulate(plain_energy)) > 0.01
    rest = 0.5 * (25.0 / 30.0 + 16.0 / 50.0 + 1.0 / 10.0) / 2.0 * ((1.0 - mass) * G) ** 2
    assert w[0] - plain_energy[0] == pytest.approx(rest)


def test_the_compiled_loop_and_a_law_asked_from_outside_are_one() -> None:
    """Commands to a plant that is stepped from outside, as under ROS, are those of `simulate` bit for bit, twice."""
    run = simulate(SCENE, duration=2.0)
    again = simulate(run.scene)  # begins with nothing weighed
    law, plant = fresh(run.scene.law), Plant(run.scene)
    for row in run.u[:-1]:
        demand = law(plant.t, plant.q, plant.v)
        assert demand == law(plant.t, plant.q, plant.v) == tuple(row)  # a state that comes twice
        plant.advance(demand)
    assert np.array_equal(run.q, again.q) and np.array_equal(run.u, again.u)


@pytest.mark.interpreted
def test_a_payload_that_does_not_weigh_on_the_rope_teaches_nothing() -> None:
    """While the payload falls the estimate stays, and a winch that is asked to push is taken to do nothing."""
    law: Any = fresh(crane_sim.load_scene(SCENE).law)
    q, h, masses = (0.0, 0.5, -0.2, 2.0, 0.0, 0.0), 0.01, []
    for k in range(100):  # a second in which the payload falls freely below a crane at rest
        law(k * h, q, (0.0, 0.0, 0.0, G * k * h, 0.0, 0.0))
        masses.append(law.estimator.mass[0])
    assert law.estimator.filters[0] == pytest.approx(G * exp(-2.0 * 0.99))
    felt_half = 35  # commands until exp(-2 t) is a half
    assert len(set(masses[:felt_half])) == felt_half and set(masses[felt_half:]) == {masses[felt_half - 1]}
    assert law(1.0, (*q[:3], 0.2, 0.0, 0.0), (0.0, 0.0, 0.0, -20.0, 0.0, 0.0))[3] > 0.0
    assert law.estimator.winch_effort[0] == 0.0


@pytest.mark.interpreted
def test_the_reach_bounds_the_slew_alone() -> None:
    """With a reach the slew is pulled by kp e / √(1 + (e/r)²), the other joints as without."""
    scene = crane_sim.load_scene(SCENE, {"payload.mass": 1.0})
    law, q = scene.law, (-2.0, 0.4, -0.3, 1.8, 0.0, 0.0)
    assert law is not None
    linear = crane_sim.load_scene("knuckle_setpoint", {"control.kp": [30, 10, 10, 2]}).law
    assert linear is not None
    bounded, free = law(0.0, q, (0.0,) * 6), linear(0.0, q, (0.0,) * 6)
    e = np.pi / 4 + 2.0
    assert bounded[0] == pytest.approx(30.0 * e / np.sqrt(1.0 + (e / 0.3) ** 2), rel=1e-14)
    assert bounded[1:] == pytest.approx(free[1:], rel=1e-14)


@pytest.mark.interpreted
def test_poles_of_the_plain_law_about_its_target() -> None:
    """Linearised numerically where it ends, the plain law leaves the swing the little damping found elsewhere."""
    scene = crane_sim.load_scene("knuckle_setpoint")
    assert scene.reference and scene.law
    law, step, target = scene.law, 1e-5, np.array([*scene.reference, 0.0, 0.0])
    a, b = linearise(scene, target, np.array(law(0.0, tuple(target), (0.0,) * 6)))
    rows = [(np.concatenate([target, np.zeros(6)]) + d) for d in np.vstack([step * np.eye(12), -step * np.eye(12)])]
    found = np.array([law(0.0, tuple(z[:6]), tuple(z[6:])) for z in rows])
    poles = np.linalg.eigvals(a + b @ ((found[:12] - found[12:]).T / (2.0 * step)))
    swings = sorted(pole for pole in poles if pole.imag > 2.0)
    assert np.all(poles.real < 0.0)
    # given to two digits of the damping and three of the frequency
    assert [z.real for z in swings] == pytest.approx([-0.084, -0.070], abs=6e-4)
    assert [z.imag for z in swings] == pytest.approx([3.17, 2.74], abs=6e-3)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"rope": {"drive": "locked"}}, "possible: rope.drive = 'force'"),
        ({"control.period": "continuous"}, "a law that estimates the mass has memory; give a period"),
        ({"gravity": 0.0}, "without weight the mass cannot be estimated"),
        ({"control.adaptation": {"rate": 0.0}}, "control.adaptation.rate = 0.0: must be greater than 0"),
        ({"control.adaptation": {"speed": 1.0}}, "control.adaptation: unknown key 'speed'"),
        ({"control.reach": -1.0}, "control.reach = -1.0: must be greater than 0"),
    ],
    ids=["locked", "continuous", "gravity", "rate", "speed", "reach"],
)
def test_what_cannot_be_weighed_is_refused_in_one_line(changes: dict[str, Any], line: str) -> None:
    """Cranes without a winch's force, gravity or commands, and settings out of range, name their culprit."""
    with pytest.raises(crane_sim.SceneError) as caught:
        crane_sim.load_scene(SCENE, changes)
    assert line in str(caught.value) and "\n" not in str(caught.value)
