"""Cranes of every kind on a ship, with instruments: over ROS, recorded, with real processes."""

from pathlib import Path
from typing import Any

import pytest
from graph_messages import check_payload, messages_of, vector
from mcap_samples import stamp_of
from scene_runs import run_scenes

from crane_sim import load_scene
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.base_state import base_state
from crane_sim.simulation.measurements import measure_imu, measure_payload

CRANES = ("tower_gust", "mobile_lift", "port_sts_container", "knuckle_setpoint", "overhead_spatial")
SEA: dict[str, Any] = {
    "base_motion": {
        "sea": {
            "significant_height": 1.5,
            "peak_period": 8.0,
            "components": 5,
            "response": {"surge": 0.2, "heave": 0.9, "roll": 0.02, "pitch": 0.01},
        },
        "mount": {"position": [-18.0, 4.0, 6.5], "yaw": "90 deg"},
    },
    "imu": {
        "position": [1.0, 0.0, -0.5],
        "acceleration_noise": 0.01,
        "orientation_noise": 0.002,
        "rate": 50.0,
    },
    "camera": {"noise": 0.02, "delay": 0.02},
}


@pytest.mark.long
def test_cranes_on_a_ship_are_whole_on_the_graph(tmp_path: Path) -> None:
    """Payload, base, motion reference unit and camera are on the graph for every crane at sea.

    States are the run's.
    """
    scenes = {}
    for name in CRANES:
        scenes[name] = load_scene(name, SEA | {"duration": 0.1})
        scenes[name].dump(tmp_path / f"{name}.yaml")
    run_scenes([str(tmp_path / f"{name}.yaml") for name in CRANES], tmp_path)
    for name, scene in scenes.items():
        messages = messages_of(tmp_path / f"{name}.mcap")
        check_payload(scene, messages)
        check_instruments(scene, messages)


def check_instruments(scene: Scene, messages: dict[str, list[Any]]) -> None:
    """Check that every message of base and instruments has the numbers of its state."""
    instruments, period = scene.instruments, scene.period_ns
    assert (
        instruments is not None and instruments.imu is not None and instruments.camera is not None
    )
    for message in messages["base/odometry"]:
        state = base_state(scene, (stamp_of(message) // period - 1) * scene.period)
        assert (message.header.frame_id, message.child_frame_id) == ("world", "base_link")
        assert vector(message.twist.twist.linear).tolist() == state.velocity.tolist()
        assert vector(message.twist.twist.angular).tolist() == state.angular_velocity.tolist()
    samples = {stamp_of(message) // period - 1: message for message in messages["base/imu"]}
    assert sorted(samples) == list(range(0, scene.steps + 1, instruments.imu.sampling.every))
    for k, message in samples.items():
        expected = measure_imu(scene, instruments.imu, k)
        assert vector(message.linear_acceleration).tolist() == expected.specific_force.tolist()
        assert vector(message.angular_velocity).tolist() == expected.angular_velocity.tolist()
    poses = {
        stamp_of(message): vector(message.pose.position) for message in messages["payload_pose"]
    }
    frames = {stamp_of(message): message for message in messages["camera/payload_pose"]}
    delay = instruments.camera.sampling.delay
    assert sorted(frames) == [(k + 1) * period for k in range(scene.steps + 1 - delay)]
    for stamp in frames.keys() & poses.keys():
        expected = measure_payload(
            scene, instruments.camera, stamp // period - 1, poses[stamp].tolist()
        )
        assert frames[stamp].header.frame_id == "base_link"
        assert vector(frames[stamp].pose.position).tolist() == expected.tolist()
