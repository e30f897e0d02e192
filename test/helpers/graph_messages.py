"""The messages of a run over ROS, read from its bag, and checks of what they alone give."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from mcap_samples import read, stamp_of
from scipy.spatial.transform import Rotation
from urdf_kinematics import link_position

from crane_sim.scenes.scene import Scene

Messages = dict[str, list[Any]]
STAMPS = 10  # of a bag whose states are checked


def messages_of(bag: Path) -> Messages:
    """Return a bag's messages by topic without namespace.

    Topics of all cranes begin with a slash.
    """
    topics = read(bag).items()  # (name, [(time of reception, message), ...])
    return {
        name.partition("/")[2].partition("/")[2] or name: [each for _, each in samples]
        for name, samples in topics
    }


def vector(message: Any) -> np.ndarray:
    """Return a point or vector (3,)."""
    return np.array([message.x, message.y, message.z])


def quaternion(message: Any) -> Rotation:
    """Return the rotation of a quaternion message."""
    return Rotation.from_quat([message.x, message.y, message.z, message.w])


def check_payload(scene: Scene, messages: Messages) -> None:
    """Check that URDF, joint states and the base's odometry alone give the payload's pose.

    Where sensors measure the joints, joint states have errors: the payload's pose is not compared
    with them.
    """
    states = {stamp_of(state): state for state in messages["joint_states"]}
    odometry = {stamp_of(base): base.pose.pose for base in messages["base/odometry"]}
    poses = {stamp_of(pose): pose.pose.position for pose in messages["payload_pose"]}
    moves = getattr(scene.model, "base", None) is not None
    assert set(odometry) == (set(states) if moves else set())
    assert poses  # its publisher is best effort: some messages may be missing
    check_frames(messages, poses)
    if scene.file.sensors:
        return
    for stamp in some(poses):
        joints = dict(zip(states[stamp].name, states[stamp].position, strict=True))
        payload = link_position(messages["robot_description"][0].data, joints, "payload_link")
        if moves:
            payload = quaternion(odometry[stamp].orientation).apply(payload) + vector(
                odometry[stamp].position
            )
        # unit vectors have length 1 to the integrator's tolerance; rounding is far less
        assert vector(poses[stamp]) == pytest.approx(payload, abs=1e-9)


def some(stamps: Iterable[int]) -> list[int]:
    """Return at most `STAMPS` stamps, from the first to the last one."""
    ordered = sorted(stamps)
    return [ordered[i] for i in np.unique(np.linspace(0, len(ordered) - 1, STAMPS).astype(int))]


def check_frames(messages: Messages, poses: dict[int, Any]) -> None:
    """Check that the clock is in the bag, and the frames, whose chain gives the payload's pose."""
    clocks = [each.clock.sec * 10**9 + each.clock.nanosec for each in messages["/clock"]]
    assert clocks and clocks == sorted(clocks), clocks
    if "/tf" not in messages:  # the package is not installed
        return
    fixed = {
        each.child_frame_id: each
        for message in messages["/tf_static"]
        for each in message.transforms
    }
    moving: dict[int, dict[str, Any]] = {}
    for message in messages["/tf"]:
        moving.setdefault(stamp_of(message.transforms[0]), {}).update(
            {t.child_frame_id: t for t in message.transforms}
        )
    for stamp in some(poses.keys() & moving.keys()):
        frame = "payload_link"
        position, parents = np.zeros(3), fixed | moving[stamp]
        while frame != "world":
            transform = parents[frame].transform
            position = quaternion(transform.rotation).apply(position) + vector(
                transform.translation
            )
            frame = parents[frame].header.frame_id
        # unit vectors have length 1 to the integrator's tolerance
        assert vector(poses[stamp]) == pytest.approx(position, abs=1e-9)
