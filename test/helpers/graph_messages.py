"""The messages of a run over ROS, from its bag, and what a subscriber computes from them alone."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap_samples import read, stamp_of
from scipy.spatial.transform import Rotation
from urdf_kinematics import forward

from crane_sim.scenes.scene import Scene

Messages = dict[str, list[Any]]


def messages_of(bag: Path) -> Messages:
    """Return the messages of a bag by topic, without the namespace."""
    return {topic.partition("/")[2].partition("/")[2]: [each for _, each in rows] for topic, rows in read(bag).items()}


def vector(message: Any) -> np.ndarray:
    """Return a point or vector (3,)."""
    return np.array([message.x, message.y, message.z])


def check_payload(scene: Scene, messages: Messages) -> None:
    """Check that URDF, joint states and the base's odometry give the payload's pose, from the messages alone.

    Where a sensor measures the joints their states are not the true ones, and only the odometry is checked.
    """
    states = {stamp_of(state): state for state in messages["joint_states"]}
    odometry = {stamp_of(base): base.pose.pose for base in messages["base/odometry"]}
    poses = {stamp_of(pose): pose.pose.position for pose in messages["payload_pose"]}
    moves = getattr(scene.model, "base", None) is not None
    assert set(odometry) == (set(states) if moves else set())
    assert poses  # best effort: some may be missing
    stamp = max(poses)  # after the crane has moved
    if scene.file.sensors:
        return
    joints = dict(zip(states[stamp].name, states[stamp].position, strict=True))
    payload = forward(messages["robot_description"][0].data, joints, "payload_link")
    if moves:
        turn = odometry[stamp].orientation
        payload = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).apply(payload) + vector(odometry[stamp].position)
    # what the solver leaves of the length of a unit vector; rounding is far less
    assert vector(poses[stamp]) == pytest.approx(payload, abs=1e-9)
