"""Overhead cranes as real processes: the same numbers as in one process, and runs that end early."""

from pathlib import Path

import numpy as np
import pytest

from crane_sim import load_scene, orchestrate
from crane_sim.plant import Plant
from crane_sim.rollout import simulate


def test_lockstep_equals_simulate_through_events() -> None:
    """A trolley that sticks and slips under a sampled law gives the same bits over Fast DDS as in one process."""
    changes = {"duration": 1.5, "friction": {"trolley": {"coulomb": 14.0, "static": 20.0}}}
    scene = load_scene("overhead_energy", changes)
    over_ros, in_process = orchestrate.run(scene, record=None), simulate(scene).summary
    assert over_ros["state_sha256"] == in_process["state_sha256"]
    assert over_ros["events"] == in_process["events"] and in_process["events"]


def test_a_run_that_the_model_ends_keeps_its_recording(tmp_path: Path) -> None:
    """A slack rigid link ends the run with its cause, and the recording holds every step up to there."""
    summary = orchestrate.run(load_scene("overhead_slack"), record=tmp_path / "slack.rrd")
    assert "link 1 went slack" in summary["error"]
    assert summary["recorded_steps"] == summary["steps"] > 10 and summary["lost_steps"] == 0


@pytest.mark.parametrize("scene", ["overhead_friction", "overhead_drum"])
def test_a_reset_forgets_the_run(scene: str) -> None:
    """A plant that is reset in mid-run repeats it bit for bit, events included."""
    plant = Plant(load_scene(scene))
    summaries = []
    for _ in range(2):
        for _ in range(200):
            plant.advance()
        summaries.append(plant.summary())
        plant.reset()
    assert summaries[0] == summaries[1] and np.isfinite(plant.q).all()
