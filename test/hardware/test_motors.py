"""Drives of joints: motor inertia behind gears, torque falling with speed, limit switches."""

from typing import Any

import numpy as np
import pytest
from knuckle_derivation import mass_and_force

import crane_sim
from crane_sim import load_scene

HELD = {"coulomb": 1e6, "static": 1e6}
KNUCKLE: dict[str, Any] = {
    "crane": "knuckle",
    "duration": 2.0,
    "boom": {"length": 5.0, "mass": 2.0, "inertia": 4.0},
    "jib": {"length": 4.0, "mass": 3.0, "inertia": 4.0},
    "tower": {"inertia": 10.0},
    "payload": {"mass": 1.0},
    "initial": {"q": [0, 0.8, -0.25, 2.0, 0.1, 0.2]},
}
MOTOR = {"ratio": 50.0, "inertia": 2e-3, "torque": 2.0, "base_speed": 30.0, "no_load_speed": 120.0}


def test_the_speed_of_a_slew_follows_its_motor() -> None:
    """A slew at full torque speeds up linearly to the base speed, then exponentially.

    It approaches the speed at no load.
    """
    changes = {
        "actuators": {"slew": {"motor": MOTOR}},
        "friction": {"boom": HELD, "jib": HELD},  # one joint moves, and next to nothing hangs on it
        "payload.mass": 1e-13,
        "inputs": {"slew": {"kind": "constant", "value": 1e4}},
        "initial.q": [0, 0.8, -0.25, 2.0, 0, 0],
        "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-13},
    }
    scene = load_scene(KNUCKLE, changes)
    run = crane_sim.simulate(scene)
    energies = [
        crane_sim.energy(scene, scene.initial_q, [rate, 0, 0, 0, 0, 0]) for rate in (0.0, 1.0)
    ]
    inertia = 2.0 * (energies[1] - energies[0])
    peak, base, top = 100.0, 0.6, 2.4
    knee = base * inertia / peak
    late = top - (top - base) * np.exp(-(run.t - knee) * peak / inertia / (top - base))
    expected = np.where(run.t < knee, peak / inertia * run.t, late)
    assert 0.1 < knee < 1.0 and run.v[-1, 0] > 1.4
    assert np.max(np.abs(run.v[:, 0] - expected)) < 1e-9
    assert run.summary["energy_audit_max"] < 1e-9


def test_motors_of_a_knuckle_boom_add_their_inertia() -> None:
    """Accelerations are those of a mass matrix with motor inertia × ratio² on its diagonal."""
    ratios = {"slew": 50.0, "boom": 80.0, "jib": 30.0}
    motors = {name: {"motor": {"ratio": n, "inertia": 2e-3}} for name, n in ratios.items()}
    plain, geared = load_scene(KNUCKLE), load_scene(KNUCKLE, {"actuators": motors})
    rng = np.random.default_rng(2)
    for _ in range(5):
        q, v, u = (
            np.array(plain.initial_q) + rng.normal(0, 0.1, 6),
            rng.normal(0, 1, 6),
            rng.normal(0, 50, 4),
        )
        mass, force = mass_and_force(plain, q, v, u)
        mass[range(3), range(3)] += [2e-3 * n**2 for n in ratios.values()]
        expected = np.linalg.solve(mass, force)
        # two derivations in doubles, as in `test_knuckle`
        assert np.max(np.abs(crane_sim.acceleration(geared, q, v, u) - expected)) < 1e-12 * np.max(
            np.abs(expected)
        )


OVERHEAD: dict[str, Any] = {
    "crane": "overhead",
    "duration": 1.0,
    "trolley": {"mass": 10.0},
    "hoist": {"drive": "force", "inertia": 3.0},
    "cable": {"lengths": 2.0, "node_masses": 5.0},
}


def test_motors_of_an_overhead_crane_add_their_inertia() -> None:
    """Motors of trolley and hoist act as so much more mass of the two."""
    gears = {"trolley": {"ratio": 16.0, "inertia": 0.0625}, "hoist": {"ratio": 4.0, "inertia": 0.5}}
    geared = load_scene(
        OVERHEAD, {"actuators": {name: {"motor": motor} for name, motor in gears.items()}}
    )
    heavier = load_scene(OVERHEAD, {"trolley.mass": 26.0, "hoist.inertia": 11.0})
    state = [0.0, 2.0, 0.4], [0.3, -0.2, 0.5], [20.0, -40.0]
    assert np.array_equal(
        crane_sim.acceleration(geared, *state), crane_sim.acceleration(heavier, *state)
    )


def test_a_motor_without_limit_or_inertia_is_none() -> None:
    """A gear alone leaves the run's bits as they are without it."""
    groups = {"lag": 0.1}, {"lag": 0.1, "motor": {"ratio": 9.0}}
    scenes = [load_scene(OVERHEAD, {"actuators": {"all": group}}) for group in groups]
    assert len({crane_sim.simulate(scene).summary["state_sha256"] for scene in scenes}) == 1


def test_a_limit_switch_stops_its_joint() -> None:
    """A trolley over a limit switch is braked from the next period on.

    It stops after v² / (2 a).
    """
    changes = {
        "hoist": None,
        "payload": {"mass": 1e-9},  # next to nothing hangs on the trolley
        "duration": 2.0,
        "inputs": {"trolley": {"kind": "constant", "value": 20.0}},
        "brake": {"capacity": [40.0]},
        "actuators": {"trolley": {"limit_switches": [-1.0, 1.001]}},
        "trolley.limits": [-2.0, 2.0],
    }
    run = crane_sim.simulate(load_scene(OVERHEAD, changes))
    # at 2 m/s², at the end of the period in which the switch was passed
    seen, speed = 1.01**2, 2.02
    expected = seen - 1.001 + speed**2 / (2.0 * 4.0)
    # the brake's spring gives at the stop: the deceleration times the period squared, and half of
    # that in return
    assert run.summary["overtravel"] == {
        "trolley": pytest.approx(expected, abs=2.0 * 4.0 * 0.01**2)
    }
    assert abs(run.v[-1, 0]) < 1e-3 and run.q[-1, 0] == pytest.approx(1.001 + expected, abs=1e-2)


IMPOSSIBLE: dict[str, tuple[Any, dict[str, Any], str]] = {
    "half a curve": (
        KNUCKLE,
        {"actuators.slew.motor": {"ratio": 9, "torque": 1}},
        "slew.motor.no_load_speed: is miss",
    ),
    "no curve": (
        KNUCKLE,
        {"actuators.slew.motor": {"ratio": 9, "base_speed": 5}},
        "base_speed = 5: belongs to",
    ),
    "rising": (
        KNUCKLE,
        {"actuators.slew.motor": MOTOR | {"base_speed": 120}},
        "base_speed = 120: .* no_load_speed",
    ),
    "winch": (KNUCKLE, {"actuators.rope.motor": MOTOR}, "rope.motor.inertia: .* rope.drive: force"),
    "imposed": (
        KNUCKLE,
        {"actuators.all.motor": MOTOR, "rope.drive": "rate"},
        "all.motor: .* rope is driven in m/s²",
    ),
    "massless": (
        OVERHEAD,
        {"actuators.hoist.motor": MOTOR, "hoist": {"drive": "force"}},
        "motor.inertia: .* hoist.in",
    ),
    "switch": (
        KNUCKLE,
        {"actuators.slew.limit_switches": [0.1, 1]},
        "slew.limit_switches = .*: the slew starts outs",
    ),
    "switch and limit": (
        KNUCKLE,
        {"actuators.slew.limit_switches": [-1, 1], "tower.limits": [-2, 0.5]},
        "slew.limit_switches = .* within tower.limits",
    ),
    "on a base": (
        OVERHEAD,
        {
            "actuators.trolley.motor": MOTOR,
            "base_motion": {"surge": {"amplitude": 0.1, "frequency": 1.0}},
        },
        "actuators.trolley.motor.inertia: .* base_motion",
    ),
}


@pytest.mark.parametrize("case", IMPOSSIBLE, ids=lambda name: name.replace(" ", "-"))
def test_motors_that_do_not_fit_are_named(case: str) -> None:
    """A motor that contradicts itself or its drive is refused by one line with the keys of both."""
    scene, changes, line = IMPOSSIBLE[case]
    with pytest.raises(crane_sim.SceneError, match=line):
        load_scene(scene, changes)
