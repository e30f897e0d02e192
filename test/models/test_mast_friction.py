"""Dry friction of slew and trolley on a mast that bends: constraints that break loose in time."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import load_scene, system

SCENE = "tower_sway"
RUBS = {"slew": {"coulomb": 1e4, "static": 1.2e4}, "trolley": {"coulomb": 600.0, "static": 900.0}}
FREE = {"actuators": {}, "inputs": None, "rope.drive": "rate"}
EXACT = {"integrator": {"method": "dop853", "rtol": 1e-11, "atol": 1e-12}}
JOINTS = ("slew", "trolley")
RATES = {"slew": 0.02, "trolley": 0.4}
SEA = {"roll": {"amplitude": 0.01, "frequency": 0.6}, "surge": {"amplitude": 0.2, "frequency": 0.8}}


def accelerate(scene: Any, rates: dict[str, float], u: np.ndarray) -> np.ndarray:
    """Return accelerations of a crane that swings on a bent mast, first joints at `rates`."""
    q, v = np.array(scene.initial_q), np.zeros(len(scene.joint_names))
    q[3:5] = 0.2, -0.1
    q[-2:] += 0.01, -0.02
    v[2:5], v[-2:] = (0.1, 0.05, -0.04), (0.01, 0.02)
    for name, rate in rates.items():
        v[JOINTS.index(name)] = rate
    x = system.state(scene.model, 0.0, q, v)
    return np.array(system.acceleration(scene.model, 0.0, x, tuple(u.tolist())))


@pytest.mark.parametrize("base", [{}, {"base_motion": SEA}], ids=["at rest", "at sea"])
@pytest.mark.parametrize("held", [("slew",), ("trolley",), JOINTS], ids="+".join)
def test_a_joint_that_sticks_is_a_constraint(held: tuple[str, ...], base: dict[str, Any]) -> None:
    """Accelerations are those without friction, under efforts that keep the held joints at rest.

    Accelerations are linear in the efforts, so that these follow from the free crane alone; joints
    that slip have Coulomb's friction besides.
    """
    free, rubbing = (
        load_scene(SCENE, FREE | base),
        load_scene(SCENE, FREE | base | {"friction": RUBS}),
    )
    rates = {name: 0.0 if name in held else rate for name, rate in RATES.items()}
    u, rows = np.array([5e4, -300.0, 0.02]), [JOINTS.index(name) for name in held]
    slipping = u - np.array(
        [*(0.0 if name in held else RUBS[name]["coulomb"] for name in JOINTS), 0.0]
    )
    start = accelerate(free, rates, slipping)
    steps = np.eye(3)[rows] * 1e4
    changes = np.array([accelerate(free, rates, slipping + step) - start for step in steps])
    shares = np.linalg.solve(changes[:, rows].T, -start[rows])
    expected = start + shares @ changes
    found = accelerate(rubbing, rates, u)
    assert np.all(found[rows] == 0.0) and abs(expected).max() > 1e-3
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=1e-9 * abs(start).max())


def test_joints_break_loose_at_their_static_friction() -> None:
    """The slew sticks up to its static friction, the trolley up to that less the jib's slope."""
    rise, pull = 2.4e4, 1.8e3  # N m/s, N/s
    inputs = {
        "slew": {"kind": "table", "times": [0, 20], "values": [0, 20 * rise]},
        "trolley": {"kind": "table", "times": [0, 20], "values": [0, 20 * pull]},
    }
    for joint, rate in (("slew", rise), ("trolley", pull)):
        changes = {"friction": RUBS, "inputs": {joint: inputs[joint]}, "duration": 0.6}
        run = crane_sim.simulate(load_scene(SCENE, FREE | EXACT | changes))
        a, b = run.q[0, -2:]
        hung = 550.0 + 450.0 + 4000.0  # kg, trolley, hook and load
        down = hung * run.scene.file.gravity * np.cos(a) * np.sin(b) if joint == "trolley" else 0.0
        (instant, what), *_ = run.events
        assert what == f"the {joint} slips forwards"
        assert rate * instant == pytest.approx(RUBS[joint]["static"] - down, rel=1e-9)


@pytest.mark.long
def test_energy_balances_through_stick_and_slip() -> None:
    """At sea, slew and trolley stick and slip as the head sways: no energy appears or is lost."""
    table = {"kind": "table", "times": [0, 0.3, 1, 1.2], "values": [0, 1.5e5, 1.5e5, 0]}
    pulls = {"kind": "table", "times": [0, 0.2, 0.5, 0.6], "values": [0, 5000, 5000, 0]}
    friction = {
        name: part | {"coulomb": 5 * part["coulomb"], "static": 6 * part["coulomb"]}
        for name, part in RUBS.items()
    }
    changes = {
        "friction": friction,
        "inputs": {"slew": table, "trolley": pulls},
        "duration": 3.0,
        "base_motion": SEA,
    }
    run = crane_sim.simulate(load_scene(SCENE, FREE | EXACT | changes))
    what = {text for _, text in run.events}
    assert {
        f"the {name} {does}" for name in JOINTS for does in ("slips forwards", "sticks")
    } <= what
    assert run.summary["energy_audit_max"] < 1e-9
