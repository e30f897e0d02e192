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
    """Return the messages of a bag by topic, without the namespace; topics of all cranes begin with a slash."""
    rows = read(bag).items()
    return {topic.partition("/")[2].partition("/")[2] or topic: [each for _, each in row] for topic, row in rows}


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
    check_frames(messages, poses)
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


def check_frames(messages: Messages, poses: dict[int, Any]) -> None:
    """Check that the clock is in the bag, and the frames, whose chain gives the payload's pose."""
    clocks = [each.clock.sec * 10**9 + each.clock.nanosec for each in messages["/clock"]]
    assert clocks and clocks == sorted(clocks), clocks
    if "/tf" not in messages:  # the package is not installed
        return
    fixed = {each.child_frame_id: each for message in messages["/tf_static"] for each in message.transforms}
    moving: dict[int, dict[str, Any]] = {}
    for message in messages["/tf"]:
        moving.setdefault(stamp_of(message.transforms[0]), {}).update({t.child_frame_id: t for t in message.transforms})
    stamp, frame = max(poses.keys() & moving.keys()), "payload_link"
    place, above = np.zeros(3), fixed | moving[stamp]
    while frame != "world":
        transform = above[frame].transform
        turn = transform.rotation
        place = Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]).apply(place) + vector(transform.translation)
        frame = above[frame].header.frame_id
    # what the solver leaves of the length of a unit vector
    assert vector(poses[stamp]) == pytest.approx(place, abs=1e-9)
