"""Whole runs over ROS with real processes."""

import os
import subprocess
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from pathlib import Path

import pytest
from bench_graph import graph, remote
from process_helpers import (
    children,
    next_line,
    nodes_of,
    run_to_completion,
    started_program,
    wait_exited,
    wait_until,
)

from crane_sim import load_scene, orchestration
from crane_sim.recording.rerun.reader import read_curves
from crane_sim.simulation.rollout import simulate

SUPERVISOR = """
from crane_sim import load_scene, orchestration
scene = load_scene("knuckle_setpoint", {"duration": 1e5})
orchestration.run(scene, record=None, on_progress=lambda step, steps: print(step, flush=True))
"""


@contextmanager
def started_run(folder: Path) -> Iterator[tuple[subprocess.Popen[str], dict[str, int]]]:
    """Yield a process that is in the middle of an endless run, and its children."""
    # a killed supervisor cannot remove its temporary files
    env = os.environ | {"TMPDIR": str(folder)}
    with started_program(
        [sys.executable, "-c", SUPERVISOR], stdout=subprocess.PIPE, env=env
    ) as process:
        while int(next_line(process)) < 10:
            pass
        yield process, nodes_of(process.pid)


def test_a_run_that_is_reset_is_recorded_anew(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """After single steps and a reset a run has the states of an uninterrupted one.

    A file has what was before the reset.
    """
    scene, file = load_scene("knuckle_setpoint", {"duration": 10.0}), tmp_path / "run.rrd"
    with (
        graph(tmp_path, monkeypatch) as (domain, _),
        remote(domain) as client,
        ThreadPoolExecutor() as pool,
    ):
        client.node.destroy_publisher(client.commands)
        running = pool.submit(orchestration.run, scene, domain_id=domain, record=file, paused=True)
        wait_until(
            lambda: running.done() or (client.modes[-1:] == [2] and bool(client.states)),
            "a run that is paused",
        )
        client.take_steps(3)
        assert client.reset() == "ok" and client.pause(False) == "ok"
        summary = running.result()
    assert summary["before_reset"] == [str(tmp_path / "run.before_reset_1.rrd")]
    assert len(read_curves(tmp_path / "run.before_reset_1.rrd", "plots/q").step) == 3
    assert summary["recorded_steps"] == summary["steps"] == scene.steps
    assert summary["state_sha256"] == simulate(scene).summary["state_sha256"]


def test_nodes_exit_when_their_supervisor_is_killed(tmp_path: Path) -> None:
    """Nodes detect that their supervisor has been killed, and exit; so does the fork server."""
    with started_run(tmp_path) as (process, nodes):
        pids = [*nodes.values(), *children(process.pid)]
        process.kill()
        for pid in pids:
            wait_exited(pid)


BAD_PARAMETERS = {
    "resends:=many": "parameter resends is 'many'",
    "control_fd:=none": "parameter control_fd is 'none'",
    "scene:=knukle_setpoint": "knukle_setpoint",
    "sceen:=knuckle_setpoint": "unknown parameter sceen",
    "mode:=realtime beside:=other": "parameter beside is 'other'; only a crane in lockstep can "
    "have it",
}
FORKING = """
import os, sys
from crane_sim.ros import plant_node
for setting in sys.argv[1:]:
    if not os.fork():
        words = [word for each in setting.split() for word in ("-p", each)]
        sys.argv = ["plant", "--ros-args", *words]
        sys.exit(plant_node.main())
    print(os.waitstatus_to_exitcode(os.wait()[1]), flush=True)
"""


def test_bad_parameters_are_refused(ros_environment: dict[str, str]) -> None:
    """A node with an invalid parameter exits with code 2 and one line that names it."""
    ended = run_to_completion([sys.executable, "-c", FORKING, *BAD_PARAMETERS], env=ros_environment)
    assert ended.stdout.split() == ["2"] * len(BAD_PARAMETERS)
    for line, message in zip(ended.stderr.splitlines(), BAD_PARAMETERS.values(), strict=True):
        assert message in line
