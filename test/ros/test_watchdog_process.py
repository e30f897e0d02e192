"""The plant over ROS at the time-out of commands in real time, and at the end of a run without a controller."""

import os
from pathlib import Path

import pytest
from bench_graph import JOINTS, PERIOD, NodeProcess, graph, remote, wait_until
from process_helpers import started_program

from crane_sim import load_scene
from crane_sim.simulation.plant import SLOW

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


def test_a_timeout_brakes_and_a_command_releases(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """After the time-out the brakes act, with a warning in the diagnostics; the next command ends both."""
    options = ("mode:=realtime", "command_timeout:=0.3", "on_silence:=brake", "commanded:=true", "fifo_priority:=5")
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        with NodeProcess(PLANT, env, f"scene:={scene_file(tmp_path)}", *options) as plant:
            plant.await_event("ready")
            client.answers = EFFORT
            plant.send("go")
            wait_until(lambda: client.efforts[-1:] == [EFFORT])
            assert (os.sched_getscheduler(plant.process.pid) == os.SCHED_FIFO) == is_fifo_permitted()
            client.answers = None
            wait_until(lambda: any("no valid command for 0.3 s: the brakes act" in line for _, line in client.warnings))
            wait_until(lambda: client.efforts[-1] != EFFORT)
            client.answers = EFFORT
            client.send(client.states[-1], EFFORT)
            wait_until(lambda: client.warnings[-1][1] == "running" and client.efforts[-1] == EFFORT)


def test_brake_to_rest(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """At the request brake the plant brakes until the crane rests, and ends with the fault of the request."""
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        with NodeProcess(PLANT, env, f"scene:={scene_file(tmp_path)}", "commanded:=true") as plant:
            plant.await_event("ready")
            client.answers = EFFORT
            plant.send("go")
            wait_until(lambda: len(client.states) > 20)
            plant.send("brake controller: it was killed")
            summary = plant.await_event("done")["summary"]
            assert plant.await_event("done")["summary"]["error"] == "controller: it was killed"
            assert summary["steps"] > 20
            wait_until(lambda: client.states[-1] == (summary["steps"] + 1) * PERIOD, "the last state")
            plant.send("finish")
            assert plant.process.wait(60.0) == 1
    last = client.velocities[-1][: len(JOINTS)]
    assert max(map(abs, last)) < SLOW  # the plant's own limit of rest; the crane was at a hundred times that
