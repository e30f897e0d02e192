"""A stock ros2_control set-up, emulated, drives the crane through topics."""

import sys
from pathlib import Path
from typing import Any

import pytest
from pd_law import PdLaw
from process_helpers import started_program

from crane_sim import Scene, load_scene, orchestration, simulate

PROGRAM = Path(__file__).parents[1] / "programs" / "topic_hardware_interface.py"
SCENE = load_scene("knuckle_setpoint", {"duration": 8.0})
ARRIVED = 0.1  # rad or m; the load still swings, and shakes the joints by less


def run_with(
    folder: Path,
    environment: dict[str, str],
    options: tuple[str, ...],
    scene: Scene = SCENE,
    **settings: Any,
) -> dict[str, Any]:
    """Return the summary of a run that the emulation commands; `options` are the program's."""
    file = folder / "scene.yaml"
    scene.dump(file)
    environment = environment | {"PYTHONPATH": str(PROGRAM.parents[1] / "helpers")}
    with started_program([sys.executable, PROGRAM, file, *options], env=environment):
        return orchestration.run(scene, controller=False, record=None, **settings)


@pytest.mark.long(cases=["options1"])
@pytest.mark.parametrize(
    "options", [("sim", "actuated", "single", "reliable"), ("sim", "all", "events", "reliable")]
)
def test_the_clock_leads_lockstep(
    domain_id: int, ros_environment: dict[str, str], tmp_path: Path, options: tuple[str, ...]
) -> None:
    """A controller by simulated time runs in lockstep to the states of its law in one process."""
    scene = load_scene("knuckle_setpoint", {"duration": 2.0})
    summary = run_with(
        tmp_path, ros_environment, options, scene, domain_id=domain_id, command_stamps="ros"
    )
    alone = simulate(scene, PdLaw(scene)).summary
    assert "error" not in summary and summary["state_sha256"] == alone["state_sha256"]
    assert summary["commands"]["rejected"] == 0


@pytest.mark.long
@pytest.mark.parametrize("tag", ["actuated", "all"])
def test_a_wall_clock_in_lockstep(
    domain_id: int, ros_environment: dict[str, str], tmp_path: Path, tag: str
) -> None:
    """With stamps ignored each wall-clock command answers a lockstep state; the crane arrives.

    Which state it answers is a matter of timing: there is no law in one process to compare with.
    """
    options = ("wall", tag, "single", "reliable")
    summary = run_with(
        tmp_path, ros_environment, options, domain_id=domain_id, command_stamps="any"
    )
    assert "error" not in summary and summary["steps"] == SCENE.steps
    assert summary["commands"]["rejected"] == 0, summary["commands"]
    assert max(map(abs, summary["final_error"].values())) < ARRIVED


@pytest.mark.long
def test_a_manager_that_starts_anew_goes_on(
    domain_id: int, ros_environment: dict[str, str], tmp_path: Path
) -> None:
    """The clock goes on for a controller manager restarted in a run, and the crane arrives."""
    options = ("sim", "all", "single", "reliable", "200")
    summary = run_with(
        tmp_path, ros_environment, options, domain_id=domain_id, command_stamps="ros"
    )
    assert "error" not in summary and summary["steps"] == SCENE.steps
    assert max(map(abs, summary["final_error"].values())) < ARRIVED


@pytest.mark.long
@pytest.mark.parametrize(
    ("options", "stamps"),
    [
        pytest.param(("sim", "all", "events"), "state", id="simulated time, stamps of states"),
        pytest.param(("sim", "actuated", "single"), "ros", id="simulated time, ROS time"),
        pytest.param(("wall", "all", "single"), "ros", id="wall clock, ROS time"),
        pytest.param(("wall", "actuated", "events"), "any", id="wall clock, any stamps"),
    ],
)
def test_real_time(
    domain_id: int,
    ros_environment: dict[str, str],
    tmp_path: Path,
    options: tuple[str, ...],
    stamps: str,
) -> None:
    """In real time the crane arrives with a controller by simulated time or by the wall clock."""
    settings = {"mode": "realtime", "command_stamps": stamps, "domain_id": domain_id}
    for _ in range(
        3
    ):  # where the machine holds the controller up for half a second, efforts are zero meanwhile
        summary = run_with(tmp_path, ros_environment, options, **settings)
        assert "error" not in summary and summary["commands"]["rejected"] == 0, summary["commands"]
        if not summary["silences"]:
            break
    assert max(map(abs, summary["final_error"].values())) < ARRIVED


def test_a_publisher_that_reads_no_states_begins_a_run(
    domain_id: int, ros_environment: dict[str, str]
) -> None:
    """A run in real time begins with commands of a node that does not subscribe to states."""
    program = PROGRAM.with_name("blind_publisher.py")
    # s of wall time, in which a command comes
    scene = load_scene("knuckle_setpoint", {"duration": 3.0})
    with started_program([sys.executable, program], env=ros_environment):
        summary = orchestration.run(
            scene, controller=False, record=None, domain_id=domain_id, **BLIND
        )
    assert (
        "error" not in summary
        and summary["commands"]["rejected"] == 0 < summary["commands"]["received"]
    )


BLIND: dict[str, Any] = {"mode": "realtime", "command_stamps": "any"}
