"""Bags that a killed recorder left."""

import shutil
from pathlib import Path

import pytest
from mcap_samples import DESCRIPTION, EFFORT_CODEC, SCENE, STATE_CODEC, TOPICS
from rosbags.rosbag2 import Reader

from crane_sim.recording.mcap.file import McapFile
from crane_sim.recording.mcap.repair import repair_folder


def test_a_recovered_file_is_read_like_a_closed_one(tmp_path: Path) -> None:
    """A recovered file has a killed recorder's messages as a closed one has them: times, order, counts.

    An attempt for which there was no time has changed nothing.
    """
    file, left = McapFile(tmp_path / "run.mcap", list(TOPICS.values())), tmp_path / "left.mcap.part"
    file.write(2, SCENE.period_ns, DESCRIPTION)
    for k in range(1, 21):  # an effort follows the state that it leads to: their stamps are not in order
        state, effort = (k + 1) * SCENE.period_ns, k * SCENE.period_ns
        file.write(0, state, STATE_CODEC.encode(state, (float(k),) * 6, (0.0,) * 6, (0.0,) * 6))
        file.write(1, effort, EFFORT_CODEC.encode(effort, (float(k),) * 4))
        if k % 10 == 0:
            file.save()
    shutil.copytree(file.part, left)
    with next(left.iterdir()).open("ab") as grown:
        grown.write(b"\x06\x99")  # the beginning of a record
    file.close()
    with pytest.raises(TimeoutError):
        repair_folder(left, lambda: 0.0)  # no time left: it stays as it is
    recovered = repair_folder(left)
    assert recovered is not None
    with Reader(recovered) as recovered_bag, Reader(file.path) as closed_bag:
        messages = [[(about.topic, *rest) for about, *rest in bag.messages()] for bag in (recovered_bag, closed_bag)]
        assert messages[0] == messages[1]
        for attribute in ("message_count", "start_time", "end_time"):
            assert getattr(recovered_bag, attribute) == getattr(closed_bag, attribute)
