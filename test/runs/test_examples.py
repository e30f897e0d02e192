"""The examples, each as a process of its own against a real plant, as their users run them."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest
from example_helpers import EXAMPLES, check_arrival, check_lockstep, example, run
from process_helpers import completed, gone, next_line, started_program, wait_until

from crane_sim.orchestration.ros_environment import node_environment

STRUCK = """
import os, runpy, signal, sys
import rclpy, rclpy.executors, rclpy.node

owner, name, script = sys.argv[1:]
owner = eval(owner)
real = getattr(owner, name)


def struck(*arguments, **options):
    found = real(*arguments, **options)
    print("struck", flush=True)
    os.kill(os.getpid(), signal.SIGTERM)
    return found


setattr(owner, name, struck)
sys.path.insert(0, os.path.dirname(script))
runpy.run_path(script, run_name="__main__")
"""


def test_a_controller_of_plain_rclpy(domain_id: int) -> None:
    """A node that knows nothing of the simulator drives the crane in lockstep, and no bit is lost on the way."""
    with example("my_controller.py", domain_id):
        summary = run(domain_id)
    check_lockstep(summary)
    assert summary["min_rope_tension"] > 0.0  # in real time the first command comes after a moment of none


@pytest.mark.slow
def test_the_same_controller_in_real_time(domain_id: int) -> None:
    """The same node drives the crane in real time."""
    with example("my_controller.py", domain_id):
        check_arrival(run(domain_id, mode="realtime", rate=2.0))


def test_a_controller_of_bare_arrays(domain_id: int) -> None:
    """Efforts without names and stamps drive the crane in real time."""
    with example("my_array_controller.py", domain_id):
        summary = run(domain_id, mode="realtime", rate=2.0)
    check_arrival(summary)
    assert summary["commands"]["rejected"] == summary["commands"]["late"] == 0


@pytest.mark.parametrize("name", ["my_controller.py", "my_array_controller.py"])
@pytest.mark.parametrize(
    "instant",
    ["rclpy init", "rclpy.node.Node __init__", "rclpy.executors.SingleThreadedExecutor __init__"],
    ids=["rclpy starts", "the node is made", "the executor is made"],
)
def test_an_example_ends_whenever_it_is_told_to(name: str, instant: str, ros_environment: dict[str, str]) -> None:
    """A SIGTERM that comes while rclpy starts is not lost: the example ends in order, without a traceback."""
    command = [sys.executable, "-c", STRUCK, *instant.split(), str(EXAMPLES / name)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with started_program(command, limit=60.0, env=ros_environment, **pipes) as process:
        assert next_line(process) == "struck\n"
        _, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")


def test_two_cranes_end_when_they_are_told_to(ros_environment: dict[str, str]) -> None:
    """A SIGTERM that comes while the example of two cranes starts its nodes ends it, and all of these, with code 1."""
    with started_program(
        [sys.executable, EXAMPLES / "two_cranes.py"], env=ros_environment, stdout=subprocess.PIPE
    ) as it:
        children = Path(f"/proc/{it.pid}/task/{it.pid}/children")
        wait_until(lambda: len(children.read_text().split()) > 1, "the first nodes")
        nodes = list(map(int, children.read_text().split()))
        it.send_signal(signal.SIGTERM)
        it.communicate()
        assert it.returncode == 1 and all(map(gone, nodes))


def test_the_environment_of_an_example_is_that_of_the_nodes(tmp_path: Path) -> None:
    """What examples/in_domain tells a process is what the simulator tells its own nodes."""
    shown = completed([EXAMPLES / "in_domain", "7", "env"], check=True).stdout
    ours = dict(line.split("=", 1) for line in shown.splitlines() if "=" in line)
    wanted = node_environment(7, tmp_path)
    for name in wanted:
        if name.startswith(("RMW_", "ROS_DOMAIN", "ROS_AUTOMATIC", "FASTRTPS_", "FASTDDS_")):
            assert ours[name] == wanted[name], name
