"""Laws in a user's file: where it is found, the same law by all commands, one-line errors."""

import json
from pathlib import Path

import pytest
from command_line import crane

import crane_sim
from crane_sim.files.errors import SceneError

LAW = """
def law(t, q, v):
    return (40.0 * (3.0 - q[0]) - 80.0 * v[0],)

def build(settings, scene):
    k = settings.get("stiffness", 40.0)
    return lambda t, q, v: (k * (scene.reference[0] - q[0]) - 80.0 * v[0],)

def build_nothing(settings, scene):
    pass

def build_badly(settings, scene):
    raise ValueError("first\\nsecond")

class Pair:
    commands = ("effort", "velocity")

    def __call__(self, t, q, v):
        return (0.0,)

def build_pair(settings, scene):
    return Pair()

number = 3
"""
SCENE = crane_sim.load_scene("overhead_energy").to_dict() | {"duration": 0.5}


def hash_with(law: str, **settings: float) -> str:
    """Return the hash of a run's states."""
    return crane_sim.simulate(SCENE | {"control": {"law": law} | settings}).summary["state_sha256"]


def test_a_law_of_a_file_is_its_function(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A law named by file or module, or built with settings, gives the states of its function."""
    file = tmp_path / "law_of_file.py"
    file.write_text(LAW)
    own = crane_sim.simulate(
        SCENE, law=lambda t, q, v: (40.0 * (3.0 - q[0]) - 80.0 * v[0],)
    ).summary["state_sha256"]
    assert hash_with(f"{file}:law") == hash_with(f"{file}:build") == own
    assert hash_with(f"{file}:build", stiffness=50.0) != own
    monkeypatch.syspath_prepend(str(tmp_path))
    assert hash_with("law_of_file:law") == own
    scene = tmp_path / "scene.yaml"
    scene.write_text(json.dumps(SCENE | {"control": {"law": "law_of_file.py:law"}}))  # JSON is YAML
    assert crane_sim.simulate(scene).summary["state_sha256"] == own


def test_the_command_takes_a_file_of_the_working_folder(tmp_path: Path) -> None:
    """`crane simulate --law FILE.py:FUNCTION` runs the law of that file."""
    (tmp_path / "mine.py").write_text(LAW)
    done = crane(
        "simulate",
        "overhead_energy",
        "--duration",
        "0.5",
        "--law",
        "mine.py:law",
        "--json",
        cwd=tmp_path,
    )
    assert json.loads(done.stdout)["law"] == f"{tmp_path / 'mine.py'}:law", done.stderr


BAD = {
    "nowhere.py:law": "there is no file nowhere.py",
    "FILE:other": "has no function 'other'",
    "FILE:number": "has no function 'number'",
    "FILE:build_nothing": "must return a law, a function of (t, q, v); it returned None",
    "FILE:build_badly": "control: first second",
    "FILE:build_pair": "commands = ('effort', 'velocity'): must be effort, velocity or position, "
    "or one of these for",
    "no_such_module:law": "ModuleNotFoundError",
    "energyy": "no such law (known: adaptive",
}


@pytest.mark.parametrize("law", BAD)
def test_a_wrong_law_is_refused_in_one_line(law: str, tmp_path: Path) -> None:
    """The error is one line that names the law and what is missing."""
    file = tmp_path / "mine.py"
    file.write_text(LAW)
    with pytest.raises(SceneError) as error:
        crane_sim.load_scene(SCENE | {"control": {"law": law.replace("FILE", str(file))}})
    assert BAD[law] in str(error.value) and "\n" not in str(error.value)


def test_a_function_has_no_settings(tmp_path: Path) -> None:
    """Settings of a function that takes none are an error that names them."""
    file = tmp_path / "mine.py"
    file.write_text(LAW)
    with pytest.raises(SceneError, match="stiffness"):
        crane_sim.load_scene(SCENE | {"control": {"law": f"{file}:law", "stiffness": 1.0}})
