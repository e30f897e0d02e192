"""The recipes of docs/adding.md, followed: a law of another package, and a new scene."""

import os
import sys
from pathlib import Path

import numpy as np
import yaml
from process_helpers import run_to_completion

import crane_sim
from crane_sim.files.catalogue import scene_files

LAW = '''
from typing import NamedTuple
from crane_sim.laws import read_settings

class Settings(NamedTuple):
    stiffness: float = 1.0

class Hold:
    """Carries the crane's weight and pulls the slew to its target."""
    def __init__(self, stiffness, target, nominal):
        self.stiffness, self.target, self.nominal = stiffness, target, nominal
    def __call__(self, t, q, v):
        return (self.stiffness * (self.target - q[0]) - 50.0 * v[0], 200.0, 90.0, -9.81 * self.nominal.load.mass)

def build(settings, scene):
    return Hold(read_settings(Settings, settings).stiffness, scene.reference[0], scene.model)
'''  # noqa: E501


def test_a_law_of_another_package_is_found_by_its_name(tmp_path: Path) -> None:
    """A package with its law in the entry-point group runs it by name, its settings checked."""
    (tmp_path / "holding.py").write_text(LAW)
    folder = tmp_path / "holding-1.0.dist-info"
    folder.mkdir()
    (folder / "METADATA").write_text("Metadata-Version: 2.1\nName: holding\nVersion: 1.0\n")
    (folder / "entry_points.txt").write_text("[crane_sim.laws]\nhold = holding:build\n")
    scene = yaml.safe_load(scene_files()["knuckle_setpoint"].read_text())
    scene |= {"duration": 0.2, "control": {"law": "hold", "stiffness": 7.0}}
    (tmp_path / "mine.yaml").write_text(yaml.safe_dump(scene))
    code = (
        "import crane_sim; r = crane_sim.simulate('mine.yaml'); print(r.u[0].tolist());"
        "crane_sim.load_scene('mine.yaml', {'control.stifness': 1.0})"
    )
    environment = os.environ | {"PYTHONPATH": str(tmp_path), "CRANE_SIM_INTERPRETED": "1"}
    result = run_to_completion([sys.executable, "-c", code], env=environment, cwd=tmp_path)
    assert yaml.safe_load(result.stdout) == [7.0 * np.radians(45.0), 200.0, 90.0, -9.81], (
        result.stderr
    )
    assert (
        "control: unknown key 'stifness' for law 'hold', did you mean 'stiffness'?" in result.stderr
    )


def test_a_new_scene_runs_from_its_file(tmp_path: Path) -> None:
    """A copied and edited scene file is checked and run by its path."""
    file = tmp_path / "mine.yaml"
    text = scene_files()["knuckle_setpoint"].read_text()
    file.write_text(
        text.replace("payload: {mass: 1.0}", "payload: {mass: 2.5}").replace(
            "duration: 40.0", "duration: 0.1"
        )
    )
    run = crane_sim.simulate(file)
    assert run.scene.name == "mine" and run.scene.model.load.mass == 2.5
    assert run.u[0, 3] == -0.5 - 2.5 * 9.81  # kp (1.5 - 2.0) - m g
