"""Reading of recordings, from the kind of their file."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

from crane_sim.recording.run import RecordedRun, UnreadableRecording


def read_recording(path: Path | str) -> RecordedRun:
    """Return the run in a recording FILE.rrd of `crane run`, `crane simulate --record` or `Rollout.record`.

    Times `t` (K,) [s], positions `q` (K, nq), speeds `v` (K, nq), efforts `u` (K, nu), `payload` (K, 3) [m], ...: SI
    units, angles in rad, the names those of `Rollout`; see `RecordedRun`. Needs the package rerun-sdk.

    Raises:
        UnreadableRecording: the file is missing, damaged or no recording; a SceneError whose message is one line.
    """
    file = Path(path)
    if not file.is_file():
        raise UnreadableRecording(f"{file}: {'is no file' if file.exists() else 'there is no such file'}")
    if file.suffix == ".mcap":
        raise UnreadableRecording(f"{file}: has the messages alone, no scene and no figures; read the .rrd of the run")
    try:
        reader = import_module("crane_sim.recording.rerun.reader")  # by name: a layer above, whose package is optional
    except ModuleNotFoundError as error:
        raise UnreadableRecording(f"{file}: reading needs the Python package rerun-sdk ({error.name})") from None
    return reader.read_run(file)
