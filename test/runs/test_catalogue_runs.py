"""Every scene of the catalogue over ROS, with real processes and a recorder."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap_samples import read, stamp_of
from scipy.spatial.transform import Rotation
from urdf_kinematics import forward

from crane_sim import load_scene
from crane_sim.files.catalogue import scene_files

NAMES = sorted(scene_files())
SHARES = 4
LIMIT = 300.0  # s for a share, which takes less than one minute


@pytest.mark.parametrize("share", range(SHARES))
def test_every_scene_runs_and_is_recorded(share: int, tmp_path: Path) -> None:
    """Every scene of the catalogue runs without an error, with all steps on the disk; its messages agree."""
    names = NAMES[share::SHARES]
    command = [sys.executable, str(Path(__file__).parents[1] / "programs" / "catalogue_runs.py"), str(tmp_path), *names]
    env = os.environ | {"NUMBA_DISABLE_JIT": "1", "TMPDIR": str(tmp_path)}
    done = subprocess.run(command, env=env, capture_output=True, text=True, timeout=LIMIT, check=False)
    runs = [json.loads(line) for line in done.stdout.splitlines()]
    assert [run["scene"] for run in runs] == names, done.stderr
    failed = [run for run in runs if "error" in run or not run["due"] == run["steps"] == run["recorded_steps"]]
    assert not failed, done.stderr
    assert all(Path(run["recording"]).stat().st_size for run in runs)
    for name in names:
        check_messages(name, tmp_path / f"{name}.mcap")


def check_messages(name: str, bag: Path) -> None:
    """Check that URDF, joint states and the base's odometry give the payload's pose, from the messages alone.

    Where a sensor measures the joints their states are not the true ones, and nothing is checked.
    """
    scene, topics = load_scene(name), read(bag)
    messages = {topic.removeprefix(f"/{scene.crane}/"): [each for _, each in rows] for topic, rows in topics.items()}
    states = {stamp_of(state): state for state in messages["joint_states"]}
    odometry = {stamp_of(base): base.pose.pose for base in messages["base/odometry"]}
    poses = {stamp_of(pose): pose.pose.position for pose in messages["payload_pose"]}
    moves = getattr(scene.model, "base", None) is not None
    assert len(odometry) == (len(states) if moves else 0)
    assert poses  # best effort: some may be missing
    stamp = max(poses)  # after the crane has moved
    if scene.file.sensors:
        return
    joints = dict(zip(states[stamp].name, states[stamp].position, strict=True))
    payload = forward(messages["robot_description"][0].data, joints, "payload_link")
    if moves:
        turn, at = odometry[stamp].orientation, odometry[stamp].position
        payload = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).apply(payload) + [at.x, at.y, at.z]
    place = poses[stamp]
    # what the solver leaves of the length of a unit vector; rounding is far less
    assert np.array([place.x, place.y, place.z]) == pytest.approx(payload, abs=1e-9)
