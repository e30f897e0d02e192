"""Reading of recordings, from the kind of their file."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import TYPE_CHECKING

from crane_sim.files.installation import MissingPackage, import_optional
from crane_sim.recording.blocks import run_of_rollout
from crane_sim.recording.run import RecordedRun, UnreadableRecording

if TYPE_CHECKING:
    from crane_sim.simulation.rollout import Rollout


def read_recording(path: Path | str) -> RecordedRun:
    """Return a run of `crane run`, `crane simulate --record` or `Rollout.record` from FILE.rrd.

    Or the run in a bag FILE.mcap of `crane run --mcap`, without events and metrics; needs the
    package rosbags. What a killed run has left, FILE.rrd.part or FILE.mcap.part, is read likewise.
    Of a file that is cut or damaged the steps that are as they were written are returned;
    `RecordedRun.completeness` and a warning say so.

    Times `t` (K,) [s], positions `q` (K, nq), speeds `v` (K, nq), efforts `u` (K, nu), `payload`
    (K, 3) [m], ...: SI units, angles in rad, the names those of `Rollout`; see `RecordedRun`. Needs
    the package rerun-sdk.

    Raises:
        UnreadableRecording: the file is missing, is no recording, or nothing in it is good; a
            SceneError whose message is one line.
    """
    file = Path(path)
    if not is_recording(file):
        raise UnreadableRecording(
            f"{file}: {'is no file' if file.exists() else 'there is no such file'}"
        )
    is_bag = Path(file.name.removesuffix(".part")).suffix == ".mcap"
    try:
        if is_bag:
            run = import_optional("crane_sim.recording.bag", "a bag").read_bag_run(file)
        else:
            run = import_optional("crane_sim.recording.rerun.reader", "a recording").read_run(file)
    except MissingPackage as error:
        raise UnreadableRecording(f"{file}: {error}") from None
    if run.completeness.extent:
        logging.getLogger(__name__).warning("%s %s", file, run.completeness.extent)
    return run


def is_recording(path: Path) -> bool:
    """Whether there is a file of that name, or the folder of an unfinished bag."""
    return path.is_file() or (path.is_dir() and path.name.endswith(".mcap.part"))


def as_recorded(run: RecordedRun | Rollout) -> RecordedRun:
    """Return a run as it would be read back from its recording."""
    return run if isinstance(run, RecordedRun) else run_of_rollout(run)
