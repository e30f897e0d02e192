"""An operator at a crane over ROS, real processes: joystick, loss, stop, terminal, repetition."""

import os
import signal
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from bench_graph import graph
from joystick import Joystick, ScriptedOperator, settle, wait_for, wait_mode
from process_helpers import has_exited
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_typestore
from speed_trolley import DOCUMENT

from crane_sim import load_scene, orchestration
from crane_sim.operator.desk import Mode
from crane_sim.operator.drives import with_operator_drives
from crane_sim.operator.levers import Buttons
from crane_sim.orchestration.desk_link import DeskLink
from crane_sim.recording.read import read_recording
from crane_sim.recording.replay import replay
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.plant import SLOW

REST, LEVERS = (0.0, 0.0, 0.0, 0.0), (0.5, -0.25, 0.0, 0.75)
DEAD_MAN, STOP, RELEASE, _ = Buttons()
STILL = {"trolley": 0.0, "bridge": 0.0, "rope": 0.0}


def scene_of_the_run() -> Scene:
    """Return the workshop crane for an operator: the kind of model that its own law runs with."""
    return with_operator_drives(load_scene("bridge_speed_drive"))


def run(scene: Scene, operator: ScriptedOperator, domain: int, **options: Any) -> dict[str, Any]:
    """Return the summary of a run that an operator ends."""
    settings = {
        "mode": "realtime",
        "controller": False,
        "on_silence": "brake",
        "record": None,
    } | options
    return orchestration.run(scene, operator=operator, domain_id=domain, **settings)


def speeds_of(scene: Scene, axes: tuple[float, ...]) -> dict[str, float]:
    """Return the speeds of the levers: parts of the largest ones that the scene's drives have."""
    servos, drives = scene.hardware.servos, scene.hardware.drives
    across, along, _, hoist = axes
    return {
        "trolley": along * float(servos.max_speed[0]),
        "bridge": across * float(servos.max_speed[1]),
        "rope": hoist * float(drives.high[2]),
    }


def rests(stick: Joystick, joints: Iterable[str] = STILL) -> bool:
    """Return whether the driven joints rest."""
    return all(abs(stick.velocities[name]) < SLOW for name in joints)


def start_moving(desk: DeskLink, stick: Joystick, expected: dict[str, float]) -> None:
    """Bring the levers to rest, hold the switch, and move them."""
    stick.move(REST)
    wait_mode(desk, Mode.OPEN)

    def moves() -> bool:
        mode = desk.panel().get("mode")
        if mode == Mode.INTERLOCKED:
            # the machine has held the joystick up, which counts as lost: once more
            stick.move(REST)
        elif mode == Mode.OPEN:
            stick.move(LEVERS, DEAD_MAN)
        return stick.held == expected

    wait_for(moves, "the speeds of the levers at the drives")


def wait_at_speed(stick: Joystick, expected: dict[str, float]) -> None:
    """Wait until the winch, which follows its speed with a lag and nothing else, has it."""
    wait_for(
        lambda: abs(stick.velocities["rope"] - expected["rope"]) < 1e-4, "the winch at its speed"
    )


@pytest.mark.long
def test_a_joystick_commands_exactly_and_stops(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Drives take the levers' exact speeds; switch, loss, stop and a hung node stop the crane.

    The run repeats.

    Each of these has its own way back. The recorded commands lead a fresh plant through the same
    states, bit for bit.
    """
    scene, nodes = scene_of_the_run(), dict[str, int]()
    expected = speeds_of(scene, LEVERS)
    record, bag = tmp_path / "drive.rrd", tmp_path / "drive.mcap"

    def script(desk: DeskLink) -> None:
        start_moving(desk, stick, expected)
        wait_for(lambda: stick.commands == expected, "the speeds of the levers in the commands")
        wait_at_speed(stick, expected)
        stick.move(LEVERS)
        wait_for(lambda: stick.held == STILL, "zero speeds after the switch was released")
        start_moving(desk, stick, expected)
        stick.silent = True
        wait_mode(desk, Mode.DEVICE_LOST)
        wait_for(lambda: stick.held == STILL and rests(stick), "rest after the joystick was lost")
        stick.silent = False
        wait_mode(desk, Mode.INTERLOCKED)
        start_moving(desk, stick, expected)
        stick.move(LEVERS, DEAD_MAN, STOP)
        wait_mode(desk, Mode.STOPPED)  # the brakes may be those of a time-out
        wait_for(
            lambda: all(map(np.isnan, stick.held.values())), "the brakes at the emergency stop"
        )
        stick.move(LEVERS, DEAD_MAN, RELEASE)
        wait_for(lambda: rests(stick), "rest by the brakes")
        settle(0.3)
        assert all(map(np.isnan, stick.held.values())) and desk.panel()["mode"] == Mode.STOPPED
        stick.move(REST, RELEASE)
        wait_mode(desk, Mode.OPEN)
        stick.move(REST, DEAD_MAN)
        wait_mode(desk, Mode.MOVING)
        # a load that swings moves nothing
        assert all(map(np.isnan, stick.held.values())) and desk.panel()["braked"]
        start_moving(desk, stick, expected)
        os.kill(nodes["operator"], signal.SIGSTOP)
        wait_for(
            lambda: all(map(np.isnan, stick.held.values())),
            "the brakes after the time-out of commands",
        )
        wait_for(lambda: rests(stick), "rest by the brakes of the time-out")
        os.kill(nodes["operator"], signal.SIGCONT)
        wait_for(
            lambda: not any(map(np.isnan, stick.held.values())), "commands of the node that hung"
        )

    with graph(tmp_path, monkeypatch) as (domain, _), Joystick(domain, "bridge") as stick:
        # a joystick that a busy machine holds up for half a second is not lost
        operator = ScriptedOperator(script, device_timeout=2.0)
        options: dict[str, Any] = {"record": record, "mcap": bag, "on_activated": nodes.__setitem__}
        summary = run(scene, operator, domain, **options)
        operator.check()
    assert "error" not in summary and summary["commands"]["rejected"] == 0, summary
    assert summary["operator"]["device"] == "/joy" and summary["operator"]["stops"] == 1
    assert summary["operator"]["losses"] >= 1  # one on purpose; the hung node may count more
    recorded = read_recording(record)
    commands, outcome = recorded.commands, replay(recorded)
    assert len(commands) == summary["steps"] == outcome.steps and np.isnan(commands).any()
    assert outcome.difference is None, str(outcome.difference)
    assert np.array_equal(held_commands(bag), commands, equal_nan=True)


def held_commands(bag: Path) -> np.ndarray:
    """Return the commands of each period in a bag (K, nu), NaN where the brakes acted."""
    with AnyReader([bag], default_typestore=get_typestore(Stores.ROS2_JAZZY)) as reader:
        connections = [each for each in reader.connections if each.topic == "/bridge/held_command"]
        messages = [
            reader.deserialize(raw, each.msgtype) for each, _, raw in reader.messages(connections)
        ]
    velocities, efforts = (
        np.array([getattr(m, field) for m in messages]) for field in ("velocity", "effort")
    )
    return np.where(np.isnan(velocities), efforts, velocities)


def test_a_killed_operator_node_stops_the_crane(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Where the operator's node dies, the crane is braked to rest; the run ends with a line why."""
    scene, nodes = with_operator_drives(load_scene(DOCUMENT)), dict[str, int]()
    speed = LEVERS[1] * float(scene.hardware.servos.max_speed[0])

    def script(desk: DeskLink) -> None:
        start_moving(desk, stick, {"trolley": speed})
        wait_for(lambda: stick.velocities["trolley"] / speed > 0.5, "the trolley on its way")
        os.kill(nodes["operator"], signal.SIGKILL)
        wait_for(lambda: rests(stick, ["trolley"]), "rest after the operator's node was killed")
        wait_for(
            lambda: has_exited(nodes["plant"]),
            "the end of the run, which the script is not to end first",
        )

    with graph(tmp_path, monkeypatch) as (domain, _), Joystick(domain, "overhead") as stick:
        # s: a joystick that is held up is not lost
        operator = ScriptedOperator(script, device_timeout=60.0)
        summary = run(scene, operator, domain, on_activated=nodes.__setitem__)
        operator.check()
    assert (
        summary["error"].startswith("operator: it was killed by SIGKILL")
        and "\n" not in summary["error"]
    )
