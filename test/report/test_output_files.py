"""Output files appear whole or not at all: on a full disk one line names them, nothing is left."""

import os
import resource
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import pytest
from process_helpers import run_to_completion

import crane_sim
from crane_sim.files.output import partial_files, write_text, write_whole
from crane_sim.recording.comparison import Comparison, compare
from crane_sim.report.figure import save_comparison_figure, save_run_figure
from crane_sim.report.page import save_comparison, save_page
from crane_sim.report.plotting import save_figure
from crane_sim.simulation.rollout import Rollout

FULL = 4096  # bytes, the most of a file that this disk holds
DEADLINE = 200.0  # s, of a program that takes a few


@contextmanager
def full_disk() -> Iterator[None]:
    """Let no file grow beyond `FULL` bytes in the block: more is refused, as by a full disk.

    No bytecode is written meanwhile: Python 3.11 keeps the part that fits, on which every later
    import fails.
    """
    limits, without_bytecode = resource.getrlimit(resource.RLIMIT_FSIZE), sys.dont_write_bytecode
    sys.dont_write_bytecode = True
    resource.setrlimit(resource.RLIMIT_FSIZE, (FULL, limits[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        sys.dont_write_bytecode = without_bytecode


@cache
def rollout() -> Rollout:
    """Return a short run."""
    return crane_sim.simulate("overhead_energy", duration=0.2)


@cache
def comparison() -> Comparison:
    """Return that run beside itself."""
    return compare(rollout(), rollout())


def draw(figure: Any, _: object) -> None:
    """Draw what takes more than a few bytes."""
    figure.subplots().plot(range(99), [k * k % 97 for k in range(99)])


WRITERS: dict[str, Callable[[Path], object]] = {
    "page.html": lambda file: save_page(comparison().runs[0], file),
    "pages.html": lambda file: save_comparison(comparison(), file),
    "figure.svg": lambda file: save_comparison_figure(comparison(), file),
    "figure.pdf": lambda file: save_run_figure(comparison().runs[0], file),
    "of_a_page.png": lambda file: save_figure(draw, None, file, dpi=110),
    "text.md": lambda file: write_text(file, "x" * (FULL + 1)),
}


RECORD = """
import resource, sys
from pathlib import Path
import crane_sim
from crane_sim.recording.comparison import compare
from crane_sim.recording.rerun.comparison import record_comparison
from crane_sim.recording.rerun.part_file import RecordingError

file, run = Path(sys.argv[1]), crane_sim.simulate("overhead_energy", duration=0.2)
both, (_, most) = compare(run, run), resource.getrlimit(resource.RLIMIT_FSIZE)
for write in (run.record, lambda path: record_comparison(both, path)):
    whole = write(file).stat().st_size
    file.unlink()
    for limit in (0, whole // 2, 19 * whole // 20):
        resource.setrlimit(resource.RLIMIT_FSIZE, (limit, most))
        try:
            write(file)
        except RecordingError as error:
            print(error, *file.parent.iterdir())
    resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))
write(file)
"""


def test_a_full_disk_leaves_no_part_of_a_recording(tmp_path: Path) -> None:
    """`simulate --record` and a comparison give one line with the file each, and leave nothing.

    Wherever the disk becomes full: from the first byte on, or in the index at the end. The next
    recording is written.
    """
    file, environment = tmp_path / "run.rrd", os.environ | {"CRANE_SIM_INTERPRETED": "1"}
    done = run_to_completion(
        [sys.executable, "-c", RECORD, str(file)], env=environment, limit=DEADLINE
    )
    lines = done.stdout.splitlines()
    assert done.returncode == 0, done.stderr
    assert len(lines) == 6 and all(
        f"recording {file}.part: File too large (" in line for line in lines
    )
    assert all(line.endswith(" on its disk)") for line in lines)  # and no file behind it
    assert [entry.name for entry in tmp_path.iterdir()] == [file.name]


@pytest.mark.parametrize("name", WRITERS)
def test_a_full_disk_leaves_no_part_of_a_file(name: str, tmp_path: Path) -> None:
    """An unwritable file raises one line with its name, and leaves a previous file as it was."""
    if find_spec("matplotlib") is None and not name.endswith((".html", ".md")):
        pytest.skip("matplotlib is not installed")
    file = tmp_path / name
    comparison()
    for before in ("", "what was there"):
        if before:
            file.write_text(before)
        with full_disk(), pytest.raises((crane_sim.SceneError, OSError)) as error:
            WRITERS[name](file)
        assert "\n" not in str(error.value)
        assert isinstance(error.value, OSError) or str(file) in str(error.value)
        assert [(entry.name, entry.read_text()) for entry in tmp_path.iterdir()] == (
            [(name, before)] if before else []
        )


def test_a_writer_that_fails_leaves_nothing(tmp_path: Path) -> None:
    """Any error or interruption removes the part; what a killed process left is found."""

    def fail(path: Path) -> None:
        path.write_text("half")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_whole(tmp_path / "run.png", fail)
    assert list(tmp_path.iterdir()) == []
    left = tmp_path / ".run.png.1234.png"
    left.touch()
    assert list(partial_files(tmp_path / "run.png")) == [left]
