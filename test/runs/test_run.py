"""Whole runs over ROS with real processes."""

import json
import os
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from process_helpers import children, next_line, nodes_of, run_to_completion, started_program, wait_exited

from crane_sim import load_scene, orchestration
from crane_sim.simulation.rollout import simulate

PERIOD = 10_000_000  # ns, of the default scene
SUPERVISOR = """
from crane_sim import load_scene, orchestration
scene = load_scene("knuckle_setpoint", {"duration": 1e5})
orchestration.run(scene, record=None, on_progress=lambda step, steps: print(step, flush=True))
"""


@contextmanager
def started_run(folder: Path) -> Iterator[tuple[subprocess.Popen[str], dict[str, int]]]:
    """Yield a process that is in the middle of an endless run, and its children."""
    env = os.environ | {"TMPDIR": str(folder)}  # a killed supervisor cannot remove its temporary files
    with started_program([sys.executable, "-c", SUPERVISOR], stdout=subprocess.PIPE, env=env) as process:
        while int(next_line(process)) < 10:
            pass
        yield process, nodes_of(process.pid)


def test_a_run_can_be_paused_stepped_and_reset(domain_id: int, ros_environment: dict[str, str], tmp_path: Path) -> None:
    """A paused run moves only by single steps, and after a reset it has the states of an uninterrupted one.

    Its summary lists the file from before the reset.
    """
    command = [sys.executable, Path(__file__).parents[1] / "programs" / "service_client.py"]
    with started_program(command, env=ros_environment, stdout=subprocess.PIPE) as client:
        scene, file = load_scene("knuckle_setpoint", {"duration": 10.0}), tmp_path / "run.rrd"
        summary = orchestration.run(scene, domain_id=domain_id, record=file, paused=True)
        results = json.loads(client.communicate(timeout=60.0)[0])
    assert results["step while playing"] == "the simulation is not paused"
    assert (results["pause"], results["mode"], results["steps"], results["reset"], results["go on"]) == (
        "ok",
        2,
        ["ok"] * 3,
        "ok",
        "ok",
    )
    assert results["stepped to"] - results["paused at"] == 3 * PERIOD
    assert results["reset to"] == PERIOD
    assert summary["before_reset"] == [str(tmp_path / "run.before_reset_1.rrd")]
    assert summary["state_sha256"] == simulate("knuckle_setpoint", duration=10.0).summary["state_sha256"]


def test_nodes_exit_when_their_supervisor_is_killed(tmp_path: Path) -> None:
    """Nodes detect that their supervisor has been killed, and exit; so does the fork server."""
    with started_run(tmp_path) as (process, nodes):
        pids = [*nodes.values(), *children(process.pid)]
        process.kill()
        for pid in pids:
            wait_exited(pid)


BAD_PARAMETERS = {
    "mode:=fast": "parameter mode is 'fast'",
    "rate:=0.0": "parameter rate is 0.0",
    "resends:=many": "parameter resends is 'many'",
    "control_fd:=none": "parameter control_fd is 'none'",
    "on_silence:=wait": "parameter on_silence is 'wait'",
    "scene:=knukle_setpoint": "knukle_setpoint",
    "sceen:=knuckle_setpoint": "unknown parameter sceen",
    "mode:=realtime beside:=other": "parameter beside is 'other'; only a crane in lockstep can have it",
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
