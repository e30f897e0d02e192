"""The options of `crane run`: single-line errors before it starts, checks without side effects."""

import math
import sys
from inspect import signature
from pathlib import Path
from typing import Any

import pytest
from click.testing import CliRunner

from crane_sim.cli.commands import app
from crane_sim.cli.drive import drive
from crane_sim.cli.run_options import RunOptions
from crane_sim.files.errors import SceneError
from crane_sim.orchestration.runs import run
from crane_sim.recording.files import lock_file

OPTIONS = RunOptions()
LED = {"command_stamps": "ros", "no_controller": True}  # by the clock


@pytest.mark.parametrize(
    ("options", "line"),
    [
        ({"mcap": Path("run.bag")}, "--mcap run.bag: must end in .mcap"),
        (
            {"mcap": Path("a.mcap"), "record": Path("a.mcap")},
            "--mcap and --record: both are a.mcap",
        ),
        (
            {"mcap": Path("busy.mcap")},
            "--mcap busy.mcap: busy.mcap.part is in the way, another run is writing it",
        ),
        (
            {"live": True, "no_record": True},
            "--live and --no-record: only one of the two is possible",
        ),
        ({"beside": "east", "mode": "realtime"}, "--beside = east: only with lockstep"),
        (
            LED | {"beside": "east"},
            "--beside = east: not with --command-stamps ros",
        ),
        (
            LED | {"no_clock": True},
            "--no-clock: not with --command-stamps ros",
        ),
        ({"command_stamps": "ros"}, "--command-stamps = ros: only with --no-controller"),
        ({"rate": 2.0}, "--rate = 2.0: only with --mode realtime"),
        ({"on_silence": "zero"}, "--on-silence = zero: only with --mode realtime"),
        ({"fifo": 5}, "--fifo = 5: only with --mode realtime"),
        (
            {"restart": True, "no_controller": True, "no_record": True},
            "--restart: .* nothing that it could replace",
        ),
        ({"wait": 5.0}, "--wait = 5.0: only with --no-controller"),
    ],
)
def test_impossible_options_are_rejected(
    options: dict[str, Any], line: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Unwritable files, contradictory or useless options are one-line errors before the start."""
    monkeypatch.chdir(tmp_path)
    Path("busy.mcap.part").touch()
    with lock_file(Path("busy.mcap.part")), pytest.raises(SceneError, match=line):
        OPTIONS._replace(**options).check()


def test_cranes_beside_need_a_scene_with_commands(tmp_path: Path) -> None:
    """A scene without commands has no lockstep with other cranes: a line, exit 2, no recording."""
    record = tmp_path / "new" / "run.rrd"
    result = CliRunner().invoke(
        app, ["run", "overhead_swing", "--beside", "east", "--record", str(record)]
    )
    assert isinstance(result.exception, SceneError)  # exit code 2, see test_cli
    assert str(result.exception).startswith("--beside = east: overhead_swing takes no commands")
    assert not record.parent.exists()


def test_a_driven_crane_has_names_of_its_own(tmp_path: Path) -> None:
    """`crane drive` takes the options of a second crane in one domain, and passes them on."""
    given: dict[str, Any] = {
        each.name: None for each in drive.params if each.name in RunOptions._fields
    }
    given["record"] = tmp_path / "run.rrd"
    assert {"namespace", "frame_prefix"} <= given.keys()
    options = RunOptions.of_drive(given | {"namespace": "west", "frame_prefix": "west/"})
    options.check()
    assert {"namespace": "west", "frame_prefix": "west/"}.items() <= options.arguments(
        "any"
    ).items()


def test_options_are_arguments_of_the_run(tmp_path: Path) -> None:
    """Options reach the run under the names of its arguments, and --wait 0 is no limit."""
    record = tmp_path / "run.rrd"
    quick = OPTIONS._replace(mode="realtime", rate=2.0, wait=0.0, no_controller=True, record=record)
    quick.check()
    assert {"rate": 2.0, "wait": math.inf}.items() <= quick.arguments("knuckle_setpoint").items()
    parameters = signature(run).parameters
    assert OPTIONS._replace(record=record).arguments("any").keys() <= parameters.keys()


def test_a_killed_run_s_bag_is_not_in_the_way(tmp_path: Path) -> None:
    """The partial bag of a dead recorder is recovered by the next recorder."""
    Path(tmp_path, "run.mcap.part").touch()
    OPTIONS._replace(mcap=tmp_path / "run.mcap").check()


def test_mcap_needs_rosbags(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without rosbags --mcap is rejected with the package's name."""
    monkeypatch.setitem(sys.modules, "rosbags", None)
    with pytest.raises(SceneError, match="--mcap: needs the Python package rosbags"):
        OPTIONS._replace(mcap=Path("run.mcap")).check()


def test_checking_a_path_changes_no_file(tmp_path: Path) -> None:
    """The early check that a recording can be written keeps a killed recorder's file."""
    leftover = tmp_path / "run.rrd.part"
    leftover.write_bytes(b"rescue me")
    OPTIONS._replace(record=tmp_path / "run.rrd").arguments("knuckle_setpoint")
    assert leftover.read_bytes() == b"rescue me"
