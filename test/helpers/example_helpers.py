"""The examples as processes of their own against a real plant, and checks of their runs."""

import runpy
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

from process_helpers import started_program
from run_helpers import check_one_command_per_state

from crane_sim import load_scene, orchestration
from crane_sim.simulation.plant import Plant

EXAMPLES = Path(__file__).parents[2] / "examples"
DURATION = 6.0  # s of simulated time
GRACE = 30.0  # s from SIGTERM to SIGKILL of an example


@contextmanager
def started_example(name: str, domain: int, python: str = sys.executable) -> Iterator[None]:
    """Run an example in a ROS domain while the block lasts, in the README's environment.

    At its end it gets SIGTERM.
    """
    command = [EXAMPLES / "in_domain", str(domain), python, EXAMPLES / name, str(domain)]
    with started_program(command, grace=GRACE):
        yield


def run(domain: int, **options) -> dict:
    """Run the default scene without its controller; return the summary."""
    scene = load_scene("knuckle_setpoint", {"duration": DURATION})
    return orchestration.run(scene, record=None, controller=False, domain_id=domain, **options)


def check_arrival(summary: Mapping) -> None:
    """Check that the run is complete and the crane is at its target."""
    assert "error" not in summary
    assert summary["steps"] == 600
    # Of 0.8 rad, 0.2 rad and 0.5 m hundredths remain after 6 s in lockstep, where the rope yields
    # to the payload as it swings; in real time every stall of this machine comes on top.
    largest = 0.02 if summary["mode"] == "lockstep" else 0.2
    assert all(abs(summary["final_error"][joint]) < largest for joint in ("boom", "jib", "rope"))


def check_lockstep(summary: dict) -> None:
    """Check the same in lockstep: all states are answered, bit for bit those of one process."""
    check_arrival(summary)
    check_one_command_per_state(summary, 600)
    assert summary["state_sha256"] == hash_in_process()


def hash_in_process() -> str:
    """Return the hash of the states under the examples' law, computed without middleware."""
    scene = load_scene("knuckle_setpoint", {"duration": DURATION}).with_external_commands()
    law = runpy.run_path(str(EXAMPLES / "my_law.py"))["effort"]
    plant = Plant(scene)
    for _ in range(scene.steps):
        plant.advance(law(scene.joint_names, plant.q, plant.v))
    return plant.summary()["state_sha256"]
