"""Drives with play, against two masses in closed form, cranes without play, and energy balance."""

from math import atan, pi, sqrt
from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim import system
from crane_sim.models.cables.chain import Chain
from crane_sim.models.carrier.layout import layout_of
from crane_sim.models.energy_meter import Meter
from crane_sim.models.guards import Guard, encode
from crane_sim.models.loads import PointLoad
from crane_sim.models.stops import Stops
from crane_sim.models.supports.backlash import Drive
from crane_sim.models.supports.bridge import Bridge, BridgeAxis
from crane_sim.models.supports.hoist import ForceHoist
from crane_sim.models.supports.support import Support
from crane_sim.models.supports.telescopic_boom import (
    BaseSection,
    Superstructure,
    TelescopedSection,
    TelescopicBoom,
)
from crane_sim.models.supports.tower_crane import JibTrolley, Slew, TowerCrane
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.simulation.hardware import joint_mechanics
from crane_sim.simulation.plant import Plant

SUPPORTS = {
    "tower": (TowerCrane(Slew(900.0), JibTrolley(8.0)), (0.4, 6.0), (0.3, -0.2)),
    "bridge": (Bridge(BridgeAxis(8.0), BridgeAxis(30.0)), (0.4, 1.0), (0.3, -0.2)),
    "mobile": (
        TelescopicBoom(
            Superstructure(30.0, (0.5, 1.2)),
            BaseSection(5.0, 2.0, 4.0),
            TelescopedSection(3.0, 1.5, 2.0),
        ),
        (0.4, 0.6, 7.0),
        (0.3, -0.2, 0.1),
    ),
}
# rope, swing, second link: q, v
RIGGING = (2.5, 0.2, -0.3, 0.0, 0.6, -0.8), (0.1, 0.3, -0.2, 0.4, 0.0, 0.0)
PLAY, STIFFNESS, DAMPING = (0.02, 0.03, 0.01), (4e3, 5e3, 6e3), (20.0, 30.0, 0.0)
INERTIA, SHARE = (1.5, 2.0, 3.0), (0.4, 0.6, 1.0)
EFFORTS = (12.0, -7.0, 5.0)
# (lead of the drive over its joint, its relative velocity, mode): in the gap, and on either flank
CASES = {
    "gap": (0.001, 0.1, 0.0),
    "forwards": (0.02, -0.05, 1.0),
    "backwards": (-0.02, 0.05, -1.0),
    "leaving": (0.016, -5.0, 2.0),  # compressed, but faster away than the shaft relaxes
}
Drives = tuple[tuple[Drive, ...], ...]
"""Drives with play of each coordinate."""


def crane(name: str, drives: Drives | None) -> SuspendedCrane:
    """Return a crane with two links and a point mass, its support with drives or without."""
    structure, q, _ = SUPPORTS[name]
    filled = None if drives is None else (*drives, *((),) * (len(q) - len(drives)))
    whole = Support(structure, drives=filled)
    chain = Chain(np.array([2.0, 5.0]), np.array([2.5, 1.2]))
    return SuspendedCrane(
        whole, chain, PointLoad(5.0), ForceHoist(1.5), energy_meter=Meter(), stops=Stops()
    )


def posture(name: str, leads: Any) -> tuple[Any, Any]:
    """Return (q, v) of the joints with drives ahead of joints 0, 0 and 1.

    `leads` are (position, velocity) each.
    """
    q, v = SUPPORTS[name][1:]
    lead = [(q[j] + a, v[j] + b) for j, (a, b) in zip((0, 0, 1), leads, strict=True)]
    (joints, rates), ends = RIGGING, list(zip(*lead, strict=True))
    return np.array([*q, *joints, *ends[0]]), np.array([*v, *rates, *ends[1]])


def drives() -> Drives:
    """Return two drives of the first joint and one of the second one."""
    first, second, third = map(Drive, INERTIA, SHARE, PLAY, STIFFNESS, DAMPING)
    return (first, second), (third,)


@pytest.mark.parametrize(
    ("name", "case"),
    [("tower", "gap"), ("tower", "leaving"), ("bridge", "forwards"), ("mobile", "backwards")],
)
def test_a_joint_moves_by_what_its_shafts_push(name: str, case: str) -> None:
    """Joints move as without play under the shafts' forces, drives by efforts less these.

    The energy of masses, springs and weight changes by the power that the meter counts.
    """
    lead, rate, mode = CASES[case]
    p, plain, ns = crane(name, drives()), crane(name, None), len(SUPPORTS[name][1])
    q, v = posture(name, ((lead, rate), (0.0, 0.2), (lead, rate)))
    x, u = system.state(p, 0.0, q, v), (*EFFORTS[:ns], -60.0)
    # the shaft without damping pushes until its spring is at rest
    last = 1.0 if case == "leaving" else mode
    assert list(x[-3:]) == [mode, 0.0, last]
    push = [0.0] * 3
    for i, m in ((0, mode), (2, last)):
        push[i] = (
            m * (STIFFNESS[i] * (abs(lead) - PLAY[i] / 2) + DAMPING[i] * m * rate)
            if abs(m) == 1.0
            else 0.0
        )
    u_plain = (push[0] + push[1], push[2], *EFFORTS[2:ns], -60.0)
    y = system.state(plain, 0.0, q[:-3], v[:-3])
    got, expected = system.acceleration(p, 0.0, x, u), system.acceleration(plain, 0.0, y, u_plain)
    # rounding
    np.testing.assert_allclose(
        got[:-3], expected, rtol=0.0, atol=1e-12 * max(1.0, abs(expected).max())
    )
    own = [(SHARE[i] * EFFORTS[j] - push[i]) / INERTIA[i] for i, j in enumerate((0, 0, 1))]
    np.testing.assert_allclose(got[-3:], own, rtol=1e-12)
    read = system.joints(p, x)
    # rounding of swing angles
    np.testing.assert_allclose(np.array(read), np.array([q, v]), rtol=0.0, atol=1e-14)
    check_meter(p, x, u)


def check_meter(p: Any, x: Any, u: Any) -> None:
    """Assert that the energy changes by the power that the meter counts."""
    rates, h = system.rhs(p, 0.0, x, u), 1e-6
    low, high = (
        system.kinetic(p, y) + system.potential(p, y) for y in (x - h * rates, x + h * rates)
    )
    metered = rates[2 * layout_of(p)[0]]
    scale = abs(metered) + abs(low)
    assert (high - low) / (2 * h) == pytest.approx(metered, abs=1e-8 * scale)  # h², rounding / h


@pytest.mark.parametrize("case", ["gap", "forwards"])
def test_a_gantry_moves_by_what_its_shafts_push(case: str) -> None:
    """Below falls: accelerations are those under the shafts' forces, and all power is metered."""
    (lead, rate, mode), play, stiffness, damping = CASES[case], 0.02, 4e5, 2e3
    gears = [{"inertia": 900.0, "play": play, "stiffness": stiffness, "damping": damping}]
    plain = crane_sim.load_scene("spreader_skew")
    geared = crane_sim.load_scene("spreader_skew", {"backlash": {"bridge": gears}})
    q, v = np.array(plain.initial_q), np.zeros(len(plain.initial_q))
    v[:7] = 0.1, 0.2, -0.1, 0.05, 0.1, 0.02, 0.0
    p, u = geared.model._replace(energy_meter=Meter()), (300.0, 500.0, 0.1)
    x = system.state(p, 0.0, np.array([*q, q[1] + lead]), np.array([*v, v[1] + rate]))
    assert x[-1] == mode
    push = (
        mode * (stiffness * (abs(lead) - play / 2) + damping * mode * rate)
        if abs(mode) == 1.0
        else 0.0
    )
    y = system.state(plain.model, 0.0, q, v)
    got, u_plain = system.acceleration(p, 0.0, x, u), (300.0, push, 0.1)
    expected = system.acceleration(plain.model, 0.0, y, u_plain)
    # rounding
    np.testing.assert_allclose(got, [*expected, (500.0 - push) / 900.0], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(np.array(system.joints(p, x))[:, -1], [q[1] + lead, v[1] + rate])
    check_meter(p, x, u)


def test_contact_begins_and_ends_by_its_guards() -> None:
    """The guard of a drive fails where it touches and pushes, or where a contact would pull."""
    p, u = crane("bridge", ((), (Drive(2.0, 1.0, 0.02, 4e3, 20.0),))), (0.0, 0.0, -60.0)
    q, v = posture("bridge", ((0.0, 0.0),) * 3)
    q, v = np.array([*q[:8], q[1] + 0.011]), np.array([*v[:8], v[1] + 0.1])
    touching = system.state(p, 0.0, q, v)
    free = touching.copy()
    free[-1] = 0.0
    value, number, _ = system.guard(p, 0.0, free, u, system.workspace(p))
    assert (value, number) == (pytest.approx(-0.001), encode(Guard.BACKLASH, 0))
    after, event, continues = system.apply_reset_map(p, 0.0, free, u, number)
    np.testing.assert_array_equal(after, touching)
    assert continues and system.describe_event(p, event) == (
        "drive 1 of the bridge pushes forwards",
        "",
    )
    v[-1] = v[1] - 0.3  # 4e3 × 0.001 < 20 × 0.3: it would pull
    pulling = system.state(p, 0.0, q, v)
    assert pulling[-1] == 2.0
    pulling[-1] = 1.0
    value, number, _ = system.guard(p, 0.0, pulling, u, system.workspace(p))
    assert value == pytest.approx(-2.0)
    after, event, _ = system.apply_reset_map(p, 0.0, pulling, u, number)
    assert after[-1] == 2.0 and "does not push any more" in system.describe_event(p, event)[0]
    x = system.state(p, 0.0, np.array([*q[:8], q[1] + 0.009]), v)
    x[-1] = 2.0  # it has come apart
    value, number, _ = system.guard(p, 0.0, x, u, system.workspace(p))
    assert (
        value == pytest.approx(-0.001)
        and system.apply_reset_map(p, 0.0, x, u, number)[0][-1] == 0.0
    )


def test_brakes_are_chosen_for_the_joint_behind_the_play() -> None:
    """Inertias and loads that brakes are chosen by are those of the crane without play.

    Play would hide them.
    """
    with_play = joint_mechanics(crane_sim.load_scene("tandem_play"))
    without = joint_mechanics(crane_sim.load_scene("tandem_play", {"backlash": {}}))
    for got, expected in zip(with_play, without, strict=True):
        np.testing.assert_allclose(got, expected, rtol=1e-12)  # rounding of energies


MASS, MOTOR, SPRING, GAP = 9000.0, 1000.0, 4e6, 0.02  # kg, kg, N/m, m
FREE = {
    "crane": "bridge",
    "duration": 3.0,
    "gravity": 0.0,
    "trolley": {"mass": 1000.0},
    "bridge": {"mass": MASS - 1000.0},
    "payload": {"mass": 1e-9},  # kg: the bridge and its drive are two masses, up to a part of 1e-13
    "rope": {"drive": "locked"},
    "initial": {"q": [0.0, 0.0, 5.0, 0.0, 0.0]},
    "backlash": {"bridge": [{"inertia": MOTOR, "play": GAP, "stiffness": SPRING}]},
    "inputs": {"bridge": {"kind": "constant", "value": 0.0}},
    "integrator": {"method": "dop853", "rtol": 1e-12, "atol": 1e-12},
}


def contacts(summary: dict[str, Any]) -> list[float]:
    """Return the instants [s] of a run's events."""
    return [event["t"] for event in summary["events"]]


@pytest.mark.long
def test_a_drive_that_bounces_in_its_play_has_the_period_of_two_masses() -> None:
    """Without damping, flights across the gap and half oscillations follow in closed form.

    The oscillations are those of the two masses.
    """
    plant, v = Plant(crane_sim.load_scene(FREE)), 0.1
    plant.reset(None, [0.0, 0.0, 0.0, 0.0, 0.0, v])
    for _ in range(plant.scene.steps):
        plant.advance(None)
        # momentum
        assert MASS * plant.v[1] + MOTOR * plant.v[5] == pytest.approx(MOTOR * v, rel=1e-12)
    flight, touch = GAP / v, pi * sqrt(MOTOR * MASS / (MOTOR + MASS) / SPRING)
    expected = [0.5 * flight + (k + 1) // 2 * touch + k // 2 * flight for k in range(12)]
    summary = plant.summary()
    # of the tolerance, over the run
    assert contacts(summary)[:12] == pytest.approx(expected, abs=1e-10)
    assert summary["energy_audit_max"] < 1e-9


@pytest.mark.long
def test_a_drive_that_is_pushed_bounces_on_one_flank() -> None:
    """Parabolas in the gap and arcs on the flank make a limit cycle under a constant force.

    Its period is in closed form.

    The drive starts at the other flank and crosses the whole gap first.
    """
    force = 800.0
    gears = {"bridge": [FREE["backlash"]["bridge"][0] | {"offset": -0.5 * GAP}]}
    inputs = {"bridge": {"kind": "constant", "value": force}}
    summary = crane_sim.simulate(FREE | {"backlash": gears, "inputs": inputs}).summary
    crossing, acceleration = sqrt(2.0 * GAP * MOTOR / force), force / MOTOR
    speed, frequency = acceleration * crossing, sqrt(SPRING * (1.0 / MOTOR + 1.0 / MASS))
    rest = acceleration / frequency**2  # compression at which both accelerate alike
    touch = 2.0 * (pi - atan(speed / frequency / rest)) / frequency
    flight = 2.0 * speed / acceleration
    expected = [crossing + k // 2 * (touch + flight) + k % 2 * touch for k in range(8)]
    # of the tolerance, over the run
    assert contacts(summary)[:8] == pytest.approx(expected, abs=1e-9)
    assert summary["energy_audit_max"] < 1e-9


@pytest.mark.slow
def test_drives_in_tandem_cross_their_play_one_after_the_other() -> None:
    """In the catalogue's scene both drives pull and brake, and energy is kept.

    They cross their play at different times.
    """
    run = crane_sim.simulate("tandem_play")
    assert run.summary["energy_audit_max"] < 1e-9
    lead = (run.q[:, -2:] - run.q[:, 1:2]) * 1e3  # mm
    for t, sign in (
        (8.0, 1.0),
        (16.0, -1.0),
    ):  # pulling, braking: both at the flank, 1 and 1.5 mm away
        k = int(np.searchsorted(run.t, t))
        assert (sign * lead[k] > (1.0, 1.5)).all()
    turned = [e for e in run.summary["events"] if e["t"] > 9.0 and "pushes backwards" in e["what"]]
    first = {
        name: min(e["t"] for e in turned if name in e["what"]) for name in ("drive 1", "drive 2")
    }
    assert 9.0 < first["drive 1"] < first["drive 2"] < 12.0


REJECTED = [
    ({"bridge": [{"play": 0.0}]}, "backlash.bridge[0].play = 0.0: must be greater than 0"),
    (
        {"bridge": [{"offset": 0.011}]},
        "backlash.bridge[0].offset = 0.011: must be within half of the play, 0.01",
    ),
    ({"slew": [{}]}, "backlash: unknown joint 'slew' (known: trolley, bridge)"),
]


@pytest.mark.parametrize(("backlash", "line"), REJECTED)
def test_play_that_cannot_be_is_refused(backlash: Any, line: str) -> None:
    """Each contradiction is one line that begins with the key.

    No play is the group left out, and not a play of 0.
    """
    whole = {
        name: [FREE["backlash"]["bridge"][0] | drive for drive in joint]
        for name, joint in backlash.items()
    }
    with pytest.raises(crane_sim.SceneError) as error:
        crane_sim.load_scene(FREE | {"backlash": whole})
    assert line in str(error.value) and "\n" not in str(error.value)


def test_a_fixed_step_is_judged_by_the_shafts() -> None:
    """A step that 10 kg on a shaft of 1e9 N/m cannot bear is refused, with the largest one."""
    drive = {"inertia": 10.0, "play": 1e-3, "stiffness": 1e9}
    changes = {"backlash": {"bridge": [drive]}, "integrator": {"method": "rk4", "step": 0.005}}
    with pytest.raises(
        crane_sim.SceneError,
        match=r"integrator.step = 0.005: too large for the stiffest motion, 1.41",
    ):
        crane_sim.load_scene("tandem_play", changes)
