"""The options of `crane run`: mistakes are told in one line before anything starts, and checking harms nothing."""

from pathlib import Path
from typing import Any

import pytest

from crane_sim import run_options
from crane_sim.explain import SceneError
from crane_sim.run_options import RunOptions

OPTIONS = RunOptions("lockstep", 1.0, None, False, None, False, None, False)


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"mcap": Path("run.bag")}, "--mcap run.bag: must end in .mcap"),
        ({"mcap": Path("a.mcap"), "record": Path("a.mcap")}, "--mcap and --record: both are a.mcap"),
        ({"mcap": Path("left.mcap")}, "--mcap left.mcap: left.mcap.part is in the way"),
        ({"live": True, "no_record": True}, "--live and --no-record: only one of the two is possible"),
        ({"on_silence": "sleep"}, "--on-silence = 'sleep': possible: zero, hold, brake"),
        ({"fifo": 100}, "--fifo = 100: possible: 1 .. 99, and 0 for none"),
        ({"wait": -1.0}, "--wait = -1.0: must be a number of seconds, 0 or more"),
    ],
)
def test_impossible_options_are_refused(
    options: dict[str, Any], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What cannot be written or does not go together is told in one line before anything starts."""
    monkeypatch.chdir(tmp_path)
    Path("left.mcap.part").mkdir()
    with pytest.raises(SceneError, match=line):
        OPTIONS._replace(**options).check()


def test_without_rosbags_the_option_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where rosbags is not installed, --mcap is refused with its name."""
    monkeypatch.setattr(run_options, "find_spec", lambda name: None)
    with pytest.raises(SceneError, match="--mcap: needs the Python package rosbags"):
        OPTIONS._replace(mcap=Path("run.mcap")).check()


def test_checking_a_path_harms_nothing(tmp_path: Path) -> None:
    """The early check that a recording can be written leaves what a killed recorder left there for its repair."""
    leftover = tmp_path / "run.rrd.part"
    leftover.write_bytes(b"rescue me")
    OPTIONS._replace(record=tmp_path / "run.rrd").arguments("knuckle_setpoint")
    assert leftover.read_bytes() == b"rescue me"
