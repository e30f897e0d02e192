"""The commands around a recording: `simulate --record`, `plot`, `report`."""

from pathlib import Path

import pytest
from command_line import crane, crane_here

CUT = 3000  # bytes: in the middle of the file's first messages


def test_a_run_is_recorded_drawn_and_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A recorded run without ROS becomes a figure and a page; a cut file one line and exit 2."""
    run, page, figure = tmp_path / "run.rrd", tmp_path / "new" / "run.html", tmp_path / "run.svg"
    done = crane("simulate", "--duration", "0.1", "--record", str(run), "--json")
    assert done.returncode == 0 and f'"recording": "{run}"' in done.stdout, done.stderr
    for command, file in (("report", page), ("plot", figure)):
        done = crane_here(monkeypatch, capsys, command, str(run), "-o", str(file))
        assert (done.returncode, done.stdout) == (0, f"{file}\n") and file.stat().st_size > 0, (
            done.stderr
        )
    Path(tmp_path, "cut.rrd").write_bytes(run.read_bytes()[:CUT])
    done = crane_here(
        monkeypatch, capsys, "report", str(tmp_path / "cut.rrd"), "-o", str(tmp_path / "cut.html")
    )
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and "cut off" in done.stderr
    assert not Path(tmp_path, "cut.html").exists()


def test_an_impossible_recording_is_refused_before_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A recording that would be a folder is refused in one line."""
    done = crane_here(
        monkeypatch, capsys, "simulate", "--duration", "0.1", "--record", str(tmp_path)
    )
    assert done.returncode == 2 and done.stderr == f"crane: --record {tmp_path}: is a folder\n"
