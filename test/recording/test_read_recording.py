"""A recording is read back as the run that it holds; a file that is none is refused."""

import importlib.util
import json
import sys
from pathlib import Path

import numpy as np
import pytest

import crane_sim
from crane_sim import orchestration
from crane_sim.recording.run import RecordedRun, UnreadableRecording

STEPS = 120


@pytest.fixture(scope="module")
def rollout() -> crane_sim.Rollout:
    """Run a short scene."""
    return crane_sim.simulate("knuckle_setpoint", duration=0.01 * STEPS)


@pytest.fixture(scope="module")
def file(rollout: crane_sim.Rollout, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Record it."""
    return rollout.record(tmp_path_factory.mktemp("read") / "run.rrd")


@pytest.fixture(scope="module")
def run(file: Path) -> RecordedRun:
    """Read it back."""
    return crane_sim.read_recording(file)


def test_what_is_read_is_what_was_simulated(rollout: crane_sim.Rollout, run: RecordedRun) -> None:
    """Arrays, summary and scene are the run's, bit for bit; its final instant is no step."""
    for name in ("q", "v", "u", "payload", "tip", "tension", "energy"):
        assert np.array_equal(getattr(run, name), getattr(rollout, name)[:-1]), name
    assert run.t == pytest.approx(rollout.t[:-1], abs=1e-12)  # the rounding of ns to s
    assert np.array_equal(run.commands, rollout.commands) and np.array_equal(
        run.reference[-1], rollout.scene.reference
    )
    assert np.array_equal(run.nodes, rollout.nodes[:-1:3]) and len(run.frames.t) == len(run.nodes)
    assert run.summary == json.loads(json.dumps(rollout.summary)) | {
        "recording": str(run.path),
        "recorded_steps": STEPS,
        "lost_steps": 0,
    }
    assert run.finished and run.status == "finished" and run.urdf.startswith("<?xml")


def test_the_scene_repeats_the_run(run: RecordedRun) -> None:
    """The scene in a recording, simulated again, ends in the same state."""
    assert (
        crane_sim.simulate(run.load_scene()).summary["state_sha256"] == run.summary["state_sha256"]
    )


def test_a_run_over_ros_reads_the_same(run: RecordedRun, tmp_path: Path) -> None:
    """The recording of a lockstep run over ROS holds the numbers of the run without ROS."""
    orchestration.run(
        crane_sim.load_scene("knuckle_setpoint", {"duration": 0.01 * STEPS}),
        record=tmp_path / "ros.rrd",
    )
    other = crane_sim.read_recording(tmp_path / "ros.rrd")
    for name in (
        "t",
        "q",
        "v",
        "u",
        "commands",
        "reference",
        "payload",
        "tip",
        "tension",
        "kinetic",
        "nodes",
    ):
        assert np.array_equal(getattr(other, name), getattr(run, name)), name
    assert (
        other.crane == run.crane
        and other.scene_text == run.scene_text
        and other.versions == run.versions
    )
    assert other.summary["state_sha256"] == run.summary["state_sha256"]


def test_a_law_that_is_a_function_is_recorded(tmp_path: Path) -> None:
    """A Python law's run is recorded with its commands, and says the law is none of the scene's."""
    run = crane_sim.simulate(
        "knuckle_setpoint", lambda t, q, v: (t, 215.0, 98.0, -10.0), duration=0.1
    )
    back = crane_sim.read_recording(run.record(tmp_path / "mine.rrd"))
    assert np.array_equal(back.commands, run.commands) and np.all(
        np.diff(back.commands[:, 0]) > 0.0
    )
    assert back.law == "external"


def test_other_instants_are_not_recorded(tmp_path: Path) -> None:
    """A run with samples at other instants than its periods says that it cannot be recorded."""
    run = crane_sim.simulate("knuckle_setpoint", duration=0.1, sample_times=[0.05])
    with pytest.raises(ValueError, match="without sample_times"):
        run.record(tmp_path / "no.rrd")


def test_bad_files_are_refused_in_one_line(file: Path, tmp_path: Path) -> None:
    """Missing, empty, foreign, cut files, and messages alone, have one line that names the file."""
    whole = file.read_bytes()
    bad = {
        "empty": b"",
        "foreign": b"no recording, but text",
        "cut": whole[: len(whole) // 9],
        "short": whole[:50],
    }
    for name, content in bad.items():
        Path(tmp_path, f"{name}.rrd").write_bytes(content)
    Path(tmp_path, "messages.mcap").write_bytes(b"")
    for name in ("missing.rrd", *(f"{name}.rrd" for name in bad), "messages.mcap", "."):
        with pytest.raises(UnreadableRecording) as error:
            crane_sim.read_recording(tmp_path / name)
        assert str(error.value).startswith(f"{tmp_path / name}: ") and "\n" not in str(
            error.value
        ), name


def test_a_file_is_cut_off_wherever_that_is(file: Path, tmp_path: Path) -> None:
    """A file that ends within a message, its head, or between two is said to be cut off."""
    whole = file.read_bytes()
    for size in range(60, 460, 4):  # heads have 16 bytes
        (tmp_path / "cut.rrd").write_bytes(whole[:size])
        with pytest.raises(UnreadableRecording, match="is cut off"):
            crane_sim.read_recording(tmp_path / "cut.rrd")


def test_columns_have_units(run: RecordedRun) -> None:
    """Every quantity has a column of its own, one value a step, with its unit."""
    columns = run.columns()
    assert all(values.shape == (STEPS,) for values, _ in columns.values())
    units = {name: unit for name, (_, unit) in columns.items()}
    assert units["q.slew"] == "rad" and units["v.rope"] == "m/s" and units["u.slew"] == "N m"
    assert np.array_equal(columns["payload.z"][0], run.payload[:, 2]) and units["payload.z"] == "m"


@pytest.mark.skipif(importlib.util.find_spec("pandas") is None, reason="pandas is not installed")
def test_a_data_frame_has_the_columns(run: RecordedRun) -> None:
    """The data frame has a row a step, the time as its index, and the units in its attributes."""
    frame = run.to_dataframe()
    assert frame.shape == (STEPS, len(run.columns())) and np.array_equal(frame.index, run.t)
    assert frame.attrs["units"]["u.rope"] == "N" and frame.attrs["units"]["t"] == "s"


def test_a_data_frame_without_pandas_is_one_line(
    run: RecordedRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without pandas, one line names it, how to get it, and what there is without it."""
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(
        crane_sim.SceneError, match="^a data frame needs .* pandas, .*install study.*columns"
    ) as error:
        run.to_dataframe()
    assert "\n" not in str(error.value)
