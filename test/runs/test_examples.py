"""The examples, each as a process of its own beside a plant node, as users run them."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from example_helpers import EXAMPLES, check_arrival, check_lockstep, run, started_example
from process_helpers import has_exited, next_line, run_to_completion, started_program, wait_until

from crane_sim.orchestration.ros_environment import node_environment

TERMINATED_DURING = """
import os, runpy, signal, sys
import rclpy, rclpy.executors, rclpy.node

owner, name, script = sys.argv[1:]
owner = eval(owner)
original = getattr(owner, name)


def call_and_terminate(*arguments, **options):
    result = original(*arguments, **options)
    print("terminated", flush=True)
    os.kill(os.getpid(), signal.SIGTERM)
    return result


setattr(owner, name, call_and_terminate)
sys.path.insert(0, os.path.dirname(script))
runpy.run_path(script, run_name="__main__")
"""


def test_a_controller_of_plain_rclpy(domain_id: int) -> None:
    """A node without imports of the simulator commands the crane in lockstep to the same states.

    They are those of `simulate`.
    """
    with started_example("my_controller.py", domain_id):
        summary = run(domain_id)
    check_lockstep(summary)
    assert summary["min_rope_tension"] > 0.0  # in real time the first steps have no command


def test_a_controller_that_sends_plain_arrays(domain_id: int) -> None:
    """Arrays of efforts, which have no names and stamps, command the crane in real time."""
    with started_example("my_array_controller.py", domain_id):
        for _ in range(
            3
        ):  # where the machine holds it up for half a second, efforts are zero meanwhile
            summary = run(domain_id, mode="realtime", rate=2.0)
            if not summary["silences"]:
                break
    check_arrival(summary)
    assert summary["commands"]["rejected"] == summary["commands"]["late"] == 0


@pytest.mark.parametrize(
    ("name", "call"),
    [
        ("my_controller.py", "rclpy init"),
        ("my_array_controller.py", "rclpy.node.Node __init__"),
        ("my_controller.py", "rclpy.executors.SingleThreadedExecutor __init__"),
    ],
    ids=["rclpy starts", "the node is made", "the executor is made"],
)
def test_an_example_handles_sigterm_at_any_time(
    name: str, call: str, ros_environment: dict[str, str]
) -> None:
    """An example that gets SIGTERM while rclpy starts exits with code 0, without a traceback."""
    command = [sys.executable, "-c", TERMINATED_DURING, *call.split(), str(EXAMPLES / name)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with started_program(command, env=ros_environment, **pipes) as process:
        assert next_line(process) == "terminated\n"
        _, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")


def test_the_example_of_two_cranes_handles_sigterm(ros_environment: dict[str, str]) -> None:
    """An example that gets SIGTERM while it starts its nodes ends them, and exits with code 1."""
    with started_program(
        [sys.executable, EXAMPLES / "two_cranes.py"], env=ros_environment, stdout=subprocess.PIPE
    ) as process:
        children = Path(f"/proc/{process.pid}/task/{process.pid}/children")
        wait_until(lambda: len(children.read_text().split()) > 1, "the first nodes")
        nodes = list(map(int, children.read_text().split()))
        process.send_signal(signal.SIGTERM)
        process.communicate()
        assert process.returncode == 1 and all(map(has_exited, nodes))


def test_the_environment_of_an_example_is_that_of_the_nodes(tmp_path: Path) -> None:
    """examples/in_domain sets the same variables as the simulator for its own nodes."""
    output = run_to_completion([EXAMPLES / "in_domain", "7", "env"], check=True).stdout
    variables = dict(line.split("=", 1) for line in output.splitlines() if "=" in line)
    expected = node_environment(7, tmp_path)
    for name in expected:
        if name.startswith(("RMW_", "ROS_DOMAIN", "ROS_AUTOMATIC", "FASTRTPS_", "FASTDDS_")):
            assert variables[name] == expected[name], name
