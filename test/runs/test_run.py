"""Whole runs over ROS with real processes."""

import json
import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from process_helpers import children, has_exited, next_line, nodes_of, run_to_completion, started_program, wait_exited
from run_helpers import check_one_command_per_state

from crane_sim import load_scene, orchestration
from crane_sim.simulation.plant import Plant
from crane_sim.simulation.rollout import simulate

ENDLESS = {"duration": 1e5}  # s of simulated time: far more than a test waits for
PERIOD = 10_000_000  # ns, of the default scene
SUPERVISOR = """
import json, sys
from crane_sim import load_scene, orchestration
from crane_sim.orchestration import process_group, shutdown, supervisor
process_group._SHUTDOWN_TIMEOUT = 60.0  # as `patient_shutdown` in conftest.py
supervisor._SHUTDOWN_SUMMARY_TIMEOUT = shutdown._SHUTDOWN_SUMMARY_TIMEOUT = 60.0
scene = load_scene("knuckle_setpoint", {overrides})
print(json.dumps(orchestration.run(scene, record=None, on_progress=lambda step, steps: print(step, flush=True))))
"""


def run(overrides: dict | None = None, record: Path | None = None, **options) -> dict:
    """Run 2 s of the default scene, by default without a recorder."""
    scene = load_scene("knuckle_setpoint", {"duration": 2.0} | (overrides or {}))
    return orchestration.run(scene, record=record, **options)


@contextmanager
def started_run(folder: Path) -> Iterator[tuple[subprocess.Popen[str], dict[str, int]]]:
    """Yield a process that is in the middle of an endless run, and its children."""
    script = SUPERVISOR.replace("{overrides}", repr(ENDLESS))
    env = os.environ | {"TMPDIR": str(folder)}  # a killed supervisor cannot remove its temporary files
    with started_program([sys.executable, "-c", script], stdout=subprocess.PIPE, env=env) as process:
        while int(next_line(process)) < 10:
            pass
        yield process, nodes_of(process.pid)


def summary_of(process: subprocess.Popen[str]) -> dict:
    """Return the summary that the supervisor prints at its end."""
    return json.loads(process.communicate()[0].splitlines()[-1])


def test_lockstep_changes_no_bit() -> None:
    """A run over ROS passes through exactly the states of plant and law in one process."""
    scene = load_scene("knuckle_setpoint", {"duration": 2.0})
    plant, law = Plant(scene), scene.law
    assert law is not None
    for _ in range(scene.steps):
        plant.advance(law(plant.t, plant.q, plant.v))
    summary = run()
    assert summary["state_sha256"] == plant.summary()["state_sha256"]
    assert summary["steps"] == scene.steps
    check_one_command_per_state(summary, scene.steps)
    assert "error" not in summary


def test_only_valid_commands_move_the_crane(domain_id: int, ros_environment: dict[str, str]) -> None:
    """A controller's invalid commands are counted and move nothing; a state that it does not answer is sent again."""
    scene = load_scene("knuckle_setpoint", {"duration": 0.5})
    plant = Plant(scene)
    for _ in range(scene.steps):
        plant.advance((0.0,) * 4)
    controller = [sys.executable, Path(__file__).parents[1] / "programs" / "faulty_controller.py"]
    with started_program(controller, env=ros_environment):
        summary = run({"duration": 0.5}, controller=False, domain_id=domain_id)
    assert "error" not in summary
    assert summary["commands"] == {"received": scene.steps + 5, "rejected": 3, "late": 1, "duplicate": 1}
    assert summary["state_sha256"] == plant.summary()["state_sha256"]


def test_a_run_can_be_paused_stepped_and_reset(domain_id: int, ros_environment: dict[str, str], tmp_path: Path) -> None:
    """A paused run moves only by single steps, and after a reset it has the states of an uninterrupted one.

    Its summary lists the file from before the reset.
    """
    command = [sys.executable, Path(__file__).parents[1] / "programs" / "service_client.py"]
    with started_program(command, env=ros_environment, stdout=subprocess.PIPE) as client:
        summary = run({"duration": 50.0}, domain_id=domain_id, record=tmp_path / "run.rrd", paused=True)
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
    assert summary["state_sha256"] == simulate("knuckle_setpoint", duration=50.0).summary["state_sha256"]


def test_open_loop_needs_no_controller() -> None:
    """A scene without a control law runs with the plant alone."""
    document = load_scene("knuckle_setpoint").to_dict() | {"duration": 10.0}
    del document["control"]
    summary = orchestration.run(load_scene(document), record=None)
    assert "error" not in summary
    assert (summary["steps"], summary["commands"]["received"]) == (1000, 0)


def test_realtime_takes_every_step() -> None:
    """In real time the run takes as many steps as in lockstep, on the wall clock and not on the commands."""
    summary = run(mode="realtime", rate=4.0)
    assert "error" not in summary
    assert summary["steps"] == 200
    assert summary["real_time_factor"] < 4.01  # steps wait for their deadlines; a late end only lowers the factor


@pytest.mark.long(cases=["controller"])  # a killed controller ends a run in test_node_failures.py
@pytest.mark.parametrize("victim", ["plant", "controller"])
def test_a_killed_node_ends_the_run(victim: str, tmp_path: Path) -> None:
    """When a node is killed the others exit, the error names it, and the summary has the number of steps."""
    with started_run(tmp_path) as (process, nodes):
        os.kill(nodes[victim], signal.SIGKILL)
        summary = summary_of(process)
    assert summary["error"] == f"{victim}: it was killed by SIGKILL"
    assert summary["steps"] > 0
    assert all(map(has_exited, nodes.values()))


@pytest.mark.long(cases=["15"])  # `crane run` gets SIGTERM in test_signals.py
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_reports(number: signal.Signals, tmp_path: Path) -> None:
    """SIGINT and SIGTERM end a run early, with the summary of what was done and no process left."""
    with started_run(tmp_path) as (process, nodes):
        process.send_signal(number)
        summary = summary_of(process)
    assert summary["error"] == "interrupted"
    assert summary["commands"]["received"] >= summary["steps"] > 0  # more where a state was sent and answered again
    assert all(map(has_exited, nodes.values()))


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
}
FORKING = """
import os, sys
from crane_sim.ros import plant_node
for setting in sys.argv[1:]:
    if not os.fork():
        sys.argv = ["plant", "--ros-args", "-p", setting]
        sys.exit(plant_node.main())
    print(os.waitstatus_to_exitcode(os.wait()[1]), flush=True)
"""


def test_bad_parameters_are_refused(ros_environment: dict[str, str]) -> None:
    """A node with an invalid parameter exits with code 2 and one line that names it."""
    ended = run_to_completion([sys.executable, "-c", FORKING, *BAD_PARAMETERS], env=ros_environment)
    assert ended.stdout.split() == ["2"] * len(BAD_PARAMETERS)
    for line, message in zip(ended.stderr.splitlines(), BAD_PARAMETERS.values(), strict=True):
        assert message in line


@pytest.mark.slow
def test_runs_have_one_hash() -> None:
    """Ten runs over ROS, one after the other, and the run in one process end with one and the same hash."""
    hashes = {run({"duration": 0.5})["state_sha256"] for _ in range(10)}
    assert hashes == {simulate("knuckle_setpoint", duration=0.5).summary["state_sha256"]}
