"""A knuckle boom with speed drives, over real-time topics, with sensors, a fault and a reset."""

from collections.abc import Iterator
from math import inf
from pathlib import Path

import pytest
from bench_graph import NodeProcess, Remote, graph, remote, wait_until
from sensor_msgs.msg import JointState
from std_msgs.msg import Float64MultiArray
from std_srvs.srv import SetBool

from crane_sim import load_scene

SPEEDS = [0.2, -0.1, 0.1, 0.05]  # rad/s and m/s of slew, boom, jib, rope
BIAS = 0.25  # rad, of the slew's sensor
CHANGES = {
    "duration": 1e3,
    "control": None,
    "actuators": {"all": {"drive": "velocity", "servo": {"gain": inf, "max_acceleration": 1.0}}},
    "sensors": {"slew": {"bias": [BIAS, 0.0]}},
    "faults": {"dark": {"kind": "sensor_loss", "joint": "jib"}},
}


@pytest.fixture
def crane(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Remote]:
    """Yield a node beside a run in real time that has begun, paused at its first state."""
    file = tmp_path / "scene.yaml"
    load_scene("knuckle_setpoint", CHANGES).dump(file)
    options = (
        f"scene:={file}",
        "mode:=realtime",
        "commanded:=true",
        "paused:=true",
        "command_timeout:=0.0",
    )
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as node:
        with NodeProcess("crane_sim.ros.plant_node", env, *options) as plant:
            plant.await_event("ready")
            plant.send("go")
            wait_until(lambda: bool(node.states), "the first state")
            yield node


def test_speeds_come_by_the_array_topic(crane: Remote) -> None:
    """Joints reach the speeds of an array; states have sensor errors; a reset repeats the first."""
    array = crane.node.create_publisher(Float64MultiArray, "velocity_controller/commands", 10)
    accepted: list[JointState] = []
    crane.node.create_subscription(JointState, "accepted_command", accepted.append, 10)

    def send(values: list[float]) -> bool:
        array.publish(Float64MultiArray(data=values))
        return bool(accepted)

    wait_until(lambda: send(SPEEDS), "a command that is accepted")
    assert list(accepted[0].velocity) == SPEEDS and not accepted[0].effort
    for wrong in ([], SPEEDS[:3], [*SPEEDS, 0.0], [float("nan")] * 4, [1e300] * 4):
        send(wrong)
    assert crane.set(step_count=30) == "" and crane.step() == "ok"
    wait_until(lambda: len(crane.states) > 30, "the states")
    # exact drives; 0.2 s of ramp at most
    assert crane.velocities[-1][:4] == pytest.approx(SPEEDS, abs=1e-9)
    assert crane.positions[0][0] == BIAS
    dark = crane.request(SetBool, "plant/faults/dark", SetBool.Request(data=True))
    assert dark.success and crane.set(step_count=2) == "" and crane.step() == "ok"
    wait_until(lambda: len(crane.states) > 32, "the states")
    assert crane.positions[-1][2] == 0.0
    assert crane.reset() == "ok"
    wait_until(lambda: crane.states[-1] == crane.states[0], "the first state")
    assert crane.positions[-1] == crane.positions[0] and crane.velocities[-1] == crane.velocities[0]
