"""Brakes hold, slip at their capacity, give no energy, and bring every crane to rest."""

from typing import Any

import numpy as np
import pytest
from hardware_scenes import ROD

from crane_sim.files.errors import SceneError
from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.hardware import joint_mechanics
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate


def brake(plant: Plant, periods: int) -> None:
    """Apply the brakes for so many periods."""
    plant.braking = True
    for _ in range(periods):
        plant.advance((0.0,) * len(plant.scene.actuated))


def stored_energy(plant: Plant) -> float:
    """Return the energy [J] in the first brake's spring, with what a slip will take.

    The slip is that beyond its capacity.
    """
    hardware: Any = plant._hardware
    drive = hardware.state.drives[0]
    stretch, max_stretch = abs(plant.q[0] - drive.anchor), drive.capacity / drive.stiffness
    inner = min(stretch, max_stretch)
    return drive.stiffness * inner * (0.5 * inner + stretch - inner)


def energy(scene: Scene, plant: Plant) -> float:
    """Return kinetic and potential energy [J] of the trolley and its payload."""
    (_, angle), (v, rate) = plant.q, plant.v
    vx, vz = v + 2.0 * rate * np.cos(angle), 2.0 * rate * np.sin(angle)
    return 0.5 * 10.0 * v * v + 0.5 * 5.0 * (vx * vx + vz * vz) - 5.0 * 9.81 * 2.0 * np.cos(angle)


def test_brakes_hold_the_posture_that_a_run_began_in() -> None:
    """After a reset the brakes of a boom hold what they hold in a scene with that posture.

    The scene begins in it.
    """
    q, hung = (0.0, 1.0, 0.4, 3.0, 0.0, 0.0), load_scene("knuckle_setpoint")
    there, fitted = load_scene(hung, {"initial.q": list(q)}), list[Any]()
    for plant, start in ((Plant(hung), q), (Plant(there), None)):
        plant.reset(start)
        plant.braking = True
        hardware: Any = plant._hardware
        fitted.append(hardware.state.drives)
    for name in ("stiffness", "damping", "capacity"):
        np.testing.assert_array_equal(fitted[0][name], fitted[1][name])


def test_a_brake_slips_at_its_capacity() -> None:
    """A slipping brake acts with its capacity: a trolley stops within m v² / (2 F)."""
    light = {
        "payload": {"mass": 1e-6},
        "initial": {"v": 1.0},
        "brake": {"capacity": [5.0], "frequency": 200.0},
    }
    plant = Plant(load_scene(ROD | light))
    brake(plant, 190)
    # a ten-millionth of the mass swings
    assert plant.v[0] == pytest.approx(1.0 - 1.9 * 5.0 / 10.0, abs=1e-6)
    brake(plant, 30)
    assert plant.at_rest
    # the spring of 200 rad/s gives back F / k = 1.25e-5 m, and damps in some 5 ms
    assert plant.q[0] == pytest.approx(0.5 * 10.0 / 5.0, abs=3e-5)


def across(mass: float, amplitude: float) -> float:
    """Return the largest horizontal pull [N] of a payload [kg] swinging to an angle on its rope.

    It acts on the top of the rope.

    With l a'² = 2 g (cos a - cos A) the rope's tension is m g (3 cos a - 2 cos A), of which sin a
    is horizontal. Its maximum is at the end of the swing up to 30 degrees, then where 6 cos² a - 2
    cos A cos a = 3.
    """
    end = np.cos(amplitude)
    c = end if amplitude <= np.pi / 6.0 else (end + np.sqrt(end * end + 18.0)) / 6.0
    return mass * 9.81 * np.sqrt(1.0 - c * c) * (3.0 * c - 2.0 * end)


def slips(amplitude: float, trolley: float, capacity: float | None) -> bool:
    """Return whether a trolley's [kg] brake slips under 5 kg swinging twice up to this angle.

    The payload begins hanging.
    """
    rate = np.sqrt(2.0 * 9.81 / 2.0 * (1.0 - np.cos(amplitude)))
    scene = {
        "trolley": {"mass": trolley},
        "initial": {"angles": 0.0, "rates": float(rate)},
        "brake": {},
        "duration": 6.0,
    }
    if capacity is not None:
        scene["brake"] = {"capacity": [capacity]}
    plant = Plant(load_scene(ROD | scene | {"integrator": {"method": "rk4", "step": 0.002}}))
    brake(plant, 1)
    hardware: Any = plant._hardware
    began = hardware.state.drives[0].anchor
    brake(plant, 599)
    return hardware.state.drives[0].anchor != began


@pytest.mark.parametrize(("degrees", "trolley"), [(20.0, 1.0), (45.0, 20.0), (80.0, 1.0)])
def test_what_holds_a_trolley_below_a_swing(degrees: float, trolley: float) -> None:
    """A brake for the payload's largest pull across holds any trolley, and slips with 3 % less."""
    angle = np.radians(degrees)
    pull = across(5.0, float(angle))
    a = np.linspace(0.0, angle, 100001)
    brute = 5.0 * 9.81 * np.max(np.sin(a) * (3.0 * np.cos(a) - 2.0 * np.cos(angle)))
    assert pull == pytest.approx(brute, rel=1e-9)  # of the grid: (0.8 rad / 1e5)²
    # the trolley's own spring and damper add some percent
    assert not slips(float(angle), trolley, 1.03 * pull)
    assert slips(float(angle), trolley, 0.97 * pull)


def test_what_default_brakes_hold() -> None:
    """2 m/s² for trolley and payload hold 12 degrees below any trolley, 45 below a heavy one.

    The heavy trolley has twice the payload's mass.
    """
    assert across(1.0, np.radians(45.0)) == pytest.approx(0.6 * 9.81, rel=1e-3)
    assert 2.0 * 1.0 > across(1.0, np.radians(12.0)) > 2.0 * 0.99
    assert 2.0 * 3.0 > across(1.0, np.radians(45.0)) > 2.0 * 2.9
    assert not slips(float(np.radians(11.5)), 0.5, None) and slips(
        float(np.radians(20.0)), 0.5, None
    )
    assert not slips(float(np.radians(45.0)), 10.0, None) and slips(
        float(np.radians(45.0)), 8.0, None
    )


@pytest.mark.parametrize("capacity", [3.0, 20.0, 1e9], ids=["slips", "slips and sticks", "sticks"])
def test_a_brake_gives_no_energy(capacity: float) -> None:
    """In every period the crane's energy rises by at most what the brake's spring loses."""
    scene = load_scene(ROD | {"brake": {"capacity": [capacity], "damping": 0.1}})
    plant = Plant(scene)
    brake(plant, 1)
    for _ in range(400):
        before = energy(scene, plant) + stored_energy(plant)
        plant.advance((0.0,))
        after = energy(scene, plant) + stored_energy(plant)
        assert after <= before + 1e-6  # J of some 15: the method's own error in a period
    assert after < before - 1e-9 or plant.at_rest


def test_releasing_and_restarting() -> None:
    """Released brakes let the crane go on; a restart repeats the run without them.

    The audit holds.
    """
    scene = load_scene(ROD)
    plant = Plant(scene)
    for braking in (False, True, False):
        plant.braking = braking
        for _ in range(50):
            plant.advance((20.0,))
            assert (plant.applied == (20.0,)) != braking
    assert plant.v[0] > 0.5 and not plant.at_rest
    summary = plant.summary()
    assert summary["energy_audit_error"] < 1e-5  # steps of 5 ms with a brake that damps in 7 ms
    assert summary["braked_time"] == 0.5
    plant.reset()
    assert not plant.braking
    for _ in range(scene.steps):
        plant.advance((0.0,))
    expected = simulate(scene, law=lambda t, q, v: (0.0,)).summary
    assert plant.summary()["state_sha256"] == expected["state_sha256"]


def test_a_run_goes_on_from_any_state() -> None:
    """A restart from another state is a run that begins there; impossible states are rejected."""
    plant = Plant(load_scene(ROD))
    plant.reset((1.0, -0.2), (0.1, 0.3))
    other = Plant(load_scene(ROD | {"initial": {"x": 1.0, "v": 0.1, "angles": -0.2, "rates": 0.3}}))
    for _ in range(20):
        plant.advance((3.0,))
        other.advance((3.0,))
    assert (plant.q, plant.v) == (other.q, other.v)
    for q, message in (
        ((1.0,), "positions: has 1 values, the joints are trolley, swing_1"),
        ((1.0, float("nan")), "positions: swing_1 = nan: must be finite"),
    ):
        with pytest.raises(SceneError, match=message):
            plant.reset(q)
    assert plant.k == 20
    limited = Plant(load_scene(ROD | {"trolley": {"mass": 10.0, "limits": [-2.0, 2.0]}}))
    with pytest.raises(SceneError, match="positions: the trolley reached its travel limit there"):
        limited.reset((3.0, 0.0))
    assert limited.q[0] == 0.0


SLOWER = {"overhead_hoist": {"hoist.profile.to": 9.0}}
"""Changes of scenes: up to 0.5 m, this hoist pumps the swing to full turns, which draw the braked
trolley along."""


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    "overhead_lqr overhead_friction_chain overhead_hoist knuckle_winch pendulum_lift "
    "knuckle_continuous offshore_vision knuckle_sea overhead_spring overhead_joints".split(),
)
def test_every_crane_comes_to_rest(name: str) -> None:
    """Every crane in motion rests within ten seconds of braking, and brakes then hold it.

    It does so whatever drives it.
    """
    scene = load_scene(name, SLOWER.get(name))
    plant, law, nu = Plant(scene), scene.law, len(scene.actuated)
    places = [scene.joint_names.index(joint) for joint in scene.actuated]
    for _ in range(round(1.0 / scene.period)):
        plant.advance(law(plant.t, plant.q, plant.v) if scene.sampled and law is not None else None)
    brake(plant, round(10.0 / scene.period))
    rested = plant.q
    assert plant.at_rest
    brake(plant, round(2.0 / scene.period))
    # a payload in full swing draws a trolley along its rail now and then: at most the way of a few
    # slips
    assert all(abs(plant.q[i] - rested[i]) < 5e-3 for i in places) and plant.at_rest
    assert plant.summary()["energy_audit_error"] < 1e-9 and nu > 0


BOOM_SERVO = {"drive": "velocity", "servo": {"gain": 4000.0, "integral_time": 0.2}}
MOTOR = {"motor": {"ratio": 1.0, "torque": 600.0, "no_load_speed": 0.1}}


@pytest.mark.parametrize(
    ("actuator", "command", "loss", "periods"),
    [
        (BOOM_SERVO, 0.0, 0.5, 5),
        (BOOM_SERVO, 0.0, 1.0, 0),
        (MOTOR, 600.0, 1.0, 5),
        ({"lag": 0.02}, 600.0, 0.5, 5),
    ],
    ids=["servo with a loss", "servo at the start", "motor at speed", "lag with a loss"],
)
def test_a_brake_takes_over_what_the_drive_delivered(
    actuator: Any, command: float, loss: float, periods: int
) -> None:
    """A brake begins with the joint's effort, after losses and motor curve, at the start too."""
    faults = {
        "loss": {"kind": "effort_loss", "joint": "boom", "factor": loss, "at": 0.0},
        "jam": {"kind": "stuck", "joint": "boom", "at": periods * 0.01},
    }
    changes = {"control": None, "inputs": None, "actuators": {"boom": actuator}, "faults": faults}
    brake = {"capacity": [1e5] * 4, "frequency": 10.0}
    scene = load_scene("knuckle_setpoint", changes | {"brake": brake}).with_external_commands()
    plant = Plant(scene)
    delivered = joint_mechanics(scene).static_load[1]
    for _ in range(periods):
        plant.advance((0.0, command, 0.0, 0.0))
        delivered = plant._hardware.state.drives[1].effort
    position = plant.q[1]
    plant.advance((0.0, command, 0.0, 0.0))
    drive = plant._hardware.state.drives[1]
    assert abs(delivered) > 50.0 and drive.engaged
    # rounding of positions
    assert drive.stiffness * (drive.anchor - position) == pytest.approx(delivered, rel=1e-9)


def test_dry_friction_is_no_load() -> None:
    """Nothing holds a trolley on a level jib: with dry friction a speed drive begins at 0."""
    # N
    assert joint_mechanics(load_scene("tower_beam_turns")).static_load[1] == pytest.approx(
        0.0, abs=1e-6
    )
