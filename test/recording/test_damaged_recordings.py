"""Cut or damaged recordings say so, and give only the steps that are as they were written."""

import logging
from collections import Counter
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from bag_samples import write_bag
from damaged_files import write_damaged
from mcap_samples import read
from recorder_helpers import SCENE, feed
from rosbags.rosbag2.errors import ReaderError

import crane_sim
from crane_sim.recording.completeness import COMPLETE, CUT, DAMAGED
from crane_sim.recording.files import unfinished_name
from crane_sim.recording.rerun import rollout as recordings
from crane_sim.recording.rerun import writer
from crane_sim.recording.rerun.recorder import Recorder
from crane_sim.recording.run import RecordedRun, UnreadableRecording
from crane_sim.simulation.rollout import Rollout

STEPS, BLOCK = 40, 10
KINDS = (".rrd", ".mcap")
ARRAYS = (
    "t",
    "q",
    "v",
    "u",
    "commands",
    "reference",
    "tip",
    "payload",
    "tensions",
    "swing",
    "kinetic",
    "potential",
)


@cache
def simulated() -> Rollout:
    """Return the run that is recorded."""
    return crane_sim.simulate("knuckle_setpoint", duration=0.01 * STEPS)


@pytest.fixture(scope="module")
def files(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Record the run in blocks, and as a bag of as many chunks; return the files by kind."""
    folder = tmp_path_factory.mktemp("whole")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(recordings, "BLOCK_STEPS", BLOCK)
        recording = simulated().record(folder / "run.rrd")
    return {
        ".rrd": recording,
        ".mcap": write_bag(folder / "run.mcap", simulated(), save_every=BLOCK),
    }


@pytest.fixture(scope="module")
def whole(files: dict[str, Path]) -> dict[str, RecordedRun]:
    """Return the runs in the whole files, by kind."""
    return {kind: crane_sim.read_recording(file) for kind, file in files.items()}


def differences(run: RecordedRun, whole: RecordedRun) -> set[str]:
    """Return what of a run is not what the whole file has, and "length" where steps are missing."""
    rows, frames = np.searchsorted(whole.t, run.t), np.searchsorted(whole.frames.t, run.frames.t)
    pairs = {name: (getattr(run, name), getattr(whole, name)[rows]) for name in ARRAYS}
    pairs["nodes"] = run.nodes, whole.nodes[frames]
    found = {name for name, (a, b) in pairs.items() if a.tobytes() != b.tobytes()}
    found |= {
        name
        for name in ("states", "events", "summary", "properties", "crane")
        if getattr(run, name) != getattr(whole, name)
    }
    return found | ({"length"} if len(run.t) < len(whole.t) else set())


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_left_of_a_cut_file_is_read(
    kind: str,
    files: dict[str, Path],
    whole: dict[str, RecordedRun],
    tmp_path: Path,
    caplog: pytest.LogCaptureFixture,
) -> None:
    """All whole blocks of a cut file are read; the run and a warning say how far it goes."""
    data, counts = files[kind].read_bytes(), set[int]()
    cut = unfinished_name(tmp_path / f"run{kind}")
    for size in range(len(data) // 8, len(data), len(data) // 8):
        caplog.clear()
        cut.write_bytes(data[:size])
        try:
            run = crane_sim.read_recording(cut)
        except UnreadableRecording:
            continue
        assert differences(run, whole[kind]) <= {"length", "summary", "events", "states"}, size
        if run.completeness.state == COMPLETE:  # what is missing is the index
            assert len(run.t) == STEPS
            continue
        counts.add(len(run.t))
        extent = f"is cut off: it has {len(run.t)} of {STEPS} steps, up to {run.t[-1]:g} s"
        assert run.completeness == (CUT, extent) and not run.finished and extent in run.status
        assert [line.getMessage() for line in caplog.records] == [f"{cut} {extent}"]
    assert counts and all(count % BLOCK == 0 for count in counts)


@pytest.mark.parametrize("kind", KINDS)
def test_a_damaged_step_is_left_out(
    kind: str, files: dict[str, Path], whole: dict[str, RecordedRun], tmp_path: Path
) -> None:
    """A flipped bit of a position costs the steps of its block; others are as written."""
    data, damaged = bytearray(files[kind].read_bytes()), tmp_path / f"run{kind}"
    if kind == ".mcap":
        at = data.index(whole[kind].q[25, 0].tobytes())
    else:  # compressed, but not these numbers, which repeat nowhere
        at = data.index(whole[kind].q[25, 5].tobytes()[1:7])
    data[at] ^= 1
    damaged.write_bytes(data)
    run = crane_sim.read_recording(damaged)
    assert run.completeness.state == DAMAGED and not run.finished
    assert f"is damaged: {STEPS - BLOCK} of {STEPS} steps are as they were written" in run.status
    assert differences(run, whole[kind]) <= {"length", "summary"}


def check_damaged(
    kind: str, seeds: range, files: dict[str, Path], whole: dict[str, RecordedRun], folder: Path
) -> Counter[str]:
    """Read a damaged copy of a file per seed; return counts of complete, cut, damaged, refused."""
    outcomes, file = Counter[str](), folder / f"run{kind}"
    for seed in seeds:
        what = write_damaged(files[kind], file, seed)
        try:
            run = crane_sim.read_recording(file)
        except UnreadableRecording as error:
            assert "\n" not in str(error) and str(error).startswith(f"{file}: "), (seed, what)
            outcomes["refused"] += 1
            continue
        found = differences(run, whole[kind])
        told = (
            set[str]()
            if run.completeness.state == COMPLETE
            else {"length", "summary", "events", "states"}
        )
        assert found <= told, (seed, what, found, run.status)
        outcomes[run.completeness.state] += 1
    return outcomes


@pytest.mark.parametrize("kind", KINDS)
def test_no_difference_is_silent(
    kind: str, files: dict[str, Path], whole: dict[str, RecordedRun], tmp_path: Path
) -> None:
    """However a file is damaged, what is read is as written, or said not to be.

    Nothing else is raised.
    """
    logging.disable(logging.WARNING)
    try:
        outcomes = check_damaged(kind, range(18), files, whole, tmp_path)
    finally:
        logging.disable(logging.NOTSET)
    assert outcomes[DAMAGED] and outcomes[CUT]


@pytest.mark.long
@pytest.mark.parametrize("part", range(4))
@pytest.mark.parametrize("kind", KINDS)
def test_no_difference_is_silent_in_many_files(
    kind: str, part: int, files: dict[str, Path], whole: dict[str, RecordedRun], tmp_path: Path
) -> None:
    """As above, for 200 damaged files a part."""
    test_seeds = range(1000 + 200 * part, 1200 + 200 * part)
    assert check_damaged(kind, test_seeds, files, whole, tmp_path).total() == len(test_seeds)


def test_a_message_that_cannot_be_decoded_is_left_out(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """Bytes of another type on a bag's topic are counted, and all steps are read."""
    file = write_bag(tmp_path / "run.mcap", simulated(), foreign=b"\0\1\0\0no JointState")
    run = crane_sim.read_recording(file)
    assert len(run.t) == STEPS and run.finished and run.q.tobytes() == simulated().q[:-1].tobytes()
    assert [line.getMessage() for line in caplog.records] == [
        f"{file}: 1 messages cannot be decoded and are left out"
    ]


@pytest.mark.parametrize("reason", ["orphaned", "interrupted"])
def test_a_run_that_ended_before_its_time_is_not_finished(reason: str, tmp_path: Path) -> None:
    """A recorder without its supervisor completes its file; the run says why it is unfinished."""
    recorder = Recorder(SCENE, tmp_path / "run.rrd")
    feed(recorder, 20)
    recorder.finish({"scene": SCENE.name, "ended_by": reason})
    run = crane_sim.read_recording(tmp_path / "run.rrd")
    assert run.completeness.state == COMPLETE and not run.finished
    assert run.status.startswith("failed: ") and run.status.endswith(
        f" after 20 of {SCENE.steps} steps"
    )


def test_lost_steps_make_a_recording_incomplete(tmp_path: Path) -> None:
    """A recorder that missed messages of some steps writes a whole file of an incomplete run."""
    recorder = Recorder(SCENE, tmp_path / "run.rrd")
    feed(recorder, 20)
    recorder.finish({"steps": 25})
    run = crane_sim.read_recording(tmp_path / "run.rrd")
    assert run.completeness == (CUT, "lacks 5 of 25 steps, whose messages its recorder did not get")
    assert not run.finished


def test_recordings_of_older_versions_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recording without digests is read as it is, and is complete with all its steps."""
    monkeypatch.setattr(writer, "DIGESTS", "others")
    monkeypatch.setattr(writer, "with_digest", dict)
    run = crane_sim.read_recording(simulated().record(tmp_path / "run.rrd"))
    assert run.completeness.state == COMPLETE and run.q.tobytes() == simulated().q[:-1].tobytes()


def test_other_readers_find_a_damaged_chunk(files: dict[str, Path], tmp_path: Path) -> None:
    """Chunks have the format's checksums, by which other readers refuse damaged ones."""
    assert len(read(files[".mcap"])["/knuckle/joint_states"]) == STEPS + 1
    data = bytearray(files[".mcap"].read_bytes())
    data[data.index(simulated().q[25, 0].tobytes())] ^= 1
    (tmp_path / "run.mcap").write_bytes(data)
    with pytest.raises(ReaderError, match="checksum"):
        read(tmp_path / "run.mcap")
