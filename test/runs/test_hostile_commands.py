"""Thousands of invalid commands: none moves the crane, all are counted, and no state changes."""

import json
import math
import subprocess
import sys
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bench_graph import NodeProcess, graph, remote, wait_until
from invalid_commands import JOINTS, InvalidCommands, command_message
from process_helpers import started_program

from crane_sim import load_scene, orchestration, read_recording, simulate
from crane_sim.orchestration import supervisor
from crane_sim.ros.common.command_filter import CommandValidator, largest_efforts
from crane_sim.ros.common.command_stamps import StampRange
from crane_sim.ros.common.messages import LIVELINESS_LEASE
from crane_sim.ros.common.serialization import EFFORT, JointStateCodec
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import Plant

PROGRAMS = Path(__file__).parents[1] / "programs"
LIMIT = 300.0  # s for the controller, only so that a failure ends


def run_with_invalid_commands(
    scene: Scene, number: int
) -> tuple[Plant, CommandValidator, Counter[str]]:
    """Run a scene in lockstep by decoder and validator, `number` invalid commands over its states.

    Returns:
        the plant, its validator, and the expected refusals by reason.
    """
    validator, invalid = CommandValidator(JOINTS, largest_efforts(scene)), InvalidCommands(1)
    plant, codec = Plant(scene), JointStateCodec(JOINTS, EFFORT)
    expected: Counter[str] = Counter()
    for k in range(1, scene.steps + 1):
        now = k * scene.period_ns
        batch = [
            invalid.generate(now)
            for _ in range(number * k // scene.steps - number * (k - 1) // scene.steps)
        ]
        expected += Counter(reason for reason, _ in batch)
        answer = (
            command_message(now, JOINTS, scene.law(plant.t, plant.q, plant.v)) if scene.law else b""
        )
        for data in (*(data for _, data in batch), answer):
            frame = validator.decode(codec.decode, data)
            effort = frame and validator.validate(
                frame.stamp, frame.names, frame.effort, StampRange(now, now)
            )
            if effort:
                plant.advance(effort)
    return plant, validator, expected


def test_ten_thousand_invalid_commands() -> None:
    """Every invalid command is refused for its reason and counted; none changes a bit of a run."""
    scene, number = load_scene("knuckle_setpoint", {"duration": 4.0}), 10_000
    plant, validator, expected = run_with_invalid_commands(scene, number)
    assert sum(expected.values()) == number and validator.refused == expected
    assert validator.received == number + scene.steps
    assert all(map(math.isfinite, (*plant.q, *plant.v)))
    assert plant.summary()["state_sha256"] == simulate(scene).summary["state_sha256"]


def run_over_dds(
    scene: Scene, domain: int, environment: dict[str, str], each: int, folder: Path
) -> tuple[dict, Counter[str]]:
    """Run a scene over DDS, recorded, with `each` invalid commands before every valid one.

    Returns:
        the run's summary, and the expected refusals by reason.
    """
    command = [sys.executable, PROGRAMS / "hostile_controller.py", str(each), str(scene.steps)]
    with started_program(command, limit=LIMIT, env=environment, stdout=subprocess.PIPE) as process:
        files = {"record": folder / "run.rrd", "mcap": folder / "run.mcap"}
        summary = orchestration.run(scene, **files, controller=False, domain_id=domain)
        return summary, Counter(json.loads(process.communicate(timeout=60.0)[0]))


def test_a_hostile_controller(
    domain_id: int, ros_environment: dict[str, str], tmp_path: Path
) -> None:
    """Over DDS, too, all invalid commands are counted, and change no bit and no recording."""
    # with the valid one 9: a queue holds 10
    scene, each = load_scene("knuckle_setpoint", {"duration": 4.0}), 8
    summary, sent = run_over_dds(scene, domain_id, ros_environment, each, tmp_path)
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


def run_with_flood(
    scene: Scene, mode: str, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> tuple[dict[str, Any], dict[str, float]]:
    """Run plant and controller beside a flood of commands; return summary and flood's counters.

    After one step the run is paused until a command of the flood was refused: however late it
    comes, it comes in time.
    """
    file = folder / "scene.yaml"
    scene.dump(file)
    common = (f"scene:={file}", f"mode:={mode}")
    # flood and client, too
    matched = ("paused:=true", "expected_controllers:=2", "expected_recorders:=1")
    # On a busy machine controller and flood may both stall for longer than the usual lease of 0.3
    # s.
    long_lease = (
        f"command_lease:={LIVELINESS_LEASE}",
        *(["rate:=2.0"] if mode == "realtime" else []),
    )
    flood = [sys.executable, PROGRAMS / "hostile_flood.py"]
    with (
        graph(folder, monkeypatch) as (domain, env),
        remote(domain) as client,
        NodeProcess("crane_sim.ros.plant_node", env, *common, *long_lease, *matched) as plant,
        NodeProcess("crane_control.nodes.controller_node", env, *common) as controller,
        started_program(flood, env=env, stdout=subprocess.PIPE) as process,
    ):
        client.node.destroy_publisher(client.commands)
        plant.await_event("ready")
        controller.await_event("ready")
        plant.send("go")
        wait_until(lambda: bool(client.states), "the first state")
        client.take_steps(1)
        refused = "command of /knuckle/flood refused: /knuckle/controller owns the crane"
        wait_until(lambda: any(refused in line for _, line in client.warnings), "a refused command")
        assert client.pause(False) == "ok"
        summary = plant.await_event("done")["summary"]
        return summary, json.loads(process.communicate(timeout=60.0)[0])


@pytest.mark.parametrize("mode", ["lockstep", pytest.param("realtime", marks=pytest.mark.slow)])
def test_a_flood_from_another_publisher(
    mode: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Another publisher's commands at 20 kHz, some valid, are refused and counted.

    The owner stays.
    """
    scene = load_scene("knuckle_setpoint", {"duration": 4.0})
    summary, sent = run_with_flood(scene, mode, tmp_path, monkeypatch)
    # fewer where the machine is busy; shown by -rP
    print(f"{sent['sent']} commands at {sent['rate']:.0f} Hz")
    commands = summary["commands"]
    refused = commands["rejected"] + commands["late"] + commands["duplicate"]
    assert "error" not in summary
    assert 0 < refused <= commands["received"] <= sent["sent"] + scene.steps + refused
    assert all(math.isfinite(error) for error in summary["final_error"].values())
    if mode == "lockstep":
        assert commands["received"] - refused == scene.steps
        assert summary["state_sha256"] == simulate(scene).summary["state_sha256"]


@pytest.mark.long
def test_a_recording_beside_a_flood(
    domain_id: int, ros_environment: dict[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A flood from the first steps on takes neither the crane nor recorded commands, and is named.

    The summary names it.

    On a busy machine messages may be lost in a flood at 20 kHz: then the run says so.
    """
    # s: our controller's answers may be held up for long
    monkeypatch.setattr(supervisor, "_ANSWER_TIMEOUT", LIMIT)
    scene, lines = load_scene("knuckle_setpoint", {"duration": 4.0}), list[str]()
    with started_program([sys.executable, PROGRAMS / "hostile_flood.py"], env=ros_environment):
        path = tmp_path / "run.rrd"
        summary = orchestration.run(scene, record=path, domain_id=domain_id, on_news=lines.append)
    assert summary["state_sha256"] == simulate(scene).summary["state_sha256"]
    assert summary["refused_messages"]["/knuckle/joint_commands of /knuckle/flood"] > 0
    assert "command of /knuckle/flood refused: /knuckle/controller owns the crane" in lines
    missing = int(np.isnan(read_recording(path).commands).any(axis=1).sum())
    assert missing == summary.get("lost_commands", 0) and bool(summary["lost_steps"]) == (
        "error" in summary
    )
