"""The message packages built from nothing, as `crane interfaces` does in a new environment."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from crane_sim.interfaces.packages import USES

pytestmark = pytest.mark.slow

BUILD = "import sys; from crane_sim.cli import main; sys.exit(main())"
ROUND_TRIP = """
from rclpy.serialization import deserialize_message, serialize_message
from control_msgs.action import FollowJointTrajectory
from simulation_interfaces.action import SimulateSteps
from simulation_interfaces.srv import GetEntityState
from tf2_msgs.msg import TFMessage
goal = FollowJointTrajectory.Goal()
goal.trajectory.joint_names = ["trolley"]
response = GetEntityState.Response()
response.state.header.frame_id = "world"
for message in (goal, response, SimulateSteps.Goal(steps=7), TFMessage()):
    assert deserialize_message(serialize_message(message), type(message)) == message
"""


def link(source: str, target: str) -> None:
    """Put a file there without a copy, where the file system can."""
    try:
        os.link(source, target)
    except OSError:
        shutil.copy2(source, target)


def run(python: Path, code: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    """Run a program in an environment."""
    kept = {
        name: value
        for name, value in os.environ.items()
        if name not in ("PYTHONPATH", "VIRTUAL_ENV")
    }
    command = [python, "-c", code, *arguments]
    return subprocess.run(
        command, env=kept, capture_output=True, text=True, check=False, timeout=3000.0
    )


@pytest.fixture
def python(tmp_path: Path) -> Path:
    """Return the Python of a copy of this environment without anything that was built into it."""
    skipped = shutil.ignore_patterns(*USES, "interfaces-build", "__pycache__")
    prefix = tmp_path / "environment"
    shutil.copytree(sys.prefix, prefix, symlinks=True, copy_function=link, ignore=skipped)
    return prefix / "bin" / "python"


def test_packages_are_built_from_nothing(python: Path) -> None:
    """One command makes what was missing, with ROS's messages, and leaves nothing else behind."""
    before = run(python, BUILD, "interfaces", "--check")
    assert before.returncode == 1 and before.stdout.count("not there") == len(USES), (
        before.stdout + before.stderr
    )
    built = run(python, BUILD, "interfaces")
    if "is the network there?" in built.stderr:
        pytest.skip("the wheels of the generators could not be installed: there is no network")
    assert built.returncode == 0 and built.stdout.count("built here") == len(USES), (
        built.stdout + built.stderr
    )
    checked = run(python, ROUND_TRIP)
    assert checked.returncode == 0, checked.stderr
    assert not (python.parents[1] / "interfaces-build").exists()
