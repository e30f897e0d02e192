"""Recordings of long runs: large blocks have no index, many small ones are compacted."""

from collections import Counter
from pathlib import Path

import pytest
from recorder_helpers import feed
from recording_samples import RowWriter, rows_at_rest
from rerun.chunk import RrdReader

from crane_sim import load_scene
from crane_sim.recording.completeness import COMPLETE
from crane_sim.recording.read import read_recording
from crane_sim.recording.rerun.reader import read_curves, read_summary
from crane_sim.recording.rerun.recorder import Recorder
from crane_sim.recording.rerun.writer import MAX_INDEXED_DURATION

FOOTER = b"FOOT"  # nearly the last word of a file with an index


@pytest.mark.parametrize(
    ("duration", "indexed"), [(MAX_INDEXED_DURATION, True), (MAX_INDEXED_DURATION + 1.0, False)]
)
def test_only_a_short_recording_is_indexed(duration: float, indexed: bool, tmp_path: Path) -> None:
    """A long run's file ends without the index, which Rerun would keep in memory.

    What is in it is read the same.
    """
    scene = load_scene("knuckle_setpoint", {"duration": duration})
    session = RowWriter(scene, tmp_path / "run.rrd")
    for first in (1, 51):
        session.write_rows(rows_at_rest(scene, 50, first))
    summary = session.finish({"steps": 100})
    assert (FOOTER in (tmp_path / "run.rrd").read_bytes()[-12:]) == indexed
    assert read_curves(tmp_path / "run.rrd", "plots/q").step.tolist() == list(range(1, 101))
    assert read_summary(tmp_path / "run.rrd")["recorded_steps"] == summary["recorded_steps"] == 100


def test_many_blocks_are_compacted_where_there_is_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of 80 blocks two indexed chunks a curve are left, with the same values; without time all."""
    monkeypatch.setattr("crane_sim.recording.rerun.recorder.BLOCK_SECONDS", 0.0)  # a block a step
    scene = load_scene("knuckle_setpoint", {"duration": MAX_INDEXED_DURATION + 1.0})
    chunks, runs = {}, {}
    for within in (60.0, 0.0):
        path = tmp_path / f"within_{within:g}.rrd"
        recorder = Recorder(scene, path)
        feed(recorder, 80)
        assert recorder.finish({"steps": 80}, within)["recorded_steps"] == 80
        chunks[within] = Counter(chunk.entity_path for chunk in RrdReader(path).stream())
        runs[within] = read_recording(path)
        assert runs[within].completeness.state == COMPLETE
    assert chunks[60.0]["/plots/q"] <= 2 and chunks[0.0]["/plots/q"] == 81  # one has the style
    assert FOOTER in (tmp_path / "within_60.rrd").read_bytes()[-12:]
    assert chunks[60.0].keys() == chunks[0.0].keys()
    for name in ("q", "v", "u", "payload", "tension", "energy"):
        assert getattr(runs[60.0], name).tobytes() == getattr(runs[0.0], name).tobytes(), name
    assert not list(tmp_path.glob("*.tmp"))
