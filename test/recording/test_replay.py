"""Replay from commands: states agree bit for bit, and one that does not is named."""

import json
import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from math import nan
from pathlib import Path

import numpy as np
import pytest

import crane_sim
from crane_sim.files.catalogue import scene_files
from crane_sim.recording.read import as_recorded
from crane_sim.recording.replay import Difference
from crane_sim.recording.replay import replay as replay_run
from crane_sim.recording.run import RecordedRun

PROGRAM = Path(__file__).parents[1] / "programs" / "replays.py"
SLOW = {"overhead_long_cable", "overhead_steel", "pendulum_sea"}  # minutes without compilation
PERIODS = 8  # of a run
TIME = 540.0  # s for all replays

SCENES = {
    "a law and limits": ("knuckle_setpoint", {}),
    "drives with lag and sensors with noise": ("knuckle_bench", {}),
    "open loop": ("overhead_energy", {"control": None, "reference": None}),
    "a base at sea": ("knuckle_sea", {}),
}


@cache
def recorded(name: str) -> RecordedRun:
    """Return the recorded run of a case."""
    scene, changes = SCENES[name]
    return as_recorded(crane_sim.simulate(crane_sim.load_scene(scene, changes | {"duration": 0.3})))


@pytest.mark.parametrize("name", SCENES)
def test_a_replay_passes_through_the_same_states(name: str) -> None:
    """Every state of a run is met bit for bit from the recorded commands alone."""
    run = recorded(name)
    outcome = replay_run(run)
    assert outcome.difference is None and outcome.steps == len(run.t) > 20
    assert outcome.changed == {}


def test_commands_from_outside_are_replayed() -> None:
    """A scene without a law, commanded by a function, passes through the same states."""
    scene = crane_sim.load_scene(
        "overhead_energy", {"control": None, "reference": None, "duration": 0.3}
    )
    run = crane_sim.simulate(scene, law=lambda t, q, v: (40.0 * (1.0 - q[0]) - 80.0 * v[0],))
    outcome = replay_run(as_recorded(run))
    assert outcome.difference is None and run.q[-1, 0] > 1e-3


@pytest.mark.parametrize(("k", "joint", "bit"), [(0, 0, 0), (12, 4, 51), (19, 1, 63)])
def test_a_flipped_bit_is_named(k: int, joint: int, bit: int) -> None:
    """One bit of one state is found: its step, its joint, and which bit it is."""
    run = recorded("a law and limits")
    v = run.v.copy()
    v.view(np.uint64)[k, joint] ^= np.uint64(1 << bit)
    difference = replay_run(replace(run, v=v)).difference
    assert difference is not None
    found = (difference.step, difference.joint, difference.quantity, difference.bit)
    assert found == (k + 1, run.crane.joint_names[joint], "velocity", bit)


def test_a_command_or_a_step_that_was_lost_is_named() -> None:
    """A step without its command while no brakes acted, or a missing step, has no known command."""
    run = recorded("a law and limits")
    commands = run.commands.copy()
    commands[7] = nan
    with pytest.raises(crane_sim.SceneError, match="the command of step 8 is not in the recording"):
        replay_run(replace(run, commands=commands))
    rows = np.delete(np.arange(len(run.t)), 5)
    arrays = {name: getattr(run, name)[rows] for name in ("t", "q", "v", "commands")}
    with pytest.raises(crane_sim.SceneError, match="replay: step 6 is not in the recording"):
        replay_run(replace(run, **arrays))


def test_what_has_changed_since_is_listed() -> None:
    """Of versions and machine those that are not as they were are named, with both values."""
    run = recorded("a law and limits")
    then = {"numpy": "1.0", "python": run.versions["python"]}
    old = replace(run, properties=run.properties | {"provenance": json.dumps(then)})
    (name, values), *others = replay_run(old).changed.items()
    assert (name, values) == ("numpy", ("1.0", np.__version__)) and not others


def test_commands_that_are_not_those_of_the_run_are_found() -> None:
    """A command that is changed shows in the state after it."""
    run = recorded("a law and limits")
    commands = run.commands.copy()
    commands[4, 0] += 1e-9
    difference = replay_run(replace(run, commands=commands)).difference
    assert difference is not None and difference.step == 6


def test_a_difference_is_one_line() -> None:
    """It has step, time, joint and both values."""
    line = str(Difference(3, 0.02, "slew", "position", 1.0, 1.0 + 2.0**-52))
    assert line == (
        "step 3 (t = 0.02 s): position of slew is 1.0000000000000002, recorded is 1.0; "
        "they differ from bit 0 of its fraction on"
    )
    assert "exponent or sign" in str(Difference(3, 0.02, "slew", "position", 1.0, -1.0))
    assert Difference(3, 0.02, "slew", "position", nan, nan).bit == -1


@pytest.mark.long
def test_recordings_of_the_catalogue_are_repeated_by_another_process(tmp_path: Path) -> None:
    """Short runs of at least fifty scenes are replayed by another process to the same states."""
    recordings, steps = list[str](), dict[str, int]()
    for name in sorted(scene_files().keys() - SLOW):
        scene = crane_sim.load_scene(name)
        run = crane_sim.simulate(name, duration=min(scene.duration, PERIODS * scene.period))
        recordings.append(str(run.record(tmp_path / f"{name}.rrd")))
        steps[name] = len(run.t) - 1
    assert len(recordings) >= 50
    environment = os.environ | {"CRANE_SIM_INTERPRETED": "1"}
    command = [sys.executable, "-W", "ignore", str(PROGRAM), *recordings]
    answer = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=TIME)
    assert answer.returncode == 0, answer.stderr[-2000:]
    assert json.loads(answer.stdout) == {name: [count, None] for name, count in steps.items()}
