"""The model of knuckle booms and driven points with links, bodies or events: choice and runs."""

from typing import Any

import numpy as np
import pytest

import crane_sim
from crane_sim.files.errors import SceneError
from crane_sim.models.single_rope.crane import Crane
from crane_sim.models.supports.driven_point import DrivenPoint
from crane_sim.models.supports.knuckle_boom import Knuckle
from crane_sim.models.suspended.crane import SuspendedCrane
from crane_sim.recording.layout import layout_of_scene
from crane_sim.scenes.scene import load_scene

LINKS = [{"mass": 1.0, "length": 0.5}]
BODY = {"mass": 3.0, "inertia": [1.0, 1.2, 0.9], "attachment": [0.0, 0.1, 0.2]}
LOADED = {"mass": 4.0, "inertia": [2.0, 2.2, 1.9], "attachment": [0.0, 0.1, 0.3]}
DRY = {"coulomb": 1.0, "static": 2.0}
TORSION = {"stiffness": 3.0, "damping": 0.1}
DRIVE = {"inertia": 3.0, "play": 2e-3, "stiffness": 5e3, "damping": 10.0}
FREE: dict[str, Any] = {"control": None, "reference": None, "duration": 0.3}
KNUCKLE, PENDULUM = ("knuckle_setpoint", FREE), ("pendulum_lift", {"duration": 0.3})
SEA = {"heave": {"amplitude": 0.5, "frequency": 0.7}, "roll": {"amplitude": 0.1, "frequency": 0.9}}
WIND = {
    "wind": {"speed": 9.0, "height": 10.0, "origin_height": 10.0},
    "payload.windage": {"area": 1, "drag_coefficient": 1},
}
EVENTS = [{"at": 0.1, "set": {"payload": LOADED}, "velocity": [0.1, 0.0, 0.0]}]
EXTENSIONS: dict[str, tuple[Any, dict[str, Any]]] = {
    "knuckle, links": (KNUCKLE, {"links": LINKS}),
    "knuckle, body": (KNUCKLE, {"payload": BODY}),
    "knuckle, events": (KNUCKLE, {"events": [{"at": 0.1, "set": {"payload": {"mass": 2.0}}}]}),
    "knuckle, winch": (KNUCKLE, {"rope.friction": DRY}),
    "knuckle, play": (KNUCKLE, {"backlash": {"boom": [DRIVE]}}),
    "pendulum, links": (PENDULUM, {"links": LINKS}),
    "pendulum, body": (PENDULUM, {"payload": BODY}),
    "pendulum, torsion": (PENDULUM, {"payload": BODY, "rope.torsion": TORSION}),
    "pendulum, events": (PENDULUM, {"events": [{"at": 0.1, "set": {"payload": {"mass": 2.0}}}]}),
}


def scene_of(base: tuple[str, dict[str, Any]], *changes: dict[str, Any]) -> crane_sim.Scene:
    """Return a scene of the catalogue with changes."""
    name, merged = base[0], dict(base[1])
    for change in changes:
        merged |= change
    return load_scene(name, merged)


@pytest.mark.parametrize("case", EXTENSIONS)
def test_extensions_choose_the_suspended_model(case: str) -> None:
    """Any of these keys chooses a suspended crane on the same support; none, that of one rope."""
    base, changes = EXTENSIONS[case]
    scene = scene_of(base, changes)
    assert type(scene_of(base).model) is Crane and type(scene.model) is SuspendedCrane
    assert isinstance(scene.model.support.structure, Knuckle if base is KNUCKLE else DrivenPoint)
    assert (
        len(scene.joint_names)
        == len(scene.joint_units)
        == len(scene.initial_q)
        == len(scene.initial_v)
    )
    assert len(layout_of_scene(scene, "1").joints) == len(scene.initial_q)  # with its URDF


EVERYTHING = {
    "springs": {
        "boom": {"stiffness": 200.0, "rest": 0.3},
        "jib": {"stiffness": 90.0, "rest": -0.4, "relative": True},
    },
    "actuators": {"slew": {"motor": {"ratio": 50.0, "inertia": 1e-3}}},
    "friction": {"jib": DRY, "slew": DRY},
    "lugre": {"boom": DRY | {"stribeck": 0.05, "stiffness": 1e3, "damping": 10.0}},
    "inputs": {
        "slew": {"kind": "sine", "amplitude": 30.0, "frequency": 8.0},
        "rope": {"kind": "constant", "value": 0.1},
    },
    "rope": {"drive": "rate", "torsion": TORSION},
    "boom.windage": {"drag_coefficient": 1.7, "area": 0.8},
}
RUNS: dict[str, tuple[Any, dict[str, Any]]] = {
    "knuckle boom with everything": (KNUCKLE, EVERYTHING),
    "knuckle boom with backlash": (
        KNUCKLE,
        {"backlash": {"boom": [DRIVE]}, "rope": {"drive": "rate"}},
    ),
    "knuckle boom with a reeving": (
        KNUCKLE,
        {
            "rope": {
                "drive": "rate",
                "slack": "stop",
                "reeving": {"falls": 2},
                "limits": [1.0, 3.0],
            },
            "inputs": {
                "boom": {"kind": "constant", "value": 300.0},
                "jib": {"kind": "constant", "value": 150.0},
            },
            "events": [
                EVENTS[0] | {"velocity": "hook"}
            ],  # at rest it would push the rope: the boom comes down
        },
    ),
    "point by acceleration": (PENDULUM, {"rope.torsion": TORSION}),
    "point by a servo": (
        PENDULUM,
        {
            "suspension": {"drive": "servo", "kp": 9.0, "kd": 4.0, "height": "driven"},
            "inputs.tip_x": {"kind": "constant", "value": 1.0},
        },
    ),
}


@pytest.mark.long
@pytest.mark.parametrize("case", RUNS)
def test_runs_keep_their_balance_of_energy(case: str) -> None:
    """At sea and in wind, with links, a body and an exchange, energy changes by supplied work."""
    base, changes = RUNS[case]
    common = {"links": LINKS, "payload": BODY, "base_motion": SEA, "events": EVENTS, **WIND}
    run = crane_sim.simulate(scene_of(base, common, changes))
    assert run.summary["energy_audit_max"] < 1e-9
    assert run.summary["sim_time"] == pytest.approx(0.3)
    assert any("taken up" in event["what"] for event in run.summary["events"])


def test_friction_and_backlash_are_those_of_the_support() -> None:
    """With further links the support has friction, drives with play and motors."""
    motors = {"actuators": {"boom": {"motor": {"ratio": 50.0, "inertia": 1e-3}}}}
    scene = scene_of(
        KNUCKLE, {"links": LINKS, "friction": {"boom": DRY}, "backlash": {"jib": [DRIVE]}}, motors
    )
    support = scene.model.support
    assert support.motors == pytest.approx((0.0, 2.5, 0.0))
    assert [part is not None for part in support.frictions] == [False, True, False]
    assert [len(own) for own in support.drives] == [0, 0, 1]


@pytest.mark.parametrize("law", ["energy", "lqr"])
def test_laws_that_know_one_rope_drive_links_and_bodies(law: str) -> None:
    """The law of the nominal one-rope crane gives the real one the same efforts at each joint."""
    nominal = {"links": [], "payload": {"mass": 4.0, "inertia": None, "attachment": None}}
    control = {"law": law, "period": 0.01, "nominal": nominal}
    scene = load_scene(
        "knuckle_setpoint", {"control": control, "links": LINKS, "payload": BODY, "duration": 0.05}
    )
    simple = load_scene(
        "knuckle_setpoint", {"control": control | {"nominal": {}}, "payload": {"mass": 4.0}}
    )
    assert scene.law is not None and simple.law is not None
    q, v = scene.initial_q, scene.initial_v
    np.testing.assert_array_equal(scene.law(0.0, q, v), simple.law(0.0, q[:6], v[:6]))
    assert crane_sim.simulate(scene).summary["sim_time"] == pytest.approx(0.05)


WITH_LINKS: dict[str, Any] = {"links": LINKS}
MISTAKES: dict[str, tuple[Any, dict[str, Any], str]] = {
    "spring of the rope": (
        KNUCKLE,
        WITH_LINKS | {"springs.rope": {"stiffness": 9.0, "rest": 2.0}},
        "springs.rope: belongs to one rope and a point mass, here is links",
    ),
    "friction of the rope": (
        KNUCKLE,
        {"payload": BODY, "friction": {"rope": DRY}},
        "friction.rope: belongs to one rope and a point mass, here is payload.inertia; .* "
        "rope.friction",
    ),
    "no such joint": (
        KNUCKLE,
        {"friction": {"bom": DRY}},
        "friction: unknown joint 'bom', did you mean 'boom'?",
    ),
    "no such joint below links": (
        KNUCKLE,
        WITH_LINKS | {"lugre": {"trolley": DRY | {"stiffness": 1, "damping": 1}}},
        "lugre: unknown joint 'trolley'",
    ),
    "attachment alone": (
        KNUCKLE,
        {"payload.attachment": [0, 0, 1]},
        "payload.attachment: belongs to a body",
    ),
    "torque without a drum": (
        KNUCKLE,
        {"rope.drive": "torque"},
        "rope.drive = 'torque': is that of a drum",
    ),
    "group of other cranes": (
        KNUCKLE,
        {"flexibility": {"lateral": {"stiffness": 1.0}}},
        "flexibility: belongs to crane: tower, mobile; here is crane: knuckle",
    ),
    "group of another crane": (
        ("bridge_hook_and_sling", {}),
        {"contact": {}},
        "contact: belongs to crane: gantry",
    ),
    "key of a group of other cranes": (
        ("offshore_obstacle", {}),
        {"rope.drive": "force"},
        "rope.drive: belongs to crane: knuckle, tower, mobile, bridge; here is crane: pendulum",
    ),
    "key that others have inside a group": (
        ("overhead_energy", {}),
        {"reeving": {"falls": 4}},
        "; possible: 'rope.reeving' of crane: knuckle, tower, mobile, bridge",
    ),
    "directions without links": (
        KNUCKLE,
        {"initial.rigging": {"directions": [[0, 0, -1]]}},
        "initial.rigging.directions: has 1 vectors, the cable has 0 further links",
    ),
    "energy law without a nominal crane": (
        ("knuckle_setpoint", {}),
        WITH_LINKS,
        "control.nominal: law 'energy' supports only one rope and a point mass; the nominal scene "
        "has links",
    ),
    "tracking law without a nominal crane": (
        ("offshore_obstacle", {}),
        {"payload.inertia": [1, 1, 1]},
        "control.nominal: .* supports only one rope and a point mass; the nominal scene has "
        "payload.inertia",
    ),
    "torsion without a body": (
        PENDULUM,
        {"rope.torsion": TORSION},
        "rope.torsion: belongs to a payload that is a body",
    ),
    "another kind of payload": (
        PENDULUM,
        {"events": EVENTS},
        "inertia: is given; the payloads of a run are all point",
    ),
}


@pytest.mark.parametrize("case", MISTAKES)
def test_contradictions_are_one_line(case: str) -> None:
    """Keys that the chosen model lacks, and laws of another crane, are refused by name."""
    base, changes, message = MISTAKES[case]
    with pytest.raises(SceneError, match=message) as error:
        scene_of(base, changes)
    assert "\n" not in str(error.value)


def test_an_input_that_drives_nothing_is_refused() -> None:
    """A locked rope takes no input; one is refused in a line, not left out."""
    groups = {"control": None, "reference": None, "rope": {"drive": "locked"}}
    with pytest.raises(SceneError, match="inputs.rope: drives nothing, rope.drive = 'locked'"):
        load_scene(
            "knuckle_setpoint", groups | {"inputs": {"rope": {"kind": "constant", "value": 5.0}}}
        )
