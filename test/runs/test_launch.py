"""The launch file with the real `ros2 launch`, where it is installed: PyPI has no wheels of it."""

import os
import re
import shutil
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest
from process_helpers import run_to_completion

from crane_sim import read_recording, simulate

ROOT = Path(__file__).parents[2]
SCENE = """
crane: overhead
duration: 2.0
trolley: {drive: force, mass: 20.0}
cable: {lengths: [3.0], node_masses: [10.0]}
initial: {angles: [10 deg]}
reference: {q: [1.0]}
control: {law: lqr}
"""

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        find_spec("ros2launch") is None, reason="ros2launch is absent (ROS 2 installations have it)"
    ),
]


def test_a_launched_crane_runs_to_its_end(ros_environment: dict[str, str], tmp_path: Path) -> None:
    """In a colcon workspace `ros2 launch` runs plant, controller and recorder.

    The states are those of `simulate`.
    """
    scene, recording, install = tmp_path / "scene.yaml", tmp_path / "run.rrd", tmp_path / "install"
    scene.write_text(SCENE)
    bases = [
        "--build-base",
        str(tmp_path / "build"),
        "--install-base",
        str(install),
        "--base-paths",
        str(ROOT),
    ]
    build = [sys.executable, "-m", "colcon", "--log-base", str(tmp_path / "log"), "build", *bases]
    run_to_completion([*build, "--packages-select", "crane_sim"], cwd=tmp_path, check=True)
    prefixes = f"{install / 'crane_sim'}:{os.environ.get('AMENT_PREFIX_PATH', '')}"
    arguments = [f"scene:={scene}", f"path:={recording}", "namespace:=west", "frame_prefix:=west/"]
    done = run_to_completion(
        [str(shutil.which("ros2")), "launch", "crane_sim", "crane.launch.py", *arguments],
        env=ros_environment | {"AMENT_PREFIX_PATH": prefixes},
        cwd=tmp_path,
    )
    said = done.stdout + done.stderr
    assert done.returncode == 0, said
    found = re.search(r'"state_sha256": "(\w+)"', said)
    assert found is not None and found[1] == simulate(scene).summary["state_sha256"]
    assert len(re.findall("process has finished cleanly", said)) == 3, said
    assert len(read_recording(recording).t) == 200
