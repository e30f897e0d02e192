"""One scene, one state_sha256, whatever processes, executors and load: `crane soak determinism`."""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, nullcontext
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

from crane_bench.soak.metrics import Metric, equal, quantiles
from crane_sim import load_scene
from crane_sim.orchestration.ros_environment import node_environment, reserve_domain
from crane_sim.process_signals import end_process, set_parent_death_signal
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.rollout import simulate

KILTED = os.environ.get("CRANE_SIM_KILTED_PYTHON", "")
"""A Python with rclpy of ROS 2 Kilted, this package and what it needs; empty: there is none."""
SCENE, DURATION = "knuckle_setpoint", 6.0  # s of simulated time, 600 steps
# s, only so that a failure ends: another interpreter may have everything to compile
_TIMEOUT = 120.0
_END_TIMEOUT = 10.0  # s after SIGTERM; a recorder closes its file
_OF_THIS_ONE = (
    "LD_LIBRARY_PATH",
    "_ROS_WHEELS_BOOTSTRAP_COMPLETE",
    "AMENT_PREFIX_PATH",
    "PYTHONPATH",
)


class Setup(NamedTuple):
    """Processes, executor and interpreters of a run."""

    processes: int = 2  # 3: with a recorder
    executor: str = "events"
    plant: str = sys.executable  # the interpreters of two of them
    controller: str = sys.executable

    def command(self, python: str, module: str, parameters: Mapping[str, object]) -> list[str]:
        """Return the command line of one node."""
        command = [
            python,
            "-m",
            module,
            "--ros-args",
            "-r",
            "__ns:=/knuckle",
            "-p",
            f"executor:={self.executor}",
        ]
        return command + [
            part for name, value in parameters.items() for part in ("-p", f"{name}:={value}")
        ]


def setups(kilted: str = KILTED) -> list[Setup]:
    """Return all combinations of processes and executors, and of another interpreter if any."""
    executors = ("events", "single")
    combinations = [
        Setup(processes, executor) for processes, executor in product((2, 3), executors)
    ]
    if kilted:
        pairs = ((kilted, sys.executable), (sys.executable, kilted), (kilted, kilted))
        combinations += [Setup(2, executor, *pair) for pair, executor in product(pairs, executors)]
    return combinations


@contextmanager
def busy(loops: int) -> Iterator[None]:
    """Keep `loops` cores busy."""
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", "while True: pass"], preexec_fn=set_parent_death_signal()
        )
        for _ in range(loops)
    ]
    try:
        yield
    finally:
        for process in processes:
            process.kill()
            process.wait()


def determinism_scene(duration: float = DURATION) -> Scene:
    """Return the scene that is run."""
    return load_scene(SCENE, {"duration": duration})


def state_sha256(setup: Setup, scene: Scene) -> str:
    """Run plant, controller and recorder, if any, without a supervisor; return the run's hash.

    Each is a process of its own.

    Raises:
        RuntimeError: the run failed; the plant's message.
    """
    with tempfile.TemporaryDirectory(prefix="crane_sim-") as name, reserve_domain() as domain:
        folder, file, recorders = Path(name), Path(name, "scene.yaml"), setup.processes - 2
        scene.dump(file)
        common = {"scene": file, "expected_recorders": recorders}
        recording: dict[str, Any] = {"scene": file, "path": folder / "run.rrd"}
        nodes = [(setup.controller, "crane_control.nodes.controller_node", common)]
        nodes += [(sys.executable, "crane_sim.ros.recorder_node", recording)] * recorders
        helpers = [
            subprocess.Popen(
                setup.command(python, module, parameters),
                env=clean_environment(python, domain, folder),
                preexec_fn=set_parent_death_signal(),
            )
            for python, module, parameters in nodes
        ]
        try:
            plant = setup.command(setup.plant, "crane_sim.ros.plant_node", common)
            return _plant_sha256(plant, clean_environment(setup.plant, domain, folder))
        finally:
            for helper in helpers:
                end_process(helper, _END_TIMEOUT)


def _plant_sha256(command: list[str], env: dict[str, str]) -> str:
    try:
        pipes: dict[str, Any] = {"stderr": subprocess.PIPE, "text": True}
        plant = subprocess.run(
            command,
            env=env,
            timeout=_TIMEOUT,
            check=False,
            preexec_fn=set_parent_death_signal(),
            **pipes,
        )
    except subprocess.TimeoutExpired:
        raise RuntimeError(f"plant: it did not end within {_TIMEOUT:g} s") from None
    hash_line = next((line for line in plant.stderr.splitlines() if "state_sha256" in line), "")
    if plant.returncode or not hash_line:
        raise RuntimeError(f"plant: exit code {plant.returncode}: {plant.stderr.strip()}")
    return json.loads(hash_line[hash_line.index("{") :])["state_sha256"]


def clean_environment(python: str, domain: int, folder: Path) -> dict[str, str]:
    """Return the environment of a node; without this one's ROS for another interpreter."""
    environment = node_environment(domain, folder)
    omitted = () if python == sys.executable else _OF_THIS_ONE
    return {key: value for key, value in environment.items() if key not in omitted}


def soak_determinism(count: int = 50) -> tuple[list[Metric], dict[str, Any]]:
    """Do `count` runs, every other one beside a busy process; return (metrics, data)."""
    scene, combinations = determinism_scene(), setups()
    planned = [(combinations[i // 2 % len(combinations)], i % 2) for i in range(count)]
    hashes, took = [], []
    for setup, loops in planned:
        start = time.perf_counter()
        with busy(loops) if loops else nullcontext():
            hashes.append(state_sha256(setup, scene))
        took.append(time.perf_counter() - start)
    alone = simulate(scene).summary["state_sha256"]
    metrics = [
        Metric("runs", count),
        Metric("mixtures of processes, executors, distributions and load", len(set(planned))),
        Metric("runs beside a busy process", sum(loops for _, loops in planned)),
        Metric(
            "runs with a node of another ROS distribution",
            sum(KILTED in setup for setup, _ in planned),
        ),
        equal("different state_sha256", len(set(hashes)), 1),
        equal(
            "runs unlike the one in a single process", sum(hash_ != alone for hash_ in hashes), 0
        ),
        Metric("a run with the start of its nodes, median", quantiles(took)["p50"], "s"),
    ]
    return metrics, {"state_sha256": sorted(set(hashes)), "took_s": took}
