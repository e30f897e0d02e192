"""The frames of a crane on a ship, as another node receives them: before a run, and during it."""

from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from bench_graph import NodeProcess, graph, remote, wait_until
from frame_listener import FrameListener
from graph_messages import vector
from scipy.spatial.transform import Rotation

from crane_sim import load_scene

SHIP = {
    "roll": {"amplitude": 0.1, "frequency": 0.7},
    "mount": {"position": [5.0, 1.0, 2.0], "yaw": 0.5},
}
FIRST = 10_000_000  # ns, stamp of the first state


@pytest.fixture
def ship(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[tuple[NodeProcess, FrameListener]]:
    """Yield a ready plant that has not begun, a knuckle crane on a ship, and its subscribers."""
    monkeypatch.setenv("CRANE_SIM_INTERPRETED", "1")
    scene = tmp_path / "ship.yaml"
    on_ship = {
        "base_motion": SHIP,
        "imu": {"position": [1.0, 2.0, 3.0]},
        "duration": 1e3,
        "control": None,
    }
    load_scene("knuckle_setpoint", on_ship).dump(scene)
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        listener = FrameListener(client.node, "knuckle")
        with NodeProcess(
            "crane_sim.ros.plant_node", env, f"scene:={scene}", "frame_prefix:=a/"
        ) as plant:
            plant.await_event("ready")
            yield plant, listener


def test_base_and_frames_are_there_before_the_run_and_in_it(
    ship: tuple[NodeProcess, FrameListener],
) -> None:
    """Base and frames of the first state come before the run begins; then they fit the payload."""
    plant, listener = ship
    wait_until(lambda: FIRST in listener.odometry, "the odometry of the first state")
    if find_spec("tf2_msgs"):
        wait_until(
            lambda: FIRST in listener.moving and bool(listener.fixed),
            "the frames of the first state",
        )
    assert set(listener.odometry) == {FIRST} and not listener.poses
    plant.send("go")
    wait_until(
        lambda: len(listener.odometry.keys() & listener.poses.keys()) > 3, "states of the run"
    )
    stamp = max(listener.odometry.keys() & listener.poses.keys())
    assert listener.odometry[stamp].child_frame_id == "a/base_link"
    if not find_spec("tf2_msgs"):
        pytest.skip("tf2_msgs is not installed: there are no frames")
    wait_until(
        lambda: bool(listener.moving.keys() & listener.poses.keys() & listener.odometry.keys()),
        "frames",
    )
    common = listener.moving.keys() & listener.poses.keys() & listener.odometry.keys()
    assert vector(listener.fixed["a/imu_link"].transform.translation).tolist() == [1.0, 2.0, 3.0]
    for stamp in common:
        payload, base = listener.poses[stamp].pose, listener.odometry[stamp].pose.pose
        for pose, frame in ((payload, "a/payload_link"), (base, "a/base_link")):
            # rounding
            assert listener.pose(stamp, frame)[0] == pytest.approx(vector(pose.position), abs=1e-12)
        turn = Rotation.from_quat(
            [base.orientation.x, base.orientation.y, base.orientation.z, base.orientation.w]
        )
        # rad, rounding
        assert (listener.pose(stamp, "a/base_link")[1].inv() * turn).magnitude() < 1e-12
