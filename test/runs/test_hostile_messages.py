"""Hostile messages and requests beside a run: no node ends, and no number changes.

They come on all topics and services.
"""

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
SCENE = load_scene("overhead_energy", {"duration": 20.0})
NAMESPACE = f"/{SCENE.crane}"
LIMIT = 300.0  # s for the node, only so that a failure ends
OWN_TOPICS = ("joint_states", "applied_effort", "held_command", "joint_commands")


def run_beside(
    mode: str, seed: int, number: int, domain: int, env: dict[str, str], path: Path
) -> dict[str, Any]:
    """Run the scene, recorded, beside `number` hostile messages of a node; return the summary."""
    command = [sys.executable, PROGRAM, str(seed), str(number), SCENE.name]
    pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with started_program(command, limit=LIMIT, env=env, **pipes) as process:
        rate = 2.0 if mode == "realtime" else None
        mcap = path.with_suffix(".mcap")
        summary = orchestration.run(
            SCENE, mode=mode, rate=rate, record=path, mcap=mcap, paused=True, domain_id=domain
        )
        sent = json.loads(process.communicate(timeout=60.0)[0])
    assert sent["sent"] >= number and sent["requests"] >= number // 50
    return summary


def check_run(summary: dict[str, Any], path: Path) -> None:
    """Check that no node has ended, the recording is whole, and the summary names the refused."""
    assert "error" not in summary
    assert (
        summary["steps"] == summary["recorded_steps"] == SCENE.steps and summary["lost_steps"] == 0
    )
    refused = summary["refused_messages"]
    for topic in OWN_TOPICS:
        assert refused[f"{NAMESPACE}/{topic} of {NAMESPACE}/stranger"] > 0, refused
    assert not [
        source
        for source in refused
        if source.endswith((f"{NAMESPACE}/plant", f"{NAMESPACE}/controller"))
    ]
    run = read_recording(path)
    assert run.finished and np.isfinite(run.commands).all()
    assert replay(run).difference is None


@pytest.mark.parametrize(
    ("mode", "seed", "number"),
    [
        ("lockstep", 0, 500),
        *(pytest.param("lockstep", seed, 10_000, marks=pytest.mark.long) for seed in (1, 2)),
        *(pytest.param("realtime", seed, 10_000, marks=pytest.mark.long) for seed in (3, 4)),
    ],
)
def test_hostile_messages_and_requests(
    mode: str,
    seed: int,
    number: int,
    domain_id: int,
    ros_environment: dict[str, str],
    tmp_path: Path,
) -> None:
    """They end no node and change no recorded number; in lockstep no state, either."""
    path = tmp_path / "run.rrd"
    summary = run_beside(mode, seed, number, domain_id, ros_environment, path)
    check_run(summary, path)
    if mode == "lockstep":
        assert summary["state_sha256"] == simulate(SCENE).summary["state_sha256"]
