"""The viewer, which does not load cut recordings, shows what is whole of one."""

from pathlib import Path
from urllib.request import urlopen

import pytest
from recorder_helpers import SCENE

import crane_sim
from crane_sim.files.errors import SceneError
from crane_sim.recording.rerun.reader import read_curves
from crane_sim.recording.rerun.rrd_file import open_viewable, read_chunks, whole_size
from crane_sim.recording.rerun.viewer import _served


def test_the_viewer_gets_what_is_whole(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """The copy of a file cut within a message ends before it, with a name that a viewer loads."""
    whole = crane_sim.simulate(SCENE, duration=0.1).record(tmp_path / "whole.rrd")
    assert open_viewable(whole) is None
    data, cut, copied = whole.read_bytes(), tmp_path / "run.rrd.part", tmp_path / "copied.rrd"
    cut.write_bytes(data[: 2 * len(data) // 3])
    copy = open_viewable(cut)
    assert copy is not None
    copied.write_bytes(copy.read())
    assert whole_size(copied) == copied.stat().st_size == whole_size(cut)
    assert (
        len(read_curves(copied, "plots/q").step) == 10
        and read_chunks(copied, ("plots",)).unreadable == 0
    )
    with _served(cut) as address, urlopen(address) as answer:
        assert address.endswith("/run.rrd") and answer.read() == copied.read_bytes()
    assert caplog.messages == [f"{cut} is cut off: what is whole of it is shown"] * 2


def test_an_unfinished_bag_is_not_shown(tmp_path: Path) -> None:
    """An unfinished bag is refused in one line with what draws it."""
    bag = tmp_path / "run.mcap.part"
    bag.touch()
    with pytest.raises(SceneError, match=r"run\.mcap\.part: is an unfinished bag.*crane report"):
        open_viewable(bag)
