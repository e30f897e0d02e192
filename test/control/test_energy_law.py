"""The energy law: its formula, the shaped energy, closed loops that lose it, LQR's limits.

LQR's limits are what it cannot reach.
"""

import json
from math import cos
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest

import crane_sim
from crane_sim.laws import inner_loop_of, outer_loop_of, with_initial_state
from crane_sim.simulation.rollout import simulate

CASE = next(
    case
    for case in json.loads((Path(__file__).parents[1] / "data" / "knuckle.json").read_text())[
        "trajectories"
    ]
    if case["control"]["kind"] == "energy"
)


def test_efforts_are_the_corrected_formula() -> None:
    """The law's efforts are eq. 15-18 with the misprints corrected, term by term."""
    scene = crane_sim.load_scene("knuckle_wrong_mass")
    law, m = scene.law, 1.01
    assert law is not None
    q, v = (0.1, 0.4, -0.3, 1.8, 0.2, -0.1), (0.3, -0.2, 0.1, 0.05, 0.4, 0.6)
    e = np.subtract(scene.reference, q[:4])
    expected = np.array([30, 10, 10, 1]) * e - np.array([50, 30, 50, 10]) * v[:4]
    expected += [
        0.0,
        9.81 * 5 * cos(0.4) * (m + 1.0 + 3.0),
        9.81 * 4 * cos(-0.3) * (m + 1.5),
        -m * 9.81,
    ]
    assert law(0.0, q, v) == pytest.approx(tuple(expected), rel=1e-14)


@pytest.mark.long
def test_at_the_target_the_law_holds_the_crane_still() -> None:
    """At rest on the target, the efforts leave every joint without acceleration."""
    scene = crane_sim.load_scene("knuckle_setpoint")
    assert scene.reference and scene.law
    q, v = (*scene.reference, 0.0, 0.0), (0.0,) * 6
    assert np.allclose(crane_sim.acceleration(scene, q, v, scene.law(0.0, q, v)), 0.0, atol=1e-13)


def test_the_shaped_energy_equals_the_published_one() -> None:
    """V along the published trajectory is the published V."""
    samples = CASE["samples"]
    scene = crane_sim.load_scene("knuckle_setpoint")
    for sample in samples:
        value, _ = scene.law.lyapunov(sample.get("t", 0.0), tuple(sample["q"]), tuple(sample["qd"]))  # pyright: ignore
        assert value == pytest.approx(sample["V_lyapunov"], abs=1e-12)  # rounding of ~10 J


LOOPS: dict[str, dict[str, Any]] = {
    "plain": {},
    "drag": {"payload_drag": {"coefficient": 0.2}},
    "springs and turning rods": {
        "springs": {
            "boom": {"stiffness": 50.0, "rest": 0.5},
            "rope": {"stiffness": 5.0, "rest": 1.8},
        },
        "boom.axial_inertia": 0.5,
    },
    "large swing": {"initial.q": [0, "30 deg", "-10 deg", 2.0, "60 deg", "-50 deg"]},
}


@pytest.mark.long
@pytest.mark.parametrize("loop", LOOPS, ids=lambda name: name.replace(" ", "-"))
def test_v_only_falls_along_a_continuous_closed_loop(loop: str) -> None:
    """Along every continuous closed loop V never rises, and falls at the proof's rate."""
    run = simulate(crane_sim.load_scene("knuckle_continuous", {"duration": 4.0, **LOOPS[loop]}))
    value, rate = run.lyapunov().T
    assert np.all(rate <= 1e-12)
    # the integrator's tolerance, where V stands still
    assert np.max(np.diff(value)) < 1e-9 * value[0]
    # Simpson's rule over 20 ms, error h^4 / 180 of the fourth derivative, (7 rad/s)^4 of ~1 W
    fallen = np.cumsum((rate[:-2:2] + 4.0 * rate[1:-1:2] + rate[2::2]) * 0.01 / 3.0)
    assert np.allclose(value[2::2] - value[0], fallen, rtol=0, atol=1e-4 * value[0])


@pytest.mark.long
def test_the_rate_of_v_is_that_of_every_instant() -> None:
    """On a moving base, under a varying force, V changes at the law's rate at each instant."""
    wind = {"kind": "sine", "amplitude": 2.0, "frequency": 1.3, "phase": 0.4}
    swell = {
        "surge": {"amplitude": 0.2, "frequency": 1.1, "phase": 0.8},
        "roll": {"amplitude": 0.05, "frequency": 0.9},
    }
    disturbed = {"payload_force": {"x": wind}, "base_motion": swell}
    run = simulate(crane_sim.load_scene("knuckle_continuous", {"duration": 2.0, **disturbed}))
    value, rate = run.lyapunov().T
    # Simpson's rule, as above
    fallen = np.cumsum((rate[:-2:2] + 4.0 * rate[1:-1:2] + rate[2::2]) * 0.01 / 3.0)
    assert np.allclose(value[2::2] - value[0], fallen, rtol=0, atol=1e-4 * value[0])
    assert np.max(rate) > 0.5  # W: V does rise


def test_one_percent_of_payload_mass_moves_the_boom_two_degrees() -> None:
    """A law whose nominal payload is 1 % too heavy ends where gains and weights balance."""
    run = simulate("knuckle_wrong_mass")
    error = np.degrees(run.q[-1, :3] - np.array(run.scene.reference[:3]))  # pyright: ignore
    # kp e = weight of the missing 10 g at the joint: 10 e = 9.81 * 5 * 0.01 cos(b), and 10 e = 9.81
    # * 4 * 0.01 cos(c)
    assert error[1] == pytest.approx(
        np.degrees(9.81 * 5 * 0.01 * cos(run.q[-1, 1]) / 10.0), abs=0.05
    )
    assert error[2] == pytest.approx(
        np.degrees(9.81 * 4 * 0.01 * cos(run.q[-1, 2]) / 10.0), abs=0.05
    )
    assert 1.8 < error[1] < 2.2


def test_lqr_rejects_a_knuckle_boom_straight_up() -> None:
    """With its tip above the tower, slewing does not move the payload.

    No effort damps the swing across the boom.
    """
    target = {"reference": {"q": [0.0, "90 deg", "90 deg", 1.5]}, "control": {"law": "lqr"}}
    with pytest.raises(
        crane_sim.SceneError, match=r"a motion of 2\.56 rad/s .* stays: no effort damps it$"
    ):
        crane_sim.load_scene("knuckle_setpoint", target)


@pytest.mark.parametrize(
    ("law", "message"),
    [
        (lambda t, q, v: [float("nan")] * 4, "efforts that are not finite at t = 0 s"),
        (lambda t, q, v: [0.0, 190.0], "gave 2 efforts at t = 0 s, 4 joints are actuated"),
        (
            lambda t, q, v: 3.0,
            "the law returned 3.0 at t = 0 s, not 4 efforts: return (x,), a tuple",
        ),
        (lambda t, q, v: (1.0 / x for x in (0.0,)), "the law failed at t = 0 s: ZeroDivisionError"),
        (
            lambda t, q, v: int("a\nb"),
            "the law failed at t = 0 s: ValueError: invalid literal for int()",
        ),
    ],
    ids=["not finite", "too few", "a number", "raises later", "two lines"],
)
def test_a_faulty_law_is_a_single_line_error(law: Any, message: str) -> None:
    """A law that raises, or returns no vector of efforts, ends the run.

    The run ends with a single-line error with the time.
    """
    with pytest.raises(RuntimeError) as caught:
        simulate("knuckle_setpoint", law=law, duration=0.1)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_a_law_with_the_deprecated_name_of_its_reset_works() -> None:
    """A law whose method is still called `fresh` gets its initial state.

    A warning names the new name.
    """
    with pytest.warns(DeprecationWarning, match="OldLaw.fresh is now called with_initial_state"):
        assert with_initial_state(OldLaw(3)) == OldLaw(0)


def test_a_law_with_the_deprecated_names_of_its_loops_works() -> None:
    """`slow_half` and `fast_half` of a law are its outer and inner loop.

    A warning names the new name.
    """
    with pytest.warns(DeprecationWarning, match="OldLaw.slow_half is now called outer_loop"):
        assert outer_loop_of(OldLaw(3)) == "outer"
    with pytest.warns(DeprecationWarning, match="OldLaw.fast_half is now called inner_loop"):
        assert inner_loop_of(OldLaw(3)) == OldLaw(1)


class OldLaw(NamedTuple):
    """A law with state and two loops under the old interface."""

    calls: int
    slow_half: Any = "outer"

    def fast_half(self) -> "OldLaw":
        """Return the inner loop."""
        return OldLaw(1)

    def fresh(self) -> "OldLaw":
        """Return the law with its initial state."""
        return OldLaw(0)
