"""Hostile commands by the thousand: none moves the crane, every one is counted, and the run goes on undisturbed."""

import json
import math
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import pytest
from bench_graph import NodeProcess
from hostility import JOINTS, Hostility, message
from process_helpers import started_program

from crane_sim import load_scene, orchestration, simulate
from crane_sim.ros.common.command_filter import CommandValidator, largest_efforts
from crane_sim.ros.common.messages import LEASE
from crane_sim.ros.common.serialization import JointWire
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant

PROGRAMS = Path(__file__).parents[1] / "programs"
LONGEST = 1800.0  # s for the slow test's 320 000 commands, only so that a failure ends


def besieged(scene: Scene, number: int) -> tuple[Plant, CommandValidator, Counter[str]]:
    """Run a scene in lockstep on the plant's own ways in, with `number` hostile commands spread over its states.

    Returns:
        the plant, its gate, and how many commands are to be refused for which reason.
    """
    gate, hostility = CommandValidator(JOINTS, largest_efforts(scene)), Hostility(1)
    plant, wire = Plant(scene), JointWire(JOINTS, effort=True)
    expected: Counter[str] = Counter()
    for k in range(1, scene.steps + 1):
        now = k * scene.period_ns
        batch = [hostility.command(now) for _ in range(number * k // scene.steps - number * (k - 1) // scene.steps)]
        expected += Counter(reason for reason, _ in batch)
        answer = message(now, JOINTS, scene.law(plant.t, plant.q, plant.v)) if scene.law else b""
        for data in (*(data for _, data in batch), answer):
            frame = gate.decode(wire.decode, data)
            effort = frame and gate.validate(frame.stamp, frame.names, frame.effort, now=now, oldest=now)
            if effort:
                plant.advance(effort)
    return plant, gate, expected


def check_siege(number: int) -> None:
    """Check that hostile commands are counted exactly and change no bit of a run."""
    scene = load_scene("knuckle_setpoint", {"duration": 4.0})
    plant, gate, expected = besieged(scene, number)
    assert sum(expected.values()) == number
    assert gate.refused == expected
    assert gate.received == number + scene.steps
    assert all(map(math.isfinite, (*plant.q, *plant.v)))
    assert plant.summary()["state_sha256"] == simulate(scene).summary["state_sha256"]


def test_ten_thousand_hostile_commands() -> None:
    """Every hostile command is refused for the reason for which it is hostile, and none changes a bit of the run."""
    check_siege(10_000)


@pytest.mark.slow
def test_a_million_hostile_commands() -> None:
    """The same with a million of them."""
    check_siege(1_000_000)


def controlled(
    scene: Scene, domain: int, environment: dict[str, str], each: int, folder: Path
) -> tuple[dict, Counter[str]]:
    """Run a scene over DDS with a controller that sends `each` hostile commands before every right one, recorded.

    Returns:
        the run's summary, and how many commands are to be refused for which reason.
    """
    command = [sys.executable, PROGRAMS / "hostile_controller.py", str(each), str(scene.steps)]
    with started_program(command, limit=LONGEST, env=environment, stdout=subprocess.PIPE) as process:
        files = {"record": folder / "run.rrd", "mcap": folder / "run.mcap"}
        summary = orchestration.run(scene, **files, controller=False, domain_id=domain)
        return summary, Counter(json.loads(process.communicate(timeout=60.0)[0]))


def check_controlled(duration: float, each: int, domain: int, environment: dict[str, str], folder: Path) -> None:
    """Check the books of a run whose controller is hostile."""
    scene = load_scene("knuckle_setpoint", {"duration": duration})
    summary, sent = controlled(scene, domain, environment, each, folder)
    assert "error" not in summary
    assert summary["recorded_steps"] == scene.steps and summary["lost_steps"] == 0
    assert sum(sent.values()) == each * scene.steps
    mistakes = ("not finite", "huge", "names", "length", "unstamped", "future", "unreadable")
    assert summary["commands"] == {
        "received": (each + 1) * scene.steps,
        "rejected": sum(sent[reason] for reason in mistakes),
        "late": sent["late"] + sent["stale"],
        "duplicate": sent["duplicate"],
    }
    assert summary["state_sha256"] == simulate(scene).summary["state_sha256"]


def test_a_hostile_controller(domain_id: int, ros_environment: dict[str, str], tmp_path: Path) -> None:
    """Over the wire, too, hostile commands are counted to the last one, change no bit and harm no recording."""
    check_controlled(
        10.0, 8, domain_id, ros_environment, tmp_path
    )  # with the right one 9: the queue of a subscription holds 10


@pytest.mark.slow
def test_a_hostile_controller_for_long(domain_id: int, ros_environment: dict[str, str], tmp_path: Path) -> None:
    """The same for 320 000 hostile commands."""
    check_controlled(400.0, 8, domain_id, ros_environment, tmp_path)


def flooded(scene: Scene, mode: str, env: dict[str, str], file: Path) -> tuple[dict[str, Any], dict[str, float]]:
    """Run plant and controller beside a flood of commands; return the plant's summary, and what the flood tells."""
    scene.dump(file)
    common = (f"scene:={file}", f"mode:={mode}")
    # On a busy machine controller and flood may both stand still for longer than the usual lease of 0.3 s.
    patient = (f"command_lease:={LEASE}", *(["rate:=2.0"] if mode == "realtime" else []))
    flood = [sys.executable, PROGRAMS / "hostile_flood.py"]
    with (
        NodeProcess("crane_sim.ros.plant_node", env, *common, *patient) as plant,
        NodeProcess("crane_control.nodes.controller_node", env, *common) as controller,
        started_program(flood, env=env, stdout=subprocess.PIPE) as process,
    ):
        plant.await_event("ready")
        controller.await_event("ready")
        plant.order("go")
        summary = plant.await_event("done")["summary"]
        return summary, json.loads(process.communicate(timeout=60.0)[0])


@pytest.mark.parametrize("mode", ["lockstep", pytest.param("realtime", marks=pytest.mark.slow)])
def test_a_flood_from_somebody_else(mode: str, ros_environment: dict[str, str], tmp_path: Path) -> None:
    """A stranger's commands at 20 kHz, some of them good, leave the crane to its own controller, and are counted."""
    scene = load_scene("knuckle_setpoint", {"duration": 4.0})
    summary, sent = flooded(scene, mode, ros_environment, tmp_path / "scene.yaml")
    print(f"{sent['sent']} commands at {sent['rate']:.0f} Hz")  # fewer where the machine is busy; shown by -rP
    commands = summary["commands"]
    refused = commands["rejected"] + commands["late"] + commands["duplicate"]
    assert "error" not in summary
    assert 0 < refused <= commands["received"] <= sent["sent"] + scene.steps + refused
    assert all(math.isfinite(error) for error in summary["final_error"].values())
    if mode == "lockstep":
        assert commands["received"] - refused == scene.steps
        assert summary["state_sha256"] == simulate(scene).summary["state_sha256"]
