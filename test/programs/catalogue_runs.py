"""Runs catalogue scenes over ROS, recorded, and by `simulate`; prints one JSON object each.

`catalogue_runs.py FOLDER SCENE ...`, with CRANE_SIM_INTERPRETED=1: compiling the equations of all
kinds of scenes would take most of an hour, as plain Python they take seconds. The fork server of
each run is a fork of this process, which has imported the modules of the nodes.
"""

import json
import os
import socket
import sys
import traceback
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import Any

from crane_sim import load_scene, orchestration
from crane_sim.orchestration import process_group
from crane_sim.orchestration.fork_server import ForkServer
from crane_sim.orchestration.process import ForkServerClient
from crane_sim.process_signals import ignore_interrupts
from crane_sim.simulation.rollout import simulate

DURATION = 0.1  # s
# s, of many small steps each
BRIEF = {"overhead_heavy": 0.05, "overhead_long_cable": 0.02, "overhead_steel": 0.02}
MODULES = (
    "crane_sim.ros.plant_node",
    "crane_control.nodes.controller_node",
    "crane_control.nodes.tracker_node",
    "crane_sim.ros.recorder_node",
    "crane_sim.recording.layout",
)


class OwnForkServer(ForkServerClient):
    """A fork server that is a fork of this process."""

    def __init__(self, env: Mapping[str, str]) -> None:
        """Fork it, with this environment."""
        self._channel, server_end = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._server = os.fork()
        if not self._server:
            self._channel.close()
            _serve(server_end, env)
        server_end.close()

    @property
    def pid(self) -> int:
        """Process id of the server."""
        return self._server

    def close(self) -> None:
        """Have the server reap the nodes that have exited, and end."""
        self._channel.close()
        os.waitpid(self._server, 0)


def _serve(channel: socket.socket, env: Mapping[str, str]) -> None:
    """Be the fork server until its channel is closed."""
    try:
        os.setsid()
        ignore_interrupts()
        os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
        os.dup2(2, 1)
        os.environ.clear()
        os.environ.update(env)
        ForkServer(channel).serve()
    except BaseException:  # nothing may return into the loop over scenes
        traceback.print_exc()
    os._exit(0)


def run_scene(name: str, folder: Path) -> dict[str, Any]:
    """Run a scene of the catalogue or a file; return the summary's entries that tests check."""
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
    process_group.ForkServerClient = OwnForkServer
    for name in sys.argv[2:]:
        try:
            result = run_scene(name, Path(sys.argv[1]))
        except Exception:
            result = {"scene": name, "error": traceback.format_exc()}
        print(json.dumps(result), flush=True)


if __name__ == "__main__":
    main()
