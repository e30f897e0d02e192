"""The examples, each as a process of its own against a real plant, as their users run them."""

import runpy
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from crane_sim import load_scene, orchestration
from crane_sim.orchestration.children import environment
from crane_sim.plant import Plant

EXAMPLES = Path(__file__).parents[1] / "examples"
DURATION = 6.0  # s of simulated time


@contextmanager
def example(name: str, domain: int, python: str = sys.executable) -> Iterator[None]:
    """Run an example in a ROS domain while the block lasts, in the environment that users are told to give it."""
    command = [EXAMPLES / "in_domain", str(domain), python, EXAMPLES / name, str(domain)]
    with subprocess.Popen(command) as process:
        try:
            yield
        finally:
            process.terminate()


def run(domain: int, **options) -> dict:
    """Run the default scene without its controller; return the summary."""
    scene = load_scene("knuckle_setpoint", {"duration": DURATION})
    return orchestration.run(scene, record=None, controller=False, domain_id=domain, **options)


def check_arrival(summary: dict) -> None:
    """Check that the controller did what it is for."""
    assert "error" not in summary
    assert summary["steps"] == 600
    # Of 0.8 rad, 0.2 rad and 0.5 m hundredths are left after 6 s in lockstep, where the rope gives way to the payload
    # as it swings; in real time every hesitation of this machine comes on top.
    left = 0.02 if summary["mode"] == "lockstep" else 0.2
    assert all(abs(summary["final_error"][joint]) < left for joint in ("boom", "jib", "rope"))


def in_process() -> str:
    """Return the hash of the states that the examples' law leads through, found without any middleware."""
    scene = load_scene("knuckle_setpoint", {"duration": DURATION}).commanded()
    law = runpy.run_path(str(EXAMPLES / "my_law.py"))["effort"]
    plant = Plant(scene)
    for _ in range(scene.steps):
        plant.advance(law(scene.joint_names, plant.q, plant.v))
    return plant.summary()["state_sha256"]


def test_a_controller_of_plain_rclpy(domain_id: int) -> None:
    """A node that knows nothing of the simulator drives the crane in lockstep, and no bit is lost on the way."""
    with example("my_controller.py", domain_id):
        summary = run(domain_id)
    check_arrival(summary)
    assert summary["min_rope_tension"] > 0.0  # in real time the first command comes after a moment of none
    assert summary["commands"] == {"received": 600, "rejected": 0, "late": 0, "duplicate": 0}
    assert summary["state_sha256"] == in_process()


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


def test_the_environment_of_an_example_is_that_of_the_nodes(tmp_path: Path) -> None:
    """What examples/in_domain tells a process is what the simulator tells its own nodes."""
    shown = subprocess.run([EXAMPLES / "in_domain", "7", "env"], capture_output=True, text=True, check=True).stdout
    ours = dict(line.split("=", 1) for line in shown.splitlines() if "=" in line)
    wanted = environment(7, tmp_path)
    for name in wanted:
        if name.startswith(("RMW_", "ROS_DOMAIN", "ROS_AUTOMATIC", "FASTRTPS_", "FASTDDS_")):
            assert ours[name] == wanted[name], name
