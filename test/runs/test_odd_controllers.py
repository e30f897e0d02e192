"""Controllers with an unfit quality of service or stamps: a line says which, and what helps."""

import subprocess
import sys
from pathlib import Path

from process_helpers import started_program

from crane_sim import load_scene, orchestration

PROGRAM = Path(__file__).parents[1] / "programs" / "odd_controller.py"


def test_a_publisher_with_best_effort_is_named(
    domain_id: int, ros_environment: dict[str, str]
) -> None:
    """The line has the topic, the node and the policy; best effort is enough to read the states."""
    scene, lines = load_scene("overhead_energy", {"duration": 0.5}), list[str]()
    command = [sys.executable, PROGRAM, "best_effort"]
    with started_program(command, env=ros_environment, stdin=subprocess.PIPE) as process:

        def take(line: str) -> None:
            lines.append(line)
            if "is not matched" in line and process.stdin:
                process.stdin.write("\n")
                process.stdin.flush()

        summary = orchestration.run(
            scene, record=None, controller=False, domain_id=domain_id, on_news=take
        )
    assert "error" not in summary and summary["steps"] == scene.steps
    (line,) = [line for line in lines if "is not matched" in line]
    assert (
        "of /overhead/joint_commands is not matched: its QoS policy reliability does not fit"
        in line
    )


def test_commands_with_stamps_of_the_wall_clock_are_named(
    domain_id: int, ros_environment: dict[str, str]
) -> None:
    """After a second in which every command was refused a line says why, and what option helps."""
    scene, lines = load_scene("overhead_energy", {"duration": 2.5}), list[str]()
    with started_program(
        [sys.executable, PROGRAM, "wall_clock"], env=ros_environment, stdin=subprocess.PIPE
    ):
        summary = orchestration.run(
            scene,
            mode="realtime",
            record=None,
            controller=False,
            domain_id=domain_id,
            on_news=lines.append,
        )
    # a late end only lowers it
    assert summary["steps"] == scene.steps and summary["real_time_factor"] < 1.01
    assert (
        summary["commands"]["rejected"]
        == summary["commands"]["received"]
        == summary["refused_commands"]["future"]
    )
    (line,) = [line for line in lines if "commands so far were refused" in line]
    assert "possible: " in line and "(future)" in line and "--command-stamps ros" in line
