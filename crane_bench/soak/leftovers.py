"""Failures about files and processes that remain after an interrupted run."""

import os
import signal
from pathlib import Path

from crane_sim.recording.rerun.reader import read_curves, read_summary

RECORDING, BAG = "run.rrd", "run.mcap"
MARK = "CRANE_SIM_SOAK"  # environment variable that marks the processes of a run


def of_run(folder: Path, received: int) -> list[str]:
    """Return failures about a run's files, given that a subscriber received `received` steps."""
    others = [
        f"left: {file.name}"
        for file in sorted(folder.iterdir())
        if file.name not in (RECORDING, BAG)
    ]
    return (
        others
        + _of_recording(folder / RECORDING, received)
        + _of_bag(folder / BAG, folder / RECORDING)
    )


def orphans(mark: str) -> list[str]:
    """Return a failure about every process that has outlived its run, and end it."""
    failures = []
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            if f"{MARK}={mark}".encode() in (folder / "environ").read_bytes():
                command = (folder / "cmdline").read_bytes().replace(bytes(1), b" ").decode()
                failures.append(f"outlives the run: {command}")
                os.kill(int(folder.name), signal.SIGKILL)
        except OSError:
            continue
    return failures


def steps_in(recording: Path) -> list[int]:
    """Return the steps of which a recording has the state."""
    return read_curves(recording, "plots/q").step.tolist()


def _of_recording(path: Path, received: int) -> list[str]:
    if not path.exists():
        return [f"no recording of {received} steps"] if received else []
    summary = read_summary(path)
    counted = summary["recorded_steps"]
    steps = steps_in(path) if counted else []
    complete = (
        steps == list(range(1, counted + 1)) and not summary["lost_steps"] and counted >= received
    )
    return (
        []
        if complete
        else [f"recording: {len(steps)} steps, its summary says {counted}, received {received}"]
    )


def _of_bag(path: Path, recording: Path) -> list[str]:
    """Return a failure where a bag lacks steps of the recording."""
    if not (path.exists() and recording.exists()):
        return []
    from rosbags.rosbag2 import Reader  # optional

    with Reader(path) as bag:
        counts = {
            connection.topic.rpartition("/")[2]: connection.msgcount
            for connection in bag.connections
        }
    steps = read_summary(recording)["recorded_steps"]
    complete = counts["joint_states"] > steps and counts["applied_effort"] >= steps
    return (
        []
        if complete or not steps
        else [f"bag: {counts} messages, the recording has {steps} steps"]
    )
