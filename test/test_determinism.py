"""One scene, one state_sha256: whatever processes, executors, distributions and load it is simulated with."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from itertools import product
from pathlib import Path
from typing import NamedTuple

import pytest

from crane_sim import load_scene, simulate
from crane_sim.orchestration.children import environment, reserved_domain

KILTED = os.environ.get("CRANE_SIM_KILTED_PYTHON", "")  # a Python with rclpy of Kilted, this package and what it needs
DURATION = 3.0  # s of simulated time
PATIENCE = 120.0  # s, only so that a failure ends: another interpreter may have everything to compile


class Setup(NamedTuple):
    """How a run is put together."""

    processes: int = 2  # 3: with a recorder
    executor: str = "events"
    plant: str = sys.executable
    controller: str = sys.executable

    def node(self, python: str, module: str, parameters: Mapping[str, object]) -> list[str]:
        """Return the command line of one node."""
        command = [python, "-m", module, "--ros-args", "-r", "__ns:=/knuckle", "-p", f"executor:={self.executor}"]
        return command + [part for name, value in parameters.items() for part in ("-p", f"{name}:={value}")]


def clean(python: str, domain: int, folder: Path) -> dict[str, str]:
    """Return the environment of a node; another interpreter must not find this one's ROS."""
    found = environment(domain, folder)
    if python != sys.executable:
        for name in ("LD_LIBRARY_PATH", "_ROS_WHEELS_BOOTSTRAP_COMPLETE", "AMENT_PREFIX_PATH"):
            found.pop(name, None)
    return found


def state_sha256(setup: Setup, folder: Path) -> str:
    """Run plant, controller and maybe recorder by hand, each as a process of its own; return the run's hash."""
    scene = folder / "scene.yaml"
    load_scene("knuckle_setpoint", {"duration": DURATION}).dump(scene)
    recorders = setup.processes - 2
    common = {"scene": scene, "expected_recorders": recorders}
    nodes = [(setup.controller, "crane_control.controller_node", common)]
    if recorders:
        nodes.append((sys.executable, "crane_sim.ros.recorder_node", {"scene": scene, "path": folder / "run.rrd"}))
    with reserved_domain() as domain:
        helpers = [
            subprocess.Popen(setup.node(python, module, parameters), env=clean(python, domain, folder))
            for python, module, parameters in nodes
        ]
        try:
            plant = subprocess.run(
                setup.node(setup.plant, "crane_sim.ros.plant_node", common),
                env=clean(setup.plant, domain, folder),
                stderr=subprocess.PIPE,
                text=True,
                timeout=PATIENCE,
            )
        finally:
            for helper in helpers:
                helper.terminate()
                helper.wait()
    assert plant.returncode == 0, plant.stderr
    summary = next(line for line in plant.stderr.splitlines() if "state_sha256" in line)
    return json.loads(summary[summary.index("{") :])["state_sha256"]


def expected() -> str:
    """Return the hash of the run in this process."""
    return simulate(load_scene("knuckle_setpoint", {"duration": DURATION})).summary["state_sha256"]


@contextmanager
def busy() -> Iterator[None]:
    """Keep both cores busy with something else."""
    loop = "while True: pass"
    loops = [subprocess.Popen([sys.executable, "-c", loop]) for _ in range(2)]
    try:
        yield
    finally:
        for process in loops:
            process.kill()
            process.wait()


@pytest.mark.parametrize(("processes", "executor"), [(2, "single"), (3, "events")])
def test_processes_and_executors_change_no_bit(processes: int, executor: str, tmp_path: Path) -> None:
    """Two processes or three, one executor or the other: the states are those of a run in one process."""
    assert state_sha256(Setup(processes, executor), tmp_path) == expected()


def test_a_loaded_machine_changes_no_bit(tmp_path: Path) -> None:
    """Two busy loops beside the nodes make the run slower, and nothing else."""
    with busy():
        assert state_sha256(Setup(), tmp_path) == expected()


@pytest.mark.skipif(not KILTED, reason="CRANE_SIM_KILTED_PYTHON names no Python with ROS 2 Kilted")
@pytest.mark.parametrize("executor", ["events", "single"])
@pytest.mark.parametrize("who", ["plant", "controller", "both"])
def test_another_distribution_changes_no_bit(who: str, executor: str, tmp_path: Path) -> None:
    """Plant or controller or both on ROS 2 Kilted: still the same states."""
    here, there = sys.executable, KILTED
    plant, controller = {"plant": (there, here), "controller": (here, there), "both": (there, there)}[who]
    assert state_sha256(Setup(2, executor, plant, controller), tmp_path) == expected()


@pytest.mark.slow
def test_fifty_runs_are_one(tmp_path: Path) -> None:
    """Fifty runs over every mixture of processes, executors and load have one hash."""
    setups = [Setup(processes, executor) for processes, executor in product((2, 3), ("events", "single"))]
    found = [state_sha256(setup, tmp_path) for setup in setups * 6]
    with busy():
        found += [state_sha256(setup, tmp_path) for setup in setups * 6 + setups[:2]]
    assert len(found) == 50
    assert set(found) == {expected()}
