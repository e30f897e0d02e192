"""Groups that contradict each other: `crane check` names both in one line, with exit code 2."""

from pathlib import Path
from typing import Any

import pytest
import yaml

from crane_sim import cli
from crane_sim.files.document import read, set_value

BODY = {"mass": 4e3, "inertia": [3e3, 9e3, 9e3]}
POINT = {"mass": 4e3}
DRY = {"coulomb": 5.0, "static": 6.0}
BRISTLES = DRY | {"stribeck": 0.01, "stiffness": 1e6, "damping": 1e3}
PLAY = [{"inertia": 2e3, "play": 2e-3, "stiffness": 1e7, "damping": 1.4e4}]
MOTOR = {"motor": {"ratio": 50.0, "inertia": 1e-3}}
SERVO = {"servo": {"gain": 1e4}}
FALLS = {"top": [[0, 0, 0]], "bottom": [[0, 0, 0]], "axial_stiffness": 1e7}
HEAVE = {"heave": {"amplitude": 0.5, "frequency": 0.7}}
REEVING = {"falls": 4, "drum": {"radius": 0.3}}
DECK = {"points": [[1.0, 2.0, -2.0]], "height": -60.0}
TAKEN = {"mass": 58.48e3, "inertia": [655e3, 52e3, 655e3], "attachment": [0.0, 0.0, 2.2]}
LOCKED: dict[str, Any] = {
    "slew": {"drive": "locked"},
    "control": None,
    "reference": None,
    "actuators": {},
}
SINE = {"kind": "sine", "amplitude": 1.0, "frequency": 1.0}
PENDULUM = "pendulum_sea"

CONTRADICTIONS: list[tuple[str, dict[str, Any], str, str]] = [
    # two descriptions of the same thing
    (
        "bridge_hook_and_sling",
        {"friction": {"bridge": DRY}, "lugre": {"bridge": BRISTLES}},
        "lugre.bridge",
        "friction",
    ),
    (
        "knuckle_setpoint",
        {"friction": {"slew": DRY}, "lugre": {"slew": BRISTLES}},
        "lugre.slew",
        "friction.slew",
    ),
    (
        "tandem_play",
        {"actuators": {"bridge": MOTOR}},
        "actuators.bridge.motor.inertia",
        "backlash.bridge",
    ),
    ("spreader_skew", {"rope": {"drive": "rate"}}, "rope", "falls"),
    ("spreader_skew", {"links": [{"mass": 1.0, "length": 1.0}]}, "links", "falls"),
    ("tower_set_down", {"rope": {"drive": "rate"}}, "rope", "falls"),
    (
        "spreader_skew",
        {"initial.orientation": [1, 0, 0, 0]},
        "initial.orientation",
        "initial.position",
    ),
    (
        "overhead_swing",
        {"friction": {"trolley": DRY}, "lugre": {"trolley": BRISTLES}},
        "lugre.trolley",
        "friction",
    ),
    # groups that need another one
    ("bridge_hook_and_sling", {"falls": FALLS}, "falls", "crane: gantry"),
    ("tower_gust", {"hoist": {}}, "hoist", "falls"),
    ("spreader_skew", {"payload": POINT}, "payload.inertia", "falls"),
    (
        "bridge_hook_and_sling",
        {"payload": POINT | {"attachment": [0.1, 0, 0]}},
        "payload.attachment",
        "inertia",
    ),
    (
        "tower_gust",
        {"payload": POINT, "rope.torsion": {"stiffness": 60.0}},
        "rope.torsion",
        "payload.inertia",
    ),
    (
        "tower_gust",
        {
            "payload": POINT
            | {"windage": {"area": 1.0, "drag_coefficient": 1.0, "centre": [1, 0, 0]}}
        },
        "payload.windage.centre",
        "payload.inertia",
    ),
    (
        "spreader_skew",
        {"events": [{"at": 1.0, "set": {"payload": TAKEN, "contact": {"points": [[0, 0, 0]]}}}]},
        "set.contact",
        "contact, the surface",
    ),
    ("spreader_skew", {"contact": DECK | {"kind": "compliant"}}, "contact.stiffness", "compliant"),
    (
        "spreader_skew",
        {"contact": DECK | {"stiffness": 1e5}},
        "contact.stiffness",
        "contact.kind: compliant",
    ),
    (
        "tower_flexible_jib",
        {"flexibility.lateral": None, "flexibility.vertical": None},
        "flexibility",
        "lateral",
    ),
    (
        "tower_sway",
        {"flexibility.lateral": {"stiffness": 1e8}},
        "flexibility.mast",
        "flexibility.lateral",
    ),
    ("tower_sway", {"actuators.slew": MOTOR}, "flexibility.mast", "actuators.slew.motor.inertia"),
    # drives that cannot have the group
    ("tower_flexible_jib", LOCKED, "flexibility", "slew.drive"),
    ("tower_gust", LOCKED | {"friction": {"slew": DRY}}, "friction.slew", "slew.drive"),
    ("tower_gust", LOCKED | {"backlash": {"slew": PLAY}}, "backlash.slew", "slew.drive"),
    ("tower_gust", LOCKED | {"inputs.slew": SINE}, "inputs.slew", "slew.drive"),
    (
        "tower_set_down",
        LOCKED | {"friction.slew": None, "inputs.slew": SINE},
        "inputs.slew",
        "slew.drive",
    ),
    ("tower_gust", {"rope.friction": DRY}, "rope.friction", "'rate'"),
    ("reeved_twelve_falls", {"rope.drive": "locked"}, "rope.", "'locked'"),
    ("reeved_twelve_falls", {"base_motion": HEAVE}, "rope.reeving.mass_per_length", "base_motion"),
    ("spreader_skew", {"hoist": {"drive": "force"}}, "hoist.mass", "force"),
    (
        "spreader_skew",
        {"hoist": {"drive": "rate", "reeving": REEVING}},
        "hoist.reeving.falls",
        "falls.parts",
    ),
    (PENDULUM, {"rope.reeving": REEVING}, "rope.reeving", "crane: knuckle, tower, mobile, bridge"),
    (
        "overhead_swing",
        {"hoist": {"drive": "force", "inertia": 5.0, "reeving": REEVING}},
        "hoist.reeving",
        "tower",
    ),
    ("overhead_swing", {"cable.damping": 1.0}, "cable.damping", "cable.model"),
    ("overhead_swing", {"bridge": {"mass": 5.0}}, "bridge", "3 dimensions"),
    (
        "overhead_chain",
        {"cable.model": "straight", "base_motion": HEAVE},
        "cable.model",
        "base_motion",
    ),
    ("overhead_swing", {"friction": {"hoist": DRY}}, "friction.hoist", "hoist"),
    ("bridge_hook_and_sling", {"actuators.trolley": SERVO}, "actuators.trolley.servo", "velocity"),
    # groups of other cranes, and groups that laws do not know
    (
        "bridge_hook_and_sling",
        {"flexibility": {"lateral": {"stiffness": 1e8}}},
        "flexibility",
        "tower, mobile",
    ),
    (
        "knuckle_hook_and_sling",
        {"springs": {"rope": {"stiffness": 1.0, "rest": 1.0}}},
        "springs.rope",
        "payload.inertia",
    ),
    ("tower_set_down", {"control": {"law": "angular"}, "inputs": None}, "angular", "tower"),
    # values that no crane has
    ("spreader_skew", {"payload.inertia": [1.0, 1.0, 10.0]}, "payload.inertia", "no rigid body"),
    ("tandem_play", {"backlash.bridge.0.play": 0.0}, "backlash.bridge", "play"),
    (
        "bridge_hook_and_sling",
        {"friction": {"bridge": {"coulomb": 9.0, "static": 6.0}}},
        "friction.bridge",
        "static",
    ),
]


@pytest.mark.parametrize(
    ("scene", "changes", "culprit", "other"),
    CONTRADICTIONS,
    ids=[f"{case[0]}: {case[2]}" for case in CONTRADICTIONS],
)
def test_groups_that_contradict_each_other_are_one_line(
    scene: str,
    changes: dict[str, Any],
    culprit: str,
    other: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """`crane check` of a file with both has exit code 2 and one line on stderr naming the two."""
    document = read(scene)
    for key, value in changes.items():
        set_value(document, key, value)
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(document))
    monkeypatch.setattr("sys.argv", ["crane", "check", str(path)])
    # pytest has its own handlers
    monkeypatch.setattr("crane_sim.process_signals.exit_on_signal", lambda end: None)
    assert cli.main() == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert culprit in line and other in line.removeprefix(culprit), line
