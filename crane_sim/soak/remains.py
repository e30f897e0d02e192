"""Complaints about the files that an interrupted run has left."""

from pathlib import Path

from crane_sim.recording.reading import read_curves, read_summary


def of_recording(path: Path) -> list[str]:
    """Return what is wrong with a recording; there may be none, but no part of one."""
    left = [f"left: {file.name}" for file in path.parent.glob("*.part")]
    if not path.exists():
        return left
    summary = read_summary(path)
    if not summary["recorded_steps"]:
        return left
    steps = read_curves(path, "plots/q").step.tolist()
    whole = steps == list(range(1, summary["recorded_steps"] + 1)) and not summary["lost_steps"]
    return left if whole else [*left, f"recording: {len(steps)} steps, summary {summary['recorded_steps']}"]


def of_bag(path: Path, recording: Path) -> list[str]:
    """Return what a bag lacks that the recording has."""
    if not (path.exists() and recording.exists()):
        return []
    from rosbags.rosbag2 import Reader  # not everyone has it

    with Reader(path) as bag:
        found = {connection.topic.rpartition("/")[2]: connection.msgcount for connection in bag.connections}
    steps = read_summary(recording)["recorded_steps"]
    whole = found["joint_states"] > steps and found["applied_effort"] >= steps
    return [] if whole or not steps else [f"bag: {found} messages, the recording has {steps} steps"]
