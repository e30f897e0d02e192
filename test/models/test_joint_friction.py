"""Friction of joints of tower, mobile, bridge and gantry cranes: events, bristles, motors."""

from typing import Any

import mpmath
import numpy as np
import pytest
from friction_events import Rubbing, sines
from mpmath import mp, mpf

import crane_sim
from crane_sim import load_scene, system
from crane_sim.models.energy_meter import Meter
from crane_sim.models.guards import Guard, encode

ACCURATE = {"method": "dop853", "rtol": 1e-12, "atol": 1e-12}
BRIDGE: dict[str, Any] = {
    "crane": "bridge",
    "duration": 2.0,
    "trolley": {"mass": 1000.0},
    "bridge": {"mass": 3000.0},
    "payload": {"mass": 800.0},
    "rope": {"drive": "locked"},
    "initial": {"q": [0.0, 0.0, 5.0, 0.1, 0.05]},
    "integrator": ACCURATE,
}
AMPLITUDE, FREQUENCY, COULOMB, STATIC = 900.0, 3.0, 500.0, 700.0


def bridge_events(end: float) -> list[tuple[float, str]]:
    """Return the events of a mass on a rail under a sinusoidal force, from its speed's roots.

    They have 30 digits.
    """
    with mp.workdps(30):
        a, w, fc, breaks = (
            mpf(AMPLITUDE),
            mpf(FREQUENCY),
            mpf(COULOMB),
            mpmath.asin(mpf(STATIC) / mpf(AMPLITUDE)),
        )
        t, k, events = breaks / w, 0, []
        while t < end:
            sign, begin = (-1) ** k, t
            events.append(
                (t, "the bridge slips forwards" if sign > 0 else "the bridge slips backwards")
            )

            def momentum(at: Any, begin: Any = begin, sign: int = sign) -> Any:
                return sign * a / w * (mpmath.cos(w * begin) - mpmath.cos(w * at)) - fc * (
                    at - begin
                )

            t = mpmath.findroot(
                momentum, (begin + mpf("0.7"), begin + mpf("1.0")), solver="anderson"
            )
            assert abs(a * mpmath.sin(w * t)) < STATIC and t - begin > mpf("0.7")
            events.append((t, "the bridge sticks"))
            k += 1
            t = (breaks + k * mp.pi) / w
        return [(float(at), what) for at, what in events if at < end]


def test_a_bridge_sticks_and_slips_at_the_instants_of_the_closed_form() -> None:
    """Under a sinusoidal force, with its trolley held, a bridge sticks and slips at the roots.

    The roots are those of its speed.
    """
    sine = {"kind": "sine", "amplitude": AMPLITUDE, "frequency": FREQUENCY}
    group = {
        "bridge": {"coulomb": COULOMB, "static": STATIC},
        "trolley": {"coulomb": 1.0, "static": 1.0},
    }
    # kg: a part of 1e-13
    light = {"payload": {"mass": 1e-9}, "initial": {"q": [0.0, 0.0, 5.0, 0.0, 0.0]}}
    run = crane_sim.simulate(
        BRIDGE | light | {"duration": 4.0, "friction": group, "inputs": {"bridge": sine}}
    )
    expected = bridge_events(4.0)
    assert len(expected) == 7 and [what for _, what in run.events] == [what for _, what in expected]
    np.testing.assert_allclose(
        [t for t, _ in run.events], [t for t, _ in expected], rtol=0.0, atol=1e-12
    )
    assert run.summary["energy_audit_max"] < 1e-9


# mass, centre, inertia of the base section and of the telescoped one
SECTIONS = (5.0, 2.0, 4.0), (3.0, 1.5, 2.0)
FOOT, SUPERSTRUCTURE, LOAD, ROPE = (0.5, 1.2), 30.0, 10.0, 2.5
DRY: Rubbing = {
    "slew": {"coulomb": 18.0, "static": 24.0, "stribeck": 0.05},
    "boom": {"coulomb": 95.0, "static": 110.0, "viscous": 5.0},
    "telescope": {"coulomb": 25.0, "static": 32.0, "stribeck": 0.1, "viscous": 2.0},
}
WAVES = {"slew": (30.0, 4.0, 0.0), "boom": (160.0, 7.0, 781.0), "telescope": (60.0, 5.0, 74.0)}
MOBILE: dict[str, Any] = {
    "crane": "mobile",
    "duration": 2.0,
    "superstructure": {"inertia": SUPERSTRUCTURE, "foot": list(FOOT)},
    "boom": dict(zip(("mass", "centre", "inertia"), SECTIONS[0], strict=True)),
    "telescope": dict(zip(("mass", "centre", "inertia"), SECTIONS[1], strict=True)),
    "rope": {"drive": "locked"},
    "payload": {"mass": LOAD},
    "initial": {"q": [0.0, 0.6, 7.0, ROPE, 0.01, 0.05]},
    "inputs": sines(WAVES),
    "integrator": ACCURATE,
}
BRISTLES: Rubbing = {
    "trolley": {
        "coulomb": 60.0,
        "static": 90.0,
        "stribeck": 0.05,
        "stiffness": 4e4,
        "damping": 300.0,
    },
    "bridge": {
        "coulomb": 90.0,
        "static": 120.0,
        "stribeck": 0.1,
        "stiffness": 9e4,
        "damping": 900.0,
        "viscous": 30.0,
    },
}
SEA = {
    "roll": {"amplitude": 0.1, "frequency": 0.9, "phase": 1.0},
    "heave": {"amplitude": 0.8, "frequency": 1.1},
}
MOVES = {"initial": {"q": [0.2, 0.6, 7.0, ROPE, 0.1, 0.2], "v": [0.3, 0.0, -0.2, 0.0, 0.4, -0.3]}}
DRAGS = {
    name: group | {"stribeck": 0.1, "stiffness": 900.0, "damping": 30.0}
    for name, group in DRY.items()
}
METERED: dict[str, dict[str, Any]] = {
    "by bristles at sea": {"lugre": DRAGS, "base_motion": SEA},
    "motors at sea": {
        "friction": DRY,
        "base_motion": SEA,
        "actuators": {"slew": {"motor": {"ratio": 9, "inertia": 0.2}}},
    },
}


@pytest.mark.parametrize("case", METERED)
def test_the_meter_counts_what_friction_takes(case: str) -> None:
    """The crane's energy changes by the power that the meter counts, friction's losses too."""
    p = load_scene(MOBILE | MOVES, METERED[case]).model
    assert p.support.frictions is not None
    q, v = (np.array(MOVES["initial"][key]) for key in ("q", "v"))
    x, u, t, h = system.state(p, 0.7, q, v), (30.0, 700.0, 50.0), 0.7, 1e-6
    rates = system.rhs(p, t, x, u)
    low, high = (
        system.kinetic(p, y) + system.potential(p, y) for y in (x - h * rates, x + h * rates)
    )
    metered = system.power(p, t, x, u)
    # h², rounding / h
    assert (high - low) / (2.0 * h) == pytest.approx(metered, abs=1e-8 * (abs(metered) + abs(low)))
    assert metered in rates


def test_motors_are_mass_of_the_joints_on_a_base_at_rest() -> None:
    """The motor of a bridge moves like as much mass, but does not weigh on a moving base."""
    motor = {"actuators": {"bridge": {"motor": {"ratio": 50.0, "inertia": 0.2}}}}  # 500 kg
    for base, same in (
        ({}, True),
        ({"base_motion": {"sway": {"amplitude": 0.5, "frequency": 1.0}}}, False),
    ):
        geared, heavy = (
            load_scene(BRIDGE | base, motor),
            load_scene(BRIDGE | base, {"bridge.mass": 3500.0}),
        )
        results = []
        for scene in (geared, heavy):
            x = system.state(scene.model, 0.7, np.array(scene.initial_q), np.zeros(5))
            results.append(system.acceleration(scene.model, 0.7, x, (100.0, -300.0)))
        assert np.allclose(*results, rtol=0.0, atol=1e-13) == same


FULL = {
    "friction": {
        "trolley": {"coulomb": 90.0, "static": 120.0},
        "bridge": {"coulomb": 150.0, "static": 250.0},
    },
    "backlash": {"bridge": [{"inertia": 500.0, "play": 0.01, "stiffness": 1e6, "damping": 2e3}]},
    "rope": {
        "slack": "stop",
        "friction": {"coulomb": 40.0, "static": 60.0},
        "reeving": {"falls": 2, "length": 40.0},
    },
}


def test_friction_plays_and_reeved_winches_meet() -> None:
    """Joints with friction, drives with play and a winch that sticks keep the energy.

    The joints are behind the drives; modes have their places.
    """
    efforts = {
        "bridge": {"kind": "constant", "value": 900.0},
        "rope": {"kind": "constant", "value": -7848.0},
    }
    scene = load_scene(BRIDGE | FULL, {"duration": 0.6, "inputs": efforts})
    p, q = scene.model, np.array(scene.initial_q)
    x = system.state(p, 0.0, q, np.array([0.1, -0.2, 0.0, 0.0, 0.0, 0.3]))
    assert list(x[-4:]) == [0.0, 0.0, 1.0, -1.0]  # winch, drive in its play, trolley, bridge
    run = crane_sim.simulate(scene)
    texts = [text for _, text in run.events]
    assert {
        "the trolley slips forwards",
        "the bridge slips forwards",
        "drive 1 of the bridge pushes forwards",
    } <= {*texts}
    assert run.summary["energy_audit_max"] < 1e-9


def test_an_impact_breaks_joints_loose() -> None:
    """A load taken up moves a sticking trolley as a free one: finite forces hold no impulse."""
    taken: dict[str, Any] = {
        "events": [{"at": 0.1, "set": {"payload": {"mass": 1600.0}}, "velocity": [2.0, -1.0, 0.0]}]
    }
    taken["initial"] = {"q": [0.0, 0.0, 5.0, 0.4, 0.3]}
    group, results = {"friction": dict.fromkeys(BRISTLES, {"coulomb": 90.0, "static": 5e3})}, []
    for extra in (group, {"lugre": BRISTLES}, {}):
        scene = load_scene(BRIDGE | taken | extra)
        x = system.state(
            scene.model, 0.1, np.array(scene.initial_q), np.array([0.0, 0.0, 0.0, 0.3, -0.2])
        )
        y, _, continues = system.apply_reset_map(
            scene.model, 0.1, x, (0.0, 0.0), encode(Guard.PAYLOAD, 0)
        )
        assert continues
        results.append((system.joints(scene.model, y)[1], y[-2:]))
    (sticks, modes), (bends, bristles), (free, _) = results
    np.testing.assert_allclose([sticks, bends], [free, free], rtol=0.0, atol=1e-14)  # rounding
    assert abs(free[:2]).min() > 1e-3
    assert list(modes) == list(np.sign(free[:2])) and list(bristles) == [0.0, 0.0]


DRAGGED: dict[str, dict[str, Any]] = {
    "sticks": {
        "friction": {
            "bridge": {"coulomb": 4e3, "static": 9e4},
            "trolley": {"coulomb": 900.0, "static": 1e3},
        }
    },
    "bristles": {"lugre": {"bridge": BRISTLES["bridge"] | {"coulomb": 4e3, "static": 6e3}}},
}


@pytest.mark.parametrize("case", DRAGGED)
def test_a_gantry_with_friction_moves_as_one_under_its_forces(case: str) -> None:
    """Below falls: accelerations are those without friction under its forces.

    The meter counts these.
    """
    plain, scene = load_scene("spreader_skew"), load_scene("spreader_skew", DRAGGED[case])
    q, v, u = np.array(plain.initial_q), np.zeros(len(plain.initial_q)), (300.0, 500.0, 0.1)
    v[:7] = 0.1, 0.0 if case == "sticks" else 0.2, -0.1, 0.05, 0.1, 0.02, 0.0
    p, free = scene.model._replace(energy_meter=Meter()), plain.model
    x, y = system.state(p, 0.0, q, v), system.state(free, 0.0, q, v)
    got = system.acceleration(p, 0.0, x, u)
    if case == "sticks":
        gantry = free.support.structure
        load = (gantry.trolley.mass + gantry.bridge.mass) * system.acceleration(free, 0.0, y, u)[1]
        forces = 300.0 - 900.0, 500.0 - load, 0.1
        slides, breaks = (
            system.guard(p, 0.0, x, u, None),
            system.guard(p, 0.0, x, (300.0, 9e4 - load + 501.0, 0.1), None),
        )
        assert slides[:2] == (0.1, encode(Guard.FRICTION, 0)) and got[1] == 0.0
        assert breaks[:2] == (pytest.approx(-1.0, rel=1e-9), encode(Guard.FRICTION, 1))
    else:
        # bristles bent as in steady motion
        forces = 300.0, 500.0 - 4e3 - 2e3 * np.exp(-4.0) - 30.0 * 0.2, 0.1
    expected = system.acceleration(free, 0.0, y, forces)
    # rounding of forces of 1e4 N on 1e3 kg
    np.testing.assert_allclose(got, expected, rtol=0.0, atol=1e-11)
    rates, h = system.rhs(p, 0.0, x, u), 1e-6
    low, high = (
        system.kinetic(p, z) + system.potential(p, z) for z in (x - h * rates, x + h * rates)
    )
    metered = rates[2 * len(got)]
    # h², rounding / h
    assert (high - low) / (2 * h) == pytest.approx(metered, abs=1e-8 * (abs(metered) + abs(low)))


LOCKED = {
    "crane": "tower",
    "duration": 1.0,
    "slew": {"drive": "locked"},
    "trolley": {"mass": 100.0},
    "payload": {"mass": 9.0},
}
LOCKED = LOCKED | {"initial": {"q": [0.0, 6.0, 5.0, 0.0, 0.0]}}
SOME = {"coulomb": 3.0, "static": 5.0}
MOTOR = {"motor": {"ratio": 10.0, "inertia": 0.1}}
REJECTED: dict[str, tuple[dict[str, Any], dict[str, Any], str]] = {
    "unknown": (
        BRIDGE,
        {"friction": {"slew": SOME}},
        r"friction: unknown joint 'slew' \(known: trolley, bridge\)",
    ),
    "both": (
        BRIDGE,
        {"friction": {"bridge": SOME}, "lugre": BRISTLES},
        "lugre.bridge: stands beside friction.bridge",
    ),
    "locked": (
        LOCKED,
        {"friction.slew": SOME},
        "friction.slew: belongs to a joint .* slew.drive is 'locked'",
    ),
    "locked motor": (
        LOCKED,
        {"actuators.slew": MOTOR},
        "actuators.slew.motor.inertia: .* slew.drive is 'locked'",
    ),
    "two inertias": (
        BRIDGE,
        {"backlash": FULL["backlash"], "actuators.bridge": MOTOR},
        "actuators.bridge.motor.inertia: stands beside backlash.bridge",
    ),
}


@pytest.mark.parametrize("case", REJECTED)
def test_friction_and_motors_that_cannot_be_are_named(case: str) -> None:
    """Each contradiction is one line that begins with the key."""
    scene, changes, line = REJECTED[case]
    with pytest.raises(crane_sim.SceneError, match=line) as error:
        load_scene(scene, changes)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("name", "joint", "frequency"),
    [
        ("spreader_skew", "trolley", 6086.0),  # √(k / m) of a trolley of 27 t
        (
            "tower_flexible_jib",
            "slew",
            500.0,
        ),  # on the drive's side, the slew inertia without the jib's
    ],
)
def test_a_fixed_step_is_judged_by_the_bristles(name: str, joint: str, frequency: float) -> None:
    """A step that a joint on bristles of 1e12 N/m, or N m/rad, cannot bear is refused.

    The message names the frequency of joint and bristles.
    """
    stiff = BRISTLES["trolley"] | {"stiffness": 1e12}
    changes = {
        "lugre": {joint: stiff},
        "integrator": {"method": "rk4", "step": 0.006},
        "control": None,
    }
    with pytest.raises(crane_sim.SceneError) as error:
        load_scene(name, changes | {"reference": None})
    line, stiffest = (
        str(error.value),
        "integrator.step = 0.006: too large for the stiffest motion, ",
    )
    assert float(line.partition(stiffest)[2].split()[0]) == pytest.approx(frequency, rel=1e-3)
