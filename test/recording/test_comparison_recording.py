"""Runs of one crane in one recording: cranes in place, curves share time, no view complains."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from rerun.chunk import RrdReader

import crane_sim
from crane_sim.cli.commands import app
from crane_sim.recording.camera import Framing
from crane_sim.recording.rerun.comparison import framing_of, record_comparison
from crane_sim.recording.rerun.part_file import RecordingError
from crane_sim.recording.rerun.screenshot import picture
from crane_sim.recording.rerun.viewer import PictureError

pytestmark = pytest.mark.unforked  # a client of the viewer

SHIFT = 0.125  # m, of the second run's trolley and payload
# m: lines and transforms in a recording have single precision, of lengths of a few metres
FLOAT32 = 1e-6


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> crane_sim.RecordedRun:
    """Record half a second of the overhead crane."""
    file = tmp_path_factory.mktemp("runs") / "a.rrd"
    return crane_sim.read_recording(
        crane_sim.simulate("overhead_energy", duration=0.5).record(file)
    )


def shifted(run: crane_sim.RecordedRun) -> crane_sim.RecordedRun:
    """Return the run half a period later, with trolley and payload shifted in curves and scene."""
    q, nodes = run.q.copy(), run.frames.nodes + (SHIFT, 0.0, 0.0)
    q[:, 0] += SHIFT
    late = 0.5 * run.period
    return replace(
        run, q=q, t=run.t + late, frames=run.frames._replace(nodes=nodes, t=run.frames.t + late)
    )


def columns(file: Path, entity: str, component: str) -> tuple[np.ndarray, np.ndarray]:
    """Return times [ns] and the values of a component of an entity, in the order of times."""
    for chunk in RrdReader(file).stream():
        if chunk.entity_path == f"/{entity}" and not chunk.is_static:
            batch = chunk.to_record_batch()
            times = batch["sim_time"].to_numpy(zero_copy_only=False).astype(np.int64)
            return times, np.array(batch[component].to_pylist(), dtype=np.float64)
    raise AssertionError(f"{file} has no {entity}")


def test_each_crane_is_where_its_run_had_it(run: crane_sim.RecordedRun, tmp_path: Path) -> None:
    """Curves, trolley and payload are those of each run, at its own instants of one timeline."""
    other = shifted(run)
    file = record_comparison(
        crane_sim.compare(run, other, names=("one", "two")), tmp_path / "both.rrd"
    )
    for key, each in (("run_1", run), ("run_2", other)):
        times, curve = columns(file, f"curves/trolley/{key}", "Scalars:scalars")
        assert np.array_equal(curve[:, 0], each.q[:, 0]) and np.array_equal(
            times, np.rint(1e9 * each.t)
        )
        times, trolley = columns(file, f"{key}/tf/trolley", "Transform3D:translation")
        assert np.array_equal(times, np.rint(1e9 * each.frames.t))
        assert np.abs(trolley[:, 0, 0] - each.q[each.frame_steps, 0]).max() < FLOAT32
        _, pieces = columns(file, f"{key}/path", "LineStrips3D:strips")
        assert np.abs(pieces[:, 0, 1] - each.frames.nodes[:, -1]).max() < FLOAT32


def test_loads_on_falls_hang_in_their_own_crane(tmp_path: Path) -> None:
    """The attitude of a load on falls joins its own run's frames; else the load is not drawn."""
    run = crane_sim.simulate("set_down_on_deck", duration=0.05)
    file = record_comparison(
        crane_sim.compare(run, run, names=("one", "two")), tmp_path / "both.rrd"
    )
    joined = {
        (row["Transform3D:parent_frame"][0], row["Transform3D:child_frame"][0])
        for chunk in RrdReader(file).stream()
        if chunk.entity_path.endswith("/tf/attitude")
        for row in chunk.to_record_batch().to_pylist()
    }
    assert joined == {
        (f"{key}/payload_z_link", f"{key}/payload_link") for key in ("run_1", "run_2")
    }


def test_a_comparison_shows_all_that_its_cranes_do(run: crane_sim.RecordedRun) -> None:
    """The comparison's picture shows cranes beyond the first one's; a sufficient one stays."""
    away = replace(run, frames=run.frames._replace(nodes=run.frames.nodes + (40.0, 0.0, 0.0)))
    usual = framing_of([run, run])
    assert usual == Framing(**run.crane.framing)
    wide = framing_of([run, away])
    assert wide.look_at[0] == pytest.approx(
        0.5 * (run.frames.nodes[..., 0].min() + away.frames.nodes[..., 0].max())
    )
    assert np.linalg.norm(np.subtract(wide.eye, wide.look_at)) > 40.0


def test_the_viewer_shows_it(run: crane_sim.RecordedRun, tmp_path: Path) -> None:
    """The viewer draws it and no view complains; skipped where nothing can draw."""
    file = record_comparison(crane_sim.compare(run, shifted(run)), tmp_path / "both.rrd")
    try:
        assert picture(file, tmp_path / "both.png") == []
    except PictureError as error:
        pytest.skip(str(error))


def test_the_command_writes_it_and_overwrites_no_run(
    run: crane_sim.RecordedRun, tmp_path: Path
) -> None:
    """`compare -o FILE.rrd` writes the recording; one of the runs as output is refused."""
    file, source = tmp_path / "both.rrd", str(run.path)
    app(["compare", source, source, "-o", str(file)], standalone_mode=False)
    assert file.stat().st_size > 0 and not file.with_name("both.rrd.part").exists()
    with pytest.raises(crane_sim.SceneError, match="is one of the runs"):
        app(["compare", source, source, "-o", source], standalone_mode=False)
    with pytest.raises(crane_sim.SceneError, match="holds a comparison of runs"):
        crane_sim.read_recording(file)


def test_a_recording_that_cannot_take_its_name_is_one_error(
    run: crane_sim.RecordedRun, tmp_path: Path
) -> None:
    """Where the name is a folder's, the error is the one of recordings, with the name."""
    (tmp_path / "both.rrd").mkdir()
    with pytest.raises(RecordingError, match="both.rrd"):
        record_comparison(
            crane_sim.compare(run, shifted(run), names=("one", "two")), tmp_path / "both.rrd"
        )
