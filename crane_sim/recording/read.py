"""Reading of recordings, from the kind of their file."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from types import ModuleType

from crane_sim.files.installation import MissingPackage
from crane_sim.recording.run import RecordedRun, UnreadableRecording


def read_recording(path: Path | str) -> RecordedRun:
    """Return the run in a recording FILE.rrd of `crane run`, `crane simulate --record` or `Rollout.record`.

    Or the run in a bag FILE.mcap of `crane run --mcap`, without events and metrics; needs the package rosbags, too.

    Times `t` (K,) [s], positions `q` (K, nq), speeds `v` (K, nq), efforts `u` (K, nu), `payload` (K, 3) [m], ...: SI
    units, angles in rad, the names those of `Rollout`; see `RecordedRun`. Needs the package rerun-sdk.

    Raises:
        UnreadableRecording: the file is missing, damaged or no recording; a SceneError whose message is one line.
    """
    file = Path(path)
    if not file.is_file():
        raise UnreadableRecording(f"{file}: {'is no file' if file.exists() else 'there is no such file'}")
    try:
        if file.suffix == ".mcap":
            return _import_reader("bag_reader").read_bag_run(file)
        return _import_reader("reader").read_run(file)
    except MissingPackage as error:
        raise UnreadableRecording(f"{file}: {error}") from None


def _import_reader(name: str) -> ModuleType:
    return import_module(f"crane_sim.recording.rerun.{name}")  # by name: a layer above, whose packages are optional
