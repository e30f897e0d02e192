"""Files at a reset after errors: a full disk, parts that cannot be joined."""

from pathlib import Path

import numpy as np
import pytest
from mcap_samples import SCENE as BAG_SCENE
from mcap_samples import TOPICS
from mcap_samples import feed as feed_bag
from recorder_helpers import SCENE, fail_full_disk, feed

from crane_sim import read_recording
from crane_sim.recording.files import before_reset
from crane_sim.recording.mcap.bag import Bag
from crane_sim.recording.mcap.file import McapFile
from crane_sim.recording.rerun import repair
from crane_sim.recording.rerun.reader import read_curves
from crane_sim.recording.rerun.recorder import Recorder
from crane_sim.recording.rerun.repair import EarlierFiles
from crane_sim.recording.rerun.writer import RunWriter


def test_a_disk_that_was_full_before_a_reset_is_counted_in_its_own_files(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The file has no step after the reset: all are lost, counted apart from those before it."""
    # what comes is written at once
    monkeypatch.setattr("crane_sim.recording.rerun.recorder.BLOCK_SECONDS", 0.0)
    recorder = Recorder(SCENE, tmp_path / "run.rrd")
    feed(recorder, 30)
    assert recorder.recorded >= 29  # the command of the last step may still be waited for
    previous = recorder.recorded
    monkeypatch.setattr(RunWriter, "write", fail_full_disk)
    feed(recorder, 40, after=30)
    feed(recorder, 20)
    added = recorder.finish({"steps": 20})
    why = f"it has 0 of 20 steps since the last reset, and {previous} from before it"
    assert added["error"] == f"recorder: the disk is full; {why}"
    assert (added["recorded_steps"], added["lost_steps"]) == (0, 20)
    assert added["recording"] == str(tmp_path / "run.rrd.part")


@pytest.mark.parametrize(("method", "saved"), [("write", 30), ("close", 40)])
def test_a_bag_s_disk_that_was_full_before_a_reset_is_counted_in_its_own_files(
    method: str, saved: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The same of a bag, whether it was full already, or is so when the reset closes the file."""
    bag = Bag(tmp_path / "run.mcap", TOPICS, BAG_SCENE.period_ns)
    feed_bag(bag, 30)
    bag.save()

    def fail(*_: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(McapFile, method, fail)
    feed_bag(bag, 40, after=30)
    feed_bag(bag, 20)
    summary = bag.finish({"steps": 20})
    assert summary["error"].endswith(
        f"No space left on device; it has 0 of 20 steps since the last reset, and {saved} from "
        "before it"
    )
    assert summary["mcap"] == str(tmp_path / "run.mcap.part") and bag.resets == 1


def test_the_file_after_a_reset_has_the_simulation_s_state(tmp_path: Path) -> None:
    """A run that plays on after a reset is playing from its file's first step until paused."""
    recorder = Recorder(SCENE, tmp_path / "run.rrd")
    for name in ("playing", "playing", "paused"):
        recorder.add_simulation_state(name)
        if name == "playing":
            feed(recorder, 10)
    file = recorder.finish({"scene": SCENE.name, "steps": 10})["recording"]
    states = read_recording(file).states["simulation"]
    assert (recorder.resets, [state for _, state in states]) == (1, ["playing", "paused"])


def test_parts_that_cannot_be_joined_at_a_reset_make_room(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """They get own names, in order; the run after the reset is whole under its usual name."""
    path = tmp_path / "run.rrd"
    dead = Recorder(SCENE, path, run_id="one")
    feed(dead, 20)
    dead.save()
    previous = EarlierFiles(20, 20, (tmp_path / "run.rrd.part",))
    successor = Recorder(
        SCENE, tmp_path / "run.part2.rrd", run_id="one", complete_file=path, previous=previous
    )
    feed(successor, 30, after=20)
    # as a disk that is nearly full has it
    monkeypatch.setattr(repair, "join_recordings", lambda *_: False)
    feed(successor, 10)
    added = successor.finish({"steps": 10})
    assert added == {"recording": str(path), "recorded_steps": 10, "lost_steps": 0}
    names = {"run.before_reset_1.rrd.part", "run.before_reset_1.part2.rrd", "run.rrd"}
    assert {file.name for file in tmp_path.iterdir()} == names
    for name, steps in (("run.before_reset_1.part2.rrd", range(21, 31)), ("run.rrd", range(1, 11))):
        assert np.array_equal(read_curves(tmp_path / name, "plots/q").step, list(steps))
    # a part of the first has that name
    assert before_reset(path, 1).name == "run.before_reset_2.rrd"
