"""A recording survives its recorder, and a recorder reports write errors."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import rerun as rr
from mcap_samples import TOPICS, feed, read
from process_helpers import run_to_completion
from recording_samples import SCENE, STEPS, RowWriter

from crane_sim import simulate
from crane_sim.recording.files import unfinished_name
from crane_sim.recording.mcap.bag import Bag
from crane_sim.recording.rerun.part_file import RecordingError
from crane_sim.recording.rerun.reader import read_curves
from crane_sim.recording.rerun.repair import repair, repair_leftovers

CHILD = """
import os, resource, signal, sys
from pathlib import Path
from recording_samples import SCENE, RowWriter, steps_of
from crane_sim.recording.rerun.part_file import RecordingError

rows, session = list(steps_of(SCENE)), RowWriter(SCENE, Path(sys.argv[1]))
if sys.argv[2] == "killed":
    session.write_rows(rows[:500])
    os.kill(os.getpid(), signal.SIGKILL)
resource.setrlimit(resource.RLIMIT_FSIZE, (800_000, 800_000))
try:
    for first in range(0, len(rows), 50):
        session.write_rows(rows[first:first + 50])
except RecordingError as error:
    print(session.recorded, error, sep="|", flush=True)
    os._exit(3)
"""


def child(program: str, path: Path, end: str = "killed") -> subprocess.CompletedProcess[str]:
    """Record in another process that comes to a bad end."""
    test = Path(__file__).parents[1]
    env = os.environ | {"PYTHONPATH": os.pathsep.join([str(test / "helpers"), str(test.parent)])}
    command = [sys.executable, "-c", program, str(path), end]
    return run_to_completion(command, env=env)


def test_a_killed_recorder_loses_nothing_it_wrote(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """After SIGKILL the next run of that name recovers every written step, and says so."""
    path, recovered = tmp_path / "run.rrd", tmp_path / "run.recovered.rrd"
    assert child(CHILD, path, "killed").returncode == -9
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.rrd.part"]
    run = simulate(SCENE, duration=0.3)
    run.record(path)
    line = f"{path}.part was left by a killed run: recovered as {recovered}"
    assert [each.getMessage() for each in caplog.records] == [line]
    assert np.array_equal(read_curves(recovered, "plots/q").step, np.arange(1, 501))
    assert np.array_equal(read_curves(path, "plots/q").values, run.q[:-1])
    assert not unfinished_name(path).exists()


def test_a_living_recorder_s_part_is_unchanged(tmp_path: Path) -> None:
    """A file that is still being written is not taken for a leftover."""
    session = RowWriter(SCENE, tmp_path / "run.rrd")
    assert repair_leftovers(tmp_path) == []
    session.finish({})
    assert (tmp_path / "run.rrd").exists()


def test_a_folder_that_is_gone_is_an_error_of_the_recording(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recording whose folder was removed ends in one line, on a failing disk or renaming."""
    folder = tmp_path / "gone"
    session = RowWriter(SCENE, folder / "run.rrd")
    shutil.rmtree(folder)
    with pytest.raises(RecordingError, match=r"run\.rrd\.part: No such file"):
        session.finish({})

    def fail(*_: object, **__: object) -> None:
        raise RuntimeError("no disk")

    monkeypatch.setattr(rr.RecordingStream, "flush", fail)
    with pytest.raises(RecordingError, match=r"run\.rrd\.part: no disk \(its folder: No such file"):
        session.finish({})


def test_unrecoverable_files_are_unchanged(tmp_path: Path) -> None:
    """A leftover from which nothing can be recovered stays where it is."""
    part = tmp_path / "run.rrd.part"
    part.write_bytes(b"not a recording")
    assert repair(part) is None
    assert [entry.name for entry in tmp_path.iterdir()] == ["run.rrd.part"]


def test_a_full_disk_is_noticed(tmp_path: Path) -> None:
    """A block that does not reach the disk is an error with the file's name; other blocks stay.

    The error is one line.
    """
    done = child(CHILD, tmp_path / "run.rrd", "full")
    recorded, _, why = done.stdout.strip().partition("|")
    assert done.returncode == 3, done.stderr
    assert str(tmp_path / "run.rrd.part") in why and "\n" not in why
    recovered = repair(tmp_path / "run.rrd.part")
    assert recovered is not None
    assert 0 < int(recorded) <= len(read_curves(recovered, "plots/q").step) < STEPS


MCAP_CHILD = """
import os, signal, sys
from pathlib import Path
from mcap_samples import TOPICS, STATE_CODEC, SCENE
from crane_sim.recording.mcap.file import McapFile

file = McapFile(Path(sys.argv[1]), list(TOPICS.values()))
for k in range(1, 31):
    file.write(0, k * SCENE.period_ns, STATE_CODEC.encode(k * SCENE.period_ns, (float(k),) * 6, (0.0,) * 6, (0.0,) * 6))
    if k == 20:
        file.save()
os.kill(os.getpid(), signal.SIGKILL)
"""  # noqa: E501


def test_a_killed_recorder_s_file_is_recovered(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """After SIGKILL the next recorder of the same name names the readable, recovered file."""
    path = tmp_path / "run.mcap"
    assert child(MCAP_CHILD, path).returncode == -9
    with unfinished_name(path).open("ab") as file:
        file.write(b"\x06\xff\xff")  # a chunk that was cut
    bag = Bag(path, TOPICS, SCENE.period_ns)
    feed(bag, 5)
    bag.finish({"steps": 5})
    assert "recovered as" in caplog.text
    recovered = read(tmp_path / "run.recovered.mcap")["/knuckle/joint_states"]
    assert [message.position[0] for _, message in recovered] == list(range(1, 21))
    assert {file.name for file in tmp_path.iterdir()} == {"run.mcap", "run.recovered.mcap"}


def test_a_living_recorder_s_file_is_unchanged(tmp_path: Path) -> None:
    """A second recorder of the same file is refused; the first one's file is complete."""
    bag = Bag(tmp_path / "run.mcap", TOPICS, SCENE.period_ns)
    with pytest.raises(FileExistsError, match="another run is writing it"):
        Bag(tmp_path / "run.mcap", TOPICS, SCENE.period_ns)
    feed(bag, 3)
    assert bag.finish({"steps": 3}) == {"mcap": str(tmp_path / "run.mcap")}
