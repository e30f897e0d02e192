"""Recordings of long runs, which have no index."""

from pathlib import Path

import pytest

from crane_sim import load_scene
from crane_sim.recording.rerun.reader import read_curves, read_summary
from crane_sim.recording.rerun.session import Session
from crane_sim.recording.rerun.writer import INDEXED
from crane_sim.recording.step_assembler import Row

FOOTER = b"FOOT"  # nearly the last word of a file with an index
EFFORT = (0.0,) * 4


@pytest.mark.parametrize(("duration", "indexed"), [(INDEXED, True), (INDEXED + 1.0, False)])
def test_only_a_short_recording_is_indexed(duration: float, indexed: bool, tmp_path: Path) -> None:
    """The file of a long run ends without the index that Rerun would keep in memory; what is in it is read the same."""
    scene = load_scene("knuckle_setpoint", {"duration": duration})
    session = Session(scene, tmp_path / "run.rrd")
    for first in (1, 51):
        steps = range(first, first + 50)
        session.write([Row(k, scene.initial_q, scene.initial_v, EFFORT, EFFORT, scene.reference) for k in steps])
    summary = session.close({"steps": 100}, 0)
    assert (FOOTER in (tmp_path / "run.rrd").read_bytes()[-12:]) == indexed
    assert read_curves(tmp_path / "run.rrd", "plots/q").step.tolist() == list(range(1, 101))
    assert read_summary(tmp_path / "run.rrd")["recorded_steps"] == summary["recorded_steps"] == 100
