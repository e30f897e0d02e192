"""Scene files: accepted and rejected ones, and error messages."""

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

import crane_sim
from crane_sim.files.catalogue import scene_files
from crane_sim.files.document import read_groups
from crane_sim.files.errors import SceneError
from crane_sim.models.cables.rope import ForceRope, LockedRope, MotionRope
from crane_sim.scenes.scene import load_scene

REJECTED = [
    ({"crane": "gantree"}, "crane = 'gantree': possible: knuckle"),
    (
        {"payload.mas": 1.0},
        "payload: unknown key 'mas', did you mean 'mass'? (known: mass, inertia, windage, "
        "attachment)",
    ),
    ({"payloads": {"mass": 1.0}}, "unknown key 'payloads', did you mean 'payload'?"),
    ({"boom.lenght": 5.0}, "boom: unknown key 'lenght', did you mean 'length'?"),
    ({"payload.mass": -1.0}, "payload.mass = -1.0: must be greater than 0"),
    ({"payload.mass": 0}, "payload.mass = 0: must be greater than 0"),
    ({"payload.mass": math.nan}, "payload.mass = nan: must be a finite number"),
    ({"gravity": math.inf}, "gravity = inf: must be a finite number"),
    ({"payload.mass": "5 lb"}, "payload.mass = '5 lb': must be a number"),
    (
        {"initial.q": [0, "3 m", 0, 2, 0, 0]},
        "initial.q[1] = '3 m': an angle is a number of radians",
    ),
    ({"initial.q": [0, 0, 0, "90 deg", 0, 0]}, "initial.q[3] = '90 deg': must be a number"),
    ({"initial.q": [0, 0, 0, 0.0, 0, 0]}, "initial.q[3] = 0.0: must be greater than 0"),
    ({"initial.q": [0, 0, 0]}, "initial.q: has 3 values, too few"),
    ({"initial.q": [0, 0, 0, 1, 0, 0, 0]}, "initial.q: has 7 values, at most 6 are possible"),
    ({"initial.v": [0, 0, 0]}, "initial.v: has 3 values, too few"),
    ({"reference.q": [0, 0, 0]}, "reference.q: has 3 values, too few"),
    ({"reference": None}, "reference: is missing, the energy law needs a target"),
    ({"boom": None}, "boom: is missing"),
    ({"boom.mass": None}, "boom.mass: is missing"),
    ({"boom": 5}, "boom = 5: must be a group of keys: length, mass, inertia"),
    ({"seed": -1}, "seed = -1: must be greater than or equal to 0"),
    ({"seed": 1.5}, "seed = 1.5: must be a whole number"),
    (
        {"swing_friction": 3},
        "swing_friction = 3: must be a group of keys, with model: quadratic | linear | paper",
    ),
    ({"rope.drive": "push"}, "rope.drive = 'push': must be 'force', 'torque', 'rate' or 'locked'"),
    (
        {"rope.drive": "rate"},
        "rope.drive = 'rate': the energy law commands a rope force; possible: force, locked",
    ),
    ({"rope.time_constant": 1.0}, "rope.time_constant: only a rate drive has one"),
    (
        {"rope.drive": "locked", "initial.v": [0, 0, 0, 1, 0, 0]},
        "initial.v[3] = 1.0: a locked rope starts at rest",
    ),
    (
        {"rope.drive": "locked", "springs": {"rope": {"stiffness": 1, "rest": 1}}},
        "springs.rope: only a force drive",
    ),
    ({"payload.mass": True}, "payload.mass = True: must be a number"),
    (
        {"control.law": "magic"},
        "control.law = 'magic': no such law (known: adaptive, angular, anti_swing, ",
    ),
    ({"control.period": 0.0}, "control.period = 0.0: a period is a number of seconds"),
    (
        {"control.period": "contnuous"},
        "control.period = 'contnuous': a period is a number of seconds",
    ),
    ({"control.kp": [1, 2, 3]}, "control.kp: has 3 values, 4 joints are actuated"),
    ({"control.kp": [1, 2, 3, -4]}, "control.kp[3] = -4: must be greater than or equal to 0"),
    (
        {"control.kpp": [1, 2, 3, 4]},
        "control: unknown key 'kpp' for law 'energy', did you mean 'kp'?",
    ),
    (
        {"control.law": "lqr", "control.kd": 1},
        "control: unknown key 'kd' for law 'lqr' (known: q, r)",
    ),
    (
        {"payload": None, "paylod": {"mass": 1.0}},
        "unknown key 'paylod', did you mean 'payload'? (known: ",
    ),
    (
        {"control": {"lw": "energy"}},
        "control: unknown key 'lw', did you mean 'law'? (known: law, period, nominal)",
    ),
    (
        {"integrator": {"metod": "rk4"}},
        "integrator: unknown key 'metod', did you mean 'method'? (method: auto, dop853",
    ),
    ({"crane": None}, "crane = None: possible: knuckle, tower, mobile, bridge"),
    ({"control.adaptation": True}, "control.adaptation = True: must be a group of keys: rate"),
    ({"control.nominal": 5}, "control.nominal = 5: must be a group of keys"),
    ({"control.period": True}, "control.period = True: a period is a number of seconds"),
    ({"control": 5}, "control = 5: must be a group of keys: law, period, nominal"),
    ({"control.law": None}, "control.law: is missing"),
    ({"control.nominal": {"payload": {"mass": -1}}}, "payload.mass = -1: must be greater than 0"),
    (
        {"inputs": {"slew": {"kind": "constant", "value": 1.0}}},
        "inputs: a scene with a control law takes none",
    ),
    (
        {"control": None, "inputs": {"slew": {"kind": "ramp"}}},
        "kind 'ramp' is unknown; possible: constant",
    ),
    ({"integrator.method": "euler"}, "method 'euler' is unknown; possible: auto, dop853, dopri5"),
    ({"integrator": {"method": "rk4", "stp": 1e-3}}, "unknown key 'stp', did you mean 'step'?"),
    ({"integrator": {"method": "rk4", "step": -1e-3}}, "step"),
    (
        {"swing_friction": {"model": "cubic"}},
        "model 'cubic' is unknown; possible: quadratic, linear, paper",
    ),
    ({"duration": 0}, "duration = 0: must be greater than 0"),
    ({"duration": 1e12}, "duration = 1000000000000.0: must be 1 to 1e+08 periods of 0.01 s"),
    ({"control.period": 1000}, "duration = 40.0: must be 1 to 1e+08 periods of 1000 s"),
    (
        {"control": None, "inputs": {"slew": {"kind": "polynomial", "coefficients": []}}},
        "coefficients",
    ),
    (
        {"control": None, "inputs": {"slew": {"kind": "table", "times": [0, 1], "values": [1]}}},
        "as many values as times",
    ),
    (
        {"control": None, "inputs": {"slew": {"kind": "table", "times": [1, 0], "values": [1, 2]}}},
        "times of a table must",
    ),
]


@pytest.mark.parametrize(("changes", "line"), REJECTED, ids=lambda case: str(case)[:50])
def test_a_bad_scene_is_a_single_line_error(changes: dict[str, Any], line: str) -> None:
    """Every mistake is a one-line error with scene, key, its value and the possible ones."""
    with pytest.raises(crane_sim.SceneError) as caught:
        load_scene("knuckle_setpoint", changes)
    message = str(caught.value)
    assert message.startswith("scene knuckle_setpoint: ")
    assert line in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("crane: [", "cannot be read"),
        ("just words", "holds str, not groups of keys"),
        ("", "holds NoneType, not groups of keys"),
        ("crane: \udcff", "cannot be read"),
    ],
    ids=["invalid yaml", "no groups", "empty", "not utf-8"],
)
def test_an_unreadable_file_is_rejected(tmp_path: Path, text: str, line: str) -> None:
    """A file that is not YAML, or not a scene, is rejected in one line with its path."""
    file = tmp_path / "bad.yaml"
    file.write_bytes(text.encode("utf-8", "surrogateescape"))
    with pytest.raises(crane_sim.SceneError, match=f"scene file {file}: {line}") as caught:
        load_scene(file)
    assert "\n" not in str(caught.value)


def test_a_folder_is_rejected(tmp_path: Path) -> None:
    """A path of a folder is rejected as unreadable."""
    with pytest.raises(crane_sim.SceneError, match="cannot be read"):
        load_scene(tmp_path)


def test_an_unknown_scene_is_rejected_with_the_nearest_name() -> None:
    """A misspelt catalogue name gets the nearest one."""
    with pytest.raises(
        crane_sim.SceneError,
        match="unknown scene 'knuckle_setpont', did you mean 'knuckle_setpoint'",
    ):
        load_scene("knuckle_setpont")


@pytest.mark.parametrize("name", sorted(scene_files()))
def test_every_catalogue_scene_is_unchanged_by_dump_and_load(name: str, tmp_path: Path) -> None:
    """Every catalogue scene is valid, has a description, and survives `dump` and `load_scene`."""
    scene = load_scene(name)
    assert scene.name == name and scene.description
    scene.dump(tmp_path / "copy.yaml")
    assert load_scene(tmp_path / "copy.yaml") == scene


def test_parameters_reach_the_model_in_si() -> None:
    """The model has the file's numbers in SI, a type per rope drive, None for absent groups."""
    scene = load_scene("knuckle_springs")
    model = scene.model
    assert model.support.boom[:5] == (5.0, 2.0, 4.166666666666667, 0.01, None)
    assert model.support.jib_spring == (1000.0, math.radians(-60.0), True)
    assert isinstance(model.cable, ForceRope) and model.cable.spring == (200.0, 2.0)
    assert model.drag is None and model.swing_friction is None
    assert not scene.sampled and scene.law is None
    assert isinstance(load_scene("knuckle_winch").model.cable, MotionRope)
    pole = load_scene("knuckle_pole")
    assert pole.model.cable == LockedRope(1.0) and pole.actuated == ("slew", "boom", "jib")


def test_nominal_groups_reach_the_law_only() -> None:
    """`control.nominal` changes the scene of the law, not the simulated one."""
    scene = load_scene("knuckle_wrong_mass")
    assert scene.model.load.mass == 1.0
    assert scene.law.nominal.load.mass == 1.01  # pyright: ignore[reportAttributeAccessIssue, reportOptionalMemberAccess]


def test_another_law_ignores_the_settings_of_the_scene_s_own() -> None:
    """Another law leaves out the own one's gains, as `notes` say; period, shared settings stay."""
    switched = load_scene("knuckle_unknown_load", {"control.law": "lqr"})
    assert switched.notes["left_out"] == "kp, kd, reach, adaptation of law 'energy'"
    assert set(switched.document["control"]) == {"law", "period", "nominal"}
    two_rate = load_scene("offshore_two_rate", {"control.law": "harmonic"})
    assert set(two_rate.document["control"]) == {"law", "period", "servo", "tracker_rate", "vision"}
    angular = load_scene("offshore_two_rate", {"control.law": "angular", "control.kp": 1.0})
    assert set(angular.document["control"]) == {"law", "period", "kp"}
    same = load_scene("knuckle_setpoint", {"control.law": "energy"})
    assert same == load_scene("knuckle_setpoint") and "left_out" not in same.notes


def test_a_scene_is_a_source_of_scenes() -> None:
    """A scene is returned as it is, or reloaded with changes; other objects are refused."""
    scene = load_scene("knuckle_setpoint")
    assert load_scene(scene) is scene
    assert load_scene(scene, {"duration": 1.0}) == load_scene("knuckle_setpoint", {"duration": 1.0})
    with pytest.raises(
        crane_sim.SceneError, match=r"^scene \[0, 0, .*\.\.\.: must be a name, a file or a dict$"
    ):
        load_scene([0] * 1000)  # pyright: ignore[reportArgumentType]


def test_a_file_with_a_misspelt_crane() -> None:
    """An error about a misspelt first key suggests the right one."""
    with pytest.raises(crane_sim.SceneError, match="unknown key 'crne', did you mean 'crane'"):
        load_scene({"crne": "knuckle"})
    with pytest.raises(crane_sim.SceneError, match="crane: is missing"):
        load_scene({"cabel": {"lengths": 2.0}})  # as near to crane as to nothing


def test_null_means_absent() -> None:
    """A null key, in a file or by an override, has its default."""
    plain = load_scene("knuckle_setpoint", {"control.kp": None, "gravity": None, "initial.v": None})
    assert plain.model == load_scene("knuckle_setpoint").model and plain.initial_v == (0.0,) * 6
    assert load_scene(plain.to_dict()) == plain
    assert load_scene("knuckle_unknown_load", {"control.adaptation": None}).law is not None


DOCUMENT = yaml.safe_load(scene_files()["knuckle_setpoint"].read_text())
JUNK = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=8),
    lambda inner: (
        st.lists(inner, max_size=7) | st.dictionaries(st.text(max_size=8), inner, max_size=4)
    ),
    max_leaves=8,
)
KEYS = st.sampled_from(
    [f"{group}.{key}" for group, keys in DOCUMENT.items() if isinstance(keys, dict) for key in keys]
)


@settings(max_examples=300, suppress_health_check=list(HealthCheck))
@given(key=KEYS | st.sampled_from(list(DOCUMENT)) | st.text(max_size=10), value=JUNK)
def test_any_value_anywhere_is_a_scene_or_an_error(key: str, value: Any) -> None:
    """Any value of any key results in a scene or a single-line SceneError."""
    try:
        load_scene(DOCUMENT, {key: value})
    except crane_sim.SceneError as error:
        assert "\n" not in str(error)


def test_groups_may_be_merged_over_merged_ones(tmp_path: Path) -> None:
    """YAML's `<<` of a group that has one itself may replace a key; two equal keys are refused."""
    file = tmp_path / "merged.yaml"
    file.write_text("base: &base {x: 1}\ndeep: {er: {A: &A {<<: *base, x: 2}}}\nB: {<<: *A}\n")
    assert read_groups(file, "file")["B"] == {"x": 2}
    file.write_text("A: {x: 1, x: 2}\n")
    with pytest.raises(SceneError, match="key 'x' stands twice"):
        read_groups(file, "file")


def test_files_of_the_nominal_scene_are_beside_the_scene(tmp_path: Path) -> None:
    """The record of a sea in a law's nominal scene is looked for in the scene's folder, too."""
    t = np.linspace(0.0, 40.0, 401)
    np.savetxt(
        tmp_path / "sea.csv",
        np.column_stack([t, 0.1 * t]),
        delimiter=",",
        header="time,heave",
        comments="",
    )
    document = load_scene("knuckle_setpoint").to_dict()
    document["control"]["nominal"] = {"base_motion": {"file": "sea.csv"}}
    (tmp_path / "own.yaml").write_text(yaml.safe_dump(document))
    nominal = load_scene(tmp_path / "own.yaml").document["control"]["nominal"]
    assert nominal["base_motion"]["file"] == str(tmp_path / "sea.csv")
