"""Hostile messages on all topics, and requests of all services, beside a run: no node ends, and no number changes."""

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from process_helpers import started_program

from crane_sim import load_scene, orchestration, read_recording, simulate
from crane_sim.recording.replay import replay

PROGRAM = Path(__file__).parents[1] / "programs" / "hostile_node.py"
SCENE = load_scene("overhead_energy", {"duration": 40.0})
NAMESPACE = f"/{SCENE.crane}"
LIMIT = 240.0  # s for the node, only so that a failure ends
PLANT_TOPICS = ("joint_states", "applied_effort", "held_command")


def run_beside(mode: str, seed: int, number: int, domain: int, env: dict[str, str], folder: Path) -> dict[str, Any]:
    """Run the scene, recorded, beside a node that sends `number` hostile messages; return the run's summary."""
    command = [sys.executable, PROGRAM, str(seed), str(number), SCENE.name]
    files = {"record": folder / "run.rrd", "mcap": folder / "run.mcap"}
    with started_program(command, limit=LIMIT, env=env, stdin=subprocess.PIPE, stdout=subprocess.PIPE, grace=10.0) as process:
        rate = 2.0 if mode == "realtime" else None
        summary = orchestration.run(SCENE, mode=mode, rate=rate, paused=True, domain_id=domain, **files)
        sent = json.loads(process.communicate(timeout=60.0)[0])
    assert sent["sent"] >= number and sent["requests"] >= number // 50
    return summary


def check_run(summary: dict[str, Any], folder: Path) -> None:
    """Check that no node has ended, the recording is whole, and the summary names who was refused."""
    assert "error" not in summary
    assert summary["steps"] == summary["recorded_steps"] == SCENE.steps and summary["lost_steps"] == 0
    refused = summary["refused_messages"]
    for topic in (*PLANT_TOPICS, "joint_commands"):
        assert refused[f"{NAMESPACE}/{topic} of {NAMESPACE}/stranger"] > 0, refused
    assert not [source for source in refused if source.endswith((f"{NAMESPACE}/plant", f"{NAMESPACE}/controller"))]
    for file in ("run.rrd", "run.mcap"):
        run = read_recording(folder / file)
        assert np.isfinite(run.commands).all() and run.finished
        assert replay(run).difference is None


@pytest.mark.long(cases=["lockstep-1"])
@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("mode", ["lockstep", "realtime"])
def test_hostile_messages_and_requests(
    mode: str, seed: int, domain_id: int, ros_environment: dict[str, str], tmp_path: Path
) -> None:
    """Ten thousand of them end no node and change no recorded number; in lockstep no state, either."""
    summary = run_beside(mode, seed, 10_000, domain_id, ros_environment, tmp_path)
    check_run(summary, tmp_path)
    if mode == "lockstep":
        assert summary["state_sha256"] == simulate(SCENE).summary["state_sha256"]
