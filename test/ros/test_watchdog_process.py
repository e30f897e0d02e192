"""The plant over ROS: the time-out of commands in real time, and the end without a controller."""

import os
from pathlib import Path

import pytest
from bench_graph import NodeProcess, graph, remote, wait_until
from process_helpers import started_program

from crane_sim import load_scene

PLANT = "crane_sim.ros.plant_node"
EFFORT = [200.0, 2000.0, 500.0, 0.0]


def scene_file(folder: Path) -> str:
    """Return a scene file whose run does not end by itself."""
    file = folder / "endless.yaml"
    load_scene("knuckle_setpoint", {"duration": 1e5}).dump(file)
    return str(file)


def is_fifo_permitted() -> bool:
    """Return whether this user may have processes under SCHED_FIFO."""
    with started_program(["sleep", "10"]) as other:
        try:
            os.sched_setscheduler(other.pid, os.SCHED_FIFO, os.sched_param(5))
        except OSError:
            return False
    return True


def test_a_timeout_brakes_and_a_command_releases(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After the time-out the brakes act, with a warning; the next command ends both.

    The warning is in the diagnostics.
    """
    options = (
        "mode:=realtime",
        "command_timeout:=0.3",
        "on_silence:=brake",
        "commanded:=true",
        "fifo_priority:=5",
    )
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        with NodeProcess(PLANT, env, f"scene:={scene_file(tmp_path)}", *options) as plant:
            plant.await_event("ready")
            client.answers = EFFORT
            plant.send("go")
            wait_until(lambda: client.efforts[-1:] == [EFFORT])
            assert (
                os.sched_getscheduler(plant.process.pid) == os.SCHED_FIFO
            ) == is_fifo_permitted()
            client.answers = None
            wait_until(
                lambda: any(
                    "no valid command for 0.3 s: the brakes act" in line
                    for _, line in client.warnings
                )
            )
            wait_until(lambda: client.efforts[-1] != EFFORT)
            client.answers = EFFORT
            client.send(client.states[-1], EFFORT)
            wait_until(lambda: client.warnings[-1][1] == "running" and client.efforts[-1] == EFFORT)
