"""Open-loop inputs are functions of time; groups without an effect leave a run's bits alone."""

from collections.abc import Mapping
from math import cos, inf
from typing import Any

import numpy as np
import pytest

from crane_sim.scenes.scene import Scene, load_scene
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate

LOWERED = {  # its boom falls, nothing holds it
    "control": None,
    "reference": None,
    "rope.slack": "allow",
    "inputs": {"slew": {"kind": "sine", "amplitude": 1e5, "frequency": 2.0}},
}
BARE = {"sensors": None, "actuators": None, "faults": None}
CRANES: tuple[tuple[str, Mapping[str, Any]], ...] = (
    ("overhead_drive", {}),
    ("overhead_spatial", {}),
    ("knuckle_winch", {}),
    ("pendulum_lift", {}),
    ("pendulum_lifeboat", {}),
    ("bridge_hook_and_sling", {}),
    ("tandem_play", {}),
    ("port_sts_container", {}),
    ("tower_sway", {"inputs.trolley": None}),
    ("mobile_lift", LOWERED),
    ("knuckle_ship_falls", {}),
    ("spreader_pick_up", {}),
    ("overhead_swing", {}),  # no inputs at all
    ("overhead_energy", {}),  # under a law
    ("knuckle_setpoint", {}),
)
RIGID = (  # whose payload's mass no fault changes
    *(
        "pendulum_lifeboat",
        "bridge_hook_and_sling",
        "tandem_play",
        "port_sts_container",
        "mobile_lift",
    ),
    *("knuckle_ship_falls", "spreader_pick_up"),
)
SENSED = {"sensors": {"all": {"noise": 0.01, "bias": 1.0, "delay": 0.02}}}
LIMITED = {"actuators": {"all": {"limit": 1e12}}}
LATE = {
    "faults": {
        "lighter": {"kind": "payload", "mass": 1.0, "at": 1e6},
        "dark": {"kind": "sensor_loss", "joint": 0},
    }
}
JAMMED = {
    "faults": {
        "jam": {"kind": "stuck", "joint": 0},
        "later": {"kind": "stuck", "joint": 0, "at": 1e6},
    }
}
FAR = {"actuators": {"trolley": {"limit_switches": [-1e3, 1e3], "delay": 0.0, "lag": 0.0}}}
PERIODS = 6


def brief(name: str, changes: Mapping[str, Any]) -> Scene:
    """Return a scene of the catalogue with changes, of some periods."""
    scene = load_scene(name, {**BARE, **changes})
    return load_scene(scene, {"duration": PERIODS * scene.period})


def group_for(scene: Scene, group: Mapping[str, Any]) -> dict[str, Any]:
    """Return a group whose faults are at the scene's first joint."""
    faults = {
        name: fault | {"joint": scene.joint_names[0]}
        for name, fault in group.get("faults", {}).items()
    }
    for fault in faults.values():
        if fault["kind"] == "payload":
            del fault["joint"]
    return {**group, "faults": faults}


@pytest.mark.parametrize(("name", "changes"), CRANES, ids=[name for name, _ in CRANES])
def test_groups_without_effect_leave_the_bits_alone(name: str, changes: Mapping[str, Any]) -> None:
    """Sensors, limits and faults without effect give the state hash of a scene without them.

    A law would take what sensors measure: those of its scene are true.
    """
    scene = brief(name, changes)
    sensed = {} if scene.sampled else SENSED
    groups = {**sensed, **LIMITED, **group_for(scene, LATE)}
    if name in RIGID:
        del groups["faults"]["lighter"]
    beside = load_scene(scene, groups)
    assert beside.sampled == scene.sampled and beside.held == scene.held
    assert simulate(beside).summary["state_sha256"] == simulate(scene).summary["state_sha256"]


TROLLEY: dict[str, Any] = {
    "crane": "overhead",
    "duration": 0.5,
    "trolley": {"mass": 10.0},
    "cable": {"lengths": 2.0, "node_masses": 5.0},
    "initial": {"angles": 0.3, "v": 0.5},
}
SINE = {"inputs": {"trolley": {"kind": "sine", "amplitude": 30.0, "frequency": 40.0}}}
PULSE = {
    "inputs": {
        "trolley": {"kind": "table", "times": [0.1, 0.103, 0.3], "values": [0.0, 50.0, -20.0]}
    }
}


@pytest.mark.parametrize("inputs", [SINE, PULSE, {}], ids=["sine", "table", "none"])
@pytest.mark.parametrize(
    "group", [SENSED, LIMITED, LATE, JAMMED], ids=["sensors", "limit", "faults", "stuck"]
)
def test_each_group_alone(inputs: Mapping[str, Any], group: Mapping[str, Any]) -> None:
    """Each kind of group leaves the bits alone at any instant, with inputs of any kind.

    Inputs are smooth, with breakpoints, or none.
    """
    scene, times = load_scene({**TROLLEY, **inputs}), np.linspace(0.0, 0.5, 37)
    run, beside = (
        simulate(scene, sample_times=times),
        simulate(load_scene(scene, group_for(scene, group)), sample_times=times),
    )
    assert beside.summary["state_sha256"] == run.summary["state_sha256"]
    assert np.array_equal(beside.q, run.q) and np.array_equal(beside.u, run.u)


def test_switches_that_never_trip() -> None:
    """Limit switches out of reach leave the bits alone where there are inputs."""
    scene = load_scene(TROLLEY | SINE)
    assert (
        simulate(scene, overrides=FAR).summary["state_sha256"]
        == simulate(scene).summary["state_sha256"]
    )


def test_a_rotor_of_no_weight() -> None:
    """A motor whose rotor weighs next to nothing changes next to nothing."""
    scene = load_scene("bridge_hook_and_sling", {"duration": 0.1})
    joint = scene.actuated[0]
    turning = simulate(
        scene, overrides={"actuators": {joint: {"motor": {"ratio": 1.0, "inertia": 1e-12}}}}
    )
    assert turning.q[-1] == pytest.approx(simulate(scene).q[-1], abs=1e-11)  # of steps of 1e-9


WINCH: dict[str, Any] = {
    "crane": "bridge",
    "duration": 0.1,
    "trolley": {"mass": 6000.0},
    "bridge": {"mass": 10000.0},
    "rope": {"drive": "rate"},
    "payload": {"mass": 24000.0},
    "initial": {"q": [0.0, 0.0, 22.0, 0.0, 0.0]},
    "inputs": {"rope": {"kind": "sine", "amplitude": 1.0, "frequency": 100.0}},
}
FOLLOWS = {"trolley": {"drive": "velocity", "servo": {"gain": inf, "max_acceleration": 10.0}}}


@pytest.mark.parametrize(
    ("actuators", "held"),
    [
        ({"rope": {"limit": 5.0}}, ()),
        ({"trolley": {"lag": 0.1}}, ("trolley",)),
        ({"trolley": {"rate_limit": 10.0}}, ("trolley",)),
        ({"trolley": {"delay": 0.05}}, ()),
        (FOLLOWS, ("trolley",)),
    ],
    ids=["limit", "lag", "rate limit", "delay", "speed drive"],
)
def test_drives_of_other_joints_leave_an_input_continuous(
    actuators: Mapping[str, Any], held: tuple[str, ...]
) -> None:
    """A winch with the acceleration sin 100 t has the rate (1 - cos 100 t) / 100.

    That does not depend on the trolley's drives.
    """
    run = simulate(WINCH | {"actuators": actuators})
    # held over periods, it is 0.01 off
    assert run.v[-1, 2] == pytest.approx((1.0 - cos(10.0)) / 100.0, abs=1e-9)
    assert run.scene.held == held and not run.scene.sampled
    assert run.summary.get("held_inputs", []) == list(held)


def test_a_fault_begins_in_the_motion_without_it() -> None:
    """Up to a loss of effort all rows are those without it; then the drive gives half."""
    scene, at = load_scene(TROLLEY | SINE), 0.2
    weak = {"kind": "effort_loss", "joint": "trolley", "factor": 0.5, "at": at}
    run, beside = simulate(scene), simulate(scene, overrides={"faults": {"weak": weak}})
    before, after = run.t <= at, run.t > at
    assert np.array_equal(run.q[before], beside.q[before]) and not np.any(
        run.q[after, 0] == beside.q[after, 0]
    )
    assert beside.u[run.t >= at] == pytest.approx(0.5 * run.u[run.t >= at], rel=1e-15)
    assert beside.summary["energy_audit_max"] < 1e-9


GROUPS: dict[str, Any] = {
    "sensors": {"all": {"noise": 0.01}},
    "actuators": {"trolley": {"limit": 25.0, "delay": 0.05}},
    "faults": {
        "stuck": {"kind": "stuck", "joint": "trolley", "at": 0.2, "until": 0.26},
        "lighter": {"kind": "payload", "mass": 3.0, "at": 0.33},
    },
}


@pytest.mark.parametrize("inputs", [SINE, PULSE], ids=["sine", "table"])
def test_a_plant_takes_the_same_steps(inputs: Mapping[str, Any]) -> None:
    """A plant advanced by periods ends in the run's bits, with delay, limit, brake, new payload."""
    scene = load_scene({**TROLLEY, **inputs, **GROUPS})
    run, plant = simulate(scene), Plant(scene)
    for _ in range(scene.steps):
        plant.advance()
    assert plant.summary()["state_sha256"] == run.summary["state_sha256"]
    assert run.summary["energy_audit_max"] < 1e-9 and np.all(np.isnan(run.commands))


def test_released_brakes_give_continuous_inputs_back() -> None:
    """A plant whose brakes have acted goes on as a new one from its state, by smooth inputs."""
    late = {
        "inputs": {
            "trolley": {"kind": "sine", "amplitude": 30.0, "frequency": 40.0, "phase": 40.0 * 0.1}
        }
    }
    plant, fresh = Plant(load_scene(TROLLEY | SINE)), Plant(load_scene(TROLLEY | late))
    for k in range(40):
        plant.braking = k < 10
        if k == 10:
            fresh.reset(plant.q, plant.v)
        plant.advance()
        if k >= 10:
            fresh.advance()
    # of the steps; held over periods it is 1e-3 off
    assert plant.q == pytest.approx(fresh.q, abs=1e-9)


def test_delays_and_limits_of_an_input_are_exact() -> None:
    """A late and limited input is the earlier one within limits, also inside periods."""
    times = np.linspace(0.0, 0.2, 41)
    late = {"actuators": {"trolley": {"delay": 0.05, "limit": 20.0, "deadband": 3.0}}}
    run = simulate(TROLLEY | SINE | late | {"duration": 0.2}, sample_times=times)
    wanted = np.where(times < 0.05, 0.0, 30.0 * np.sin(40.0 * (times - 0.05)))
    wanted = np.clip(np.where(abs(wanted) < 3.0, 0.0, wanted), -20.0, 20.0)
    assert run.u[:, 0] == pytest.approx(wanted, abs=1e-12)
