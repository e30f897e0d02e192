"""Runs scenes of the catalogue over ROS, recorded, and by `simulate`, and prints one JSON object a scene.

`catalogue_runs.py FOLDER SCENE ...`, with CRANE_SIM_INTERPRETED=1: compiling the equations of all kinds of scenes would
take most of an hour, as plain Python they take seconds. Nodes are forked from this process, which has imported their
modules: processes of their own, each with its own ROS, at a fraction of the cost of programs.
"""

import json
import os
import subprocess
import sys
import traceback
from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path
from select import select
from typing import Any

from crane_sim import load_scene, orchestration
from crane_sim.orchestration import process_group
from crane_sim.orchestration.fork_server import run_node
from crane_sim.simulation.rollout import simulate

DURATION = 0.1  # s
BRIEF = {"overhead_heavy": 0.05, "overhead_long_cable": 0.02, "overhead_steel": 0.02}  # s, of many small steps each
MODULES = (
    "crane_sim.ros.plant_node",
    "crane_control.nodes.controller_node",
    "crane_control.nodes.tracker_node",
    "crane_sim.ros.recorder_node",
    "crane_sim.recording.layout",
)


class ForkedNode:
    """The process of a node."""

    def __init__(self, pid: int) -> None:
        """Open a handle of the process."""
        self.pid, self._handle = pid, os.pidfd_open(pid)
        self._code: int | None = None

    def wait(self, timeout: float | None = None) -> int | None:
        """Return the exit code; raises TimeoutExpired when it has not ended within `timeout` seconds."""
        if self._code is None:
            if not select([self._handle], [], [], timeout)[0]:
                raise subprocess.TimeoutExpired(f"process {self.pid}", timeout or 0.0)
            self._code = os.waitstatus_to_exitcode(os.waitpid(self.pid, 0)[1])
            os.close(self._handle)
        return self._code

    def send_signal(self, number: int) -> None:
        """Send a signal to a process that may have ended."""
        if self._code is None:
            os.kill(self.pid, number)


class OwnForks:
    """A fork server that is this process itself."""

    def __init__(self, env: Mapping[str, str]) -> None:
        """Fork nodes with this environment."""
        self._env, self.pid = env, os.getpid()

    def spawn(self, module: str, arguments: Sequence[str], control: int, report: int) -> ForkedNode:
        """Fork a node with its ends of two pipes."""
        if pid := os.fork():
            return ForkedNode(pid)
        try:
            _make_environment_of_node(self._env, (control, report))
            os._exit(run_node([module, *arguments], control, report))
        except BaseException:  # nothing may return into the loop over scenes
            traceback.print_exc()
            os._exit(1)

    def close(self) -> None:
        """Do nothing: nodes are reaped where they are waited for."""


def _make_environment_of_node(env: Mapping[str, str], fds: Sequence[int]) -> None:
    """Give this process the variables and the files of a node that the fork server has started."""
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)
    for name in os.listdir("/proc/self/fd"):  # pipe ends of other nodes would hide their exit
        if int(name) > 2 and int(name) not in fds and "pipe:" in _target(name):
            os.close(int(name))
    os.environ.clear()
    os.environ.update(env)


def _target(fd: str) -> str:
    try:
        return os.readlink(f"/proc/self/fd/{fd}")
    except OSError:
        return ""


def run_scene(name: str, folder: Path) -> dict[str, Any]:
    """Run a scene of the catalogue, or of a file; return the entries of its summary that the tests check."""
    scene, stem = load_scene(name, {"duration": BRIEF.get(name, DURATION)}), Path(name).stem
    summary = orchestration.run(scene, record=folder / f"{stem}.rrd", mcap=folder / f"{stem}.mcap")
    keys = ("error", "steps", "recorded_steps", "lost_steps", "recording", "state_sha256")
    simulated = simulate(scene).summary["state_sha256"]
    entries = {"scene": name, "due": scene.steps, "simulated_sha256": simulated}
    return entries | {key: summary[key] for key in keys if key in summary}


def main() -> None:
    """Run the program."""
    for module in MODULES:
        import_module(module)
    process_group.ForkServerClient = OwnForks
    for name in sys.argv[2:]:
        try:
            result = run_scene(name, Path(sys.argv[1]))
        except Exception:
            result = {"scene": name, "error": traceback.format_exc()}
        print(json.dumps(result), flush=True)


if __name__ == "__main__":
    main()
