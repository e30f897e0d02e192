"""Several cranes at once: on one clock in one domain, or side by side in domains of their own."""

import json
import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from bench_graph import graph, remote
from command_line import CRANE
from frame_listener import FrameListener
from graph_messages import vector
from process_helpers import has_exited, next_line, run_to_completion, started_program, wait_until
from run_helpers import check_one_command_per_state

from crane_sim import load_scene, simulate

PROGRAMS = Path(__file__).parents[1] / "programs"
CRANES = {"harbour": "knuckle_setpoint", "hall": "overhead_energy"}  # those of the example


@pytest.mark.long
def test_two_cranes_on_one_clock(ros_environment: dict[str, str]) -> None:
    """Two cranes step at most a period apart, /clock has one publisher, and each moves as alone."""
    monitor = [sys.executable, PROGRAMS / "clock_monitor.py", *CRANES]
    example = [sys.executable, Path(__file__).parents[2] / "examples" / "two_cranes.py"]
    with started_program(monitor, env=ros_environment, stdout=subprocess.PIPE) as monitoring:
        assert next_line(monitoring) == "subscribed\n"
        run = run_to_completion(example, env=ros_environment)
        counters = json.loads(monitoring.communicate(timeout=60.0)[0])
    summaries = json.loads(run.stdout)
    for crane, scene in CRANES.items():
        assert summaries[crane]["state_sha256"] == simulate(scene).summary["state_sha256"]
    assert counters["sent_early"] == 0
    # All states of the shorter run, the first one too, but for those before the monitor was
    # matched.
    assert counters["common_states"] > 0.9 * load_scene("overhead_energy").steps
    assert counters["clock_publishers"] == 1 and counters["clock_messages"] > 0


def test_two_cranes_end_together(ros_environment: dict[str, str]) -> None:
    """When one plant is killed, the example ends all nodes, names the crane, and returns 1."""
    example = [sys.executable, Path(__file__).parents[2] / "examples" / "two_cranes.py"]
    with started_program(example, env=ros_environment, stdout=subprocess.PIPE) as run:
        children = Path(f"/proc/{run.pid}/task/{run.pid}/children")
        wait_until(
            lambda: has_exited(run.pid) or len(children.read_text().split()) == 2 * len(CRANES),
            "all nodes",
        )
        os.kill(int(children.read_text().split()[0]), signal.SIGKILL)
        summaries = json.loads(run.communicate(timeout=120.0)[0])
    assert run.returncode == 1
    assert set(summaries) == set(CRANES) and summaries["harbour"]["error"]


def run_side_by_side(*runs: dict) -> list[dict]:
    """Run `crane run` several times at once; return the summaries."""
    script = "import sys; from crane_sim.cli import main; sys.exit(main())"

    def run(options: dict) -> dict:
        command = [sys.executable, "-c", script, "run", options["scene"], "--no-record", "--json"]
        command += ["--duration", str(options["duration"])]
        return json.loads(run_to_completion(command).stdout)

    with ThreadPoolExecutor() as pool:
        return list(pool.map(run, runs))


SIDES = ("west", "east")


@pytest.mark.skipif(
    find_spec("tf2_msgs") is None, reason="tf2_msgs is absent (./crane interfaces builds it)"
)
def test_two_cranes_of_a_kind_have_one_tree_of_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two `crane run` of one scene in one domain, on one clock: no frame is both cranes'.

    Each payload is in its frame.

    Each is the run of `simulate`, and no other node publishes /clock than the first one.
    """
    changes = {"duration": 1.0}
    with graph(tmp_path, monkeypatch) as (domain, env), remote(domain) as client:
        listeners = {side: FrameListener(client.node, side) for side in SIDES}
        with ThreadPoolExecutor() as pool:
            running = {side: pool.submit(run_beside, side, domain, env, changes) for side in SIDES}
            clocks = 0
            while not all(run.done() for run in running.values()):
                clocks = max(clocks, client.node.count_publishers("/clock"))
                time.sleep(0.01)
        expected = simulate(load_scene("knuckle_setpoint", changes)).summary["state_sha256"]
        assert [run.result()["state_sha256"] for run in running.values()] == [
            expected
        ] * 2 and clocks == 1
        for side, listener in listeners.items():
            check_frames(side, listener)


def run_beside(
    side: str, domain: int, env: dict[str, str], changes: dict[str, float]
) -> dict[str, Any]:
    """Return the summary of `crane run` of one of two cranes."""
    (other,) = set(SIDES) - {side}
    command = [
        CRANE,
        "run",
        "knuckle_setpoint",
        "--no-record",
        "--json",
        "--domain-id",
        str(domain),
    ]
    command += ["--namespace", side, "--frame-prefix", f"{side}/", "--beside", other]
    command += ["--no-clock"] * (side == SIDES[1]) + ["--duration", str(changes["duration"])]
    return json.loads(run_to_completion(command, env=env).stdout)


def check_frames(side: str, listener: FrameListener) -> None:
    """Check that all frames are in one tree, and that a crane's payload is where its frame is."""
    assert not listener.contested
    # late messages may still come
    assert {name.partition("/")[0] for name in list(listener.fixed)} == set(SIDES)
    own = [
        stamp for stamp, frames in list(listener.moving.items()) if f"{side}/payload_link" in frames
    ]
    common = listener.poses.keys() & own
    assert common  # some of 50: poses are best effort, and a busy machine drops most
    for stamp in common:
        position = vector(listener.poses[stamp].pose.position)
        # rounding
        assert listener.pose(stamp, f"{side}/payload_link")[0] == pytest.approx(position, abs=1e-12)


@pytest.mark.long
def test_two_runs_side_by_side_are_independent() -> None:
    """Two `crane run` of a scene at once are exact, in domains and with commands of their own."""
    runs = [{"scene": "knuckle_setpoint", "duration": duration} for duration in (20.0, 18.0)]
    for options, summary in zip(runs, run_side_by_side(*runs), strict=True):
        scene = load_scene("knuckle_setpoint", {"duration": options["duration"]})
        assert "error" not in summary
        check_one_command_per_state(summary, scene.steps)
        assert summary["state_sha256"] == simulate(scene).summary["state_sha256"]


def test_a_second_plant_in_a_namespace_is_refused(
    ros_environment: dict[str, str], tmp_path: Path
) -> None:
    """A plant that finds another's joint states in its namespace ends with a line.

    The other one goes on.
    """
    command = [
        sys.executable,
        "-m",
        "crane_sim.ros.plant_node",
        "--ros-args",
        "-r",
        "__ns:=/knuckle",
    ]
    command += ["-p", "mode:=realtime", "-p", "commanded:=true", "-p", "expected_controllers:=0"]
    scene = tmp_path / "scene.yaml"  # longer than the test takes on any machine
    load_scene("knuckle_setpoint", {"duration": 600.0}).dump(scene)
    command += ["-p", f"scene:={scene}"]
    report, report_fd = os.pipe()
    with os.fdopen(report) as events, os.fdopen(report_fd, "w") as end:
        first = [*command, "-p", f"report_fd:={report_fd}"]
        with started_program(
            first, env=ros_environment, stderr=subprocess.DEVNULL, pass_fds=[report_fd]
        ) as plant:
            end.close()
            assert json.loads(next(events))["event"] == "ready"
            refused = run_to_completion(command, env=ros_environment)
            assert plant.poll() is None
    assert refused.returncode == 1
    assert (
        "/knuckle/joint_states has 2 publishers: /knuckle/plant, /knuckle/plant" in refused.stderr
    )
