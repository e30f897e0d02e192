"""The command line `ros2` against a run, where installed: PyPI has no wheels of it.

It is ros2cli of ROS 2 Jazzy.
"""

import shlex
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest
from bench_graph import NodeProcess, graph
from process_helpers import LIMIT
from speed_trolley import DOCUMENT

from crane_sim import load_scene

pytestmark = [
    pytest.mark.long,
    pytest.mark.skipif(
        find_spec("ros2cli") is None, reason="ros2cli is absent (ROS 2 installations have it)"
    ),
]
JOINTS, POSE = "/knuckle/joint_states", "/knuckle/payload_pose"
COMMANDS = [
    ("node list --no-daemon", ["/knuckle/plant", "/knuckle/controller"]),
    (
        "node info --no-daemon /knuckle/plant",
        [f"{JOINTS}: sensor_msgs/msg/JointState", "/knuckle/plant/set_pause"],
    ),
    (
        "topic list --no-daemon -t",
        [f"{JOINTS} [sensor_msgs/msg/JointState]", "/clock [rosgraph_msgs/msg/Clock]"],
    ),
    (f"topic info --no-daemon -v {JOINTS}", ["Node name: plant", "Reliability: RELIABLE"]),
    (f"topic echo --no-daemon --once {JOINTS}", ["- trolley", "position:", "velocity:"]),
    (f"topic echo --no-daemon --once {POSE}", ["frame_id: world", "orientation:"]),
    ("topic echo --no-daemon --once /diagnostics", ["name: knuckle/"]),
    ("service list --no-daemon -t", ["/knuckle/plant/reset_simulation [std_srvs/srv/Trigger]"]),
    ("service call /knuckle/plant/set_pause std_srvs/srv/SetBool '{data: true}'", ["success=True"]),
    ("service call /knuckle/plant/step_simulation std_srvs/srv/Trigger", ["success=True"]),
    (
        "service call /knuckle/plant/set_pause std_srvs/srv/SetBool '{data: false}'",
        ["success=True"],
    ),
    ("param list --no-daemon /knuckle/plant", ["command_timeout", "step_count"]),
    ("param get --no-daemon /knuckle/plant mode", ["realtime"]),
    (
        "param describe --no-daemon /knuckle/plant step_count",
        ["Min value: 1", "steps that one call"],
    ),
    ("param set --no-daemon /knuckle/plant step_count 5", ["Set parameter successful"]),
    ("param set --no-daemon /knuckle/plant step_count 0", ["step_count"]),
    ("lifecycle get --no-daemon /knuckle/plant", ["active [3]"]),
    ("lifecycle set --no-daemon /knuckle/controller deactivate", ["Transitioning successful"]),
    ("lifecycle set --no-daemon /knuckle/controller activate", ["Transitioning successful"]),
    (
        "topic pub --once -w 1 /knuckle/joint_commands sensor_msgs/msg/JointState '{name: [hook]}'",
        ["publishing #1"],
    ),
]
"""Arguments, and what the answer has."""
_TRIES = 5  # without its daemon it looks around for half a second, too short on a busy machine
GOAL = "{trajectory: {joint_names: [trolley], points: [{positions: [0.1], velocities: [0.0], time_from_start: {sec: 1}}]}}"  # noqa: E501
ACTION = "/knuckle/joint_trajectory_controller/follow_joint_trajectory"


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[dict[str, str]]:
    """Yield the environment of a run in real time that has begun."""
    scene = tmp_path / "scene.yaml"
    load_scene(DOCUMENT | {"duration": 3600.0}).dump(scene)
    with graph(tmp_path, monkeypatch) as (_, env):
        with (
            NodeProcess(
                "crane_sim.ros.plant_node", env, f"scene:={scene}", "mode:=realtime"
            ) as plant,
            NodeProcess(
                "crane_control.nodes.controller_node", env, f"scene:={scene}", "mode:=realtime"
            ) as controller,
        ):
            for node in (plant, controller):
                node.await_event("ready")
                node.send("go")
            yield env
            assert plant.process.poll() is None  # nothing has stopped it


def ros2(env: dict[str, str], arguments: list[str]) -> str:
    """Return what the command line prints."""
    command = [
        sys.executable,
        "-c",
        "import sys; from ros2cli.cli import main; sys.exit(main())",
        *arguments,
    ]
    done = subprocess.run(
        command, env=env, capture_output=True, text=True, timeout=LIMIT, check=False
    )
    return done.stdout + done.stderr


def test_commands_do_what_a_user_expects(run: dict[str, str]) -> None:
    """Nodes, topics, services, parameters and lifecycles answer; wrong values are refused.

    A wrong command is ignored.
    """
    for line, expected in COMMANDS:
        for _ in range(_TRIES):
            answer = ros2(run, shlex.split(line))
            if all(part in answer for part in expected):
                break
        else:
            pytest.fail(f"ros2 {line}: {answer}")


@pytest.mark.skipif(
    find_spec("control_msgs") is None,
    reason="control_msgs is absent (./crane interfaces builds it)",
)
def test_a_goal_is_sent(run: dict[str, str]) -> None:
    """A goal of FollowJointTrajectory ends with its result, and feedback on the way."""
    kind = "control_msgs/action/FollowJointTrajectory"
    answer = ros2(run, ["action", "send_goal", "-f", ACTION, kind, GOAL])
    assert "Feedback:" in answer and "error_code: 0" in answer and "SUCCEEDED" in answer, answer
