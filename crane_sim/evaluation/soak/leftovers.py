"""Complaints about what an interrupted run has left: files, processes."""

import os
import signal
from pathlib import Path

from crane_sim.recording.rerun.reader import read_curves, read_summary

RECORDING, BAG = "run.rrd", "run.mcap"
MARK = "CRANE_SIM_SOAK"  # the variable by which the processes of a run are known


def of_run(folder: Path, heard: int) -> list[str]:
    """Return what is wrong with the files of a run of which somebody has heard so many steps."""
    strangers = [f"left: {file.name}" for file in sorted(folder.iterdir()) if file.name not in (RECORDING, BAG)]
    return strangers + _of_recording(folder / RECORDING, heard) + _of_bag(folder / BAG, folder / RECORDING)


def orphans(mark: str) -> list[str]:
    """Return a complaint about every process that has outlived its run, and end it."""
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}".encode() in (folder / "environ").read_bytes():
                found.append(f"outlives the run: {(folder / 'cmdline').read_bytes().replace(bytes(1), b' ').decode()}")
                os.kill(int(folder.name), signal.SIGKILL)
        except OSError:
            continue
    return found


def steps_in(recording: Path) -> list[int]:
    """Return the steps of which a recording has the state."""
    return read_curves(recording, "plots/q").step.tolist()


def _of_recording(path: Path, heard: int) -> list[str]:
    if not path.exists():
        return [f"no recording of {heard} steps"] if heard else []
    summary = read_summary(path)
    told = summary["recorded_steps"]
    found = steps_in(path) if told else []
    whole = found == list(range(1, told + 1)) and not summary["lost_steps"] and told >= heard
    return [] if whole else [f"recording: {len(found)} steps, its summary says {told}, heard {heard}"]


def _of_bag(path: Path, recording: Path) -> list[str]:
    """Return what a bag lacks that the recording has."""
    if not (path.exists() and recording.exists()):
        return []
    from rosbags.rosbag2 import Reader  # not everyone has it

    with Reader(path) as bag:
        found = {connection.topic.rpartition("/")[2]: connection.msgcount for connection in bag.connections}
    steps = read_summary(recording)["recorded_steps"]
    whole = found["joint_states"] > steps and found["applied_effort"] >= steps
    return [] if whole or not steps else [f"bag: {found} messages, the recording has {steps} steps"]
