"""Recovery of the files of killed recorders; the summary names what was and was not recovered."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from crane_sim.orchestration.roles import RecorderRole
from crane_sim.recording.files import existing_parts, temporary_name

_READ_RATE = 1e7  # bytes/s of a bag that is copied, on a slow machine


def recover_recordings(
    role: RecorderRole, summary: dict[str, Any], time_left: Callable[[], float]
) -> dict[str, Any]:
    """Return the summary's entries on a recording whose last recorder did not report any.

    Args:
        role: the recorder's.
        summary: of the run, without steps where the plant could not report how many it took.
        time_left: returns the seconds that are left; a file that is not recovered by then stays as
            it is.
    """
    from crane_sim.recording.rerun.repair import repair  # needs Rerun

    temporary_name(Path(role.path)).unlink(missing_ok=True)
    parts = existing_parts(role.path, role.restarts + 1, role.start_time)
    steps = role.active.recorded
    if not (steps or summary.get("steps")):
        for part in parts:
            part.unlink()  # no step was taken
        return {}
    files = [str(_is_part(file) and repair(file, time_left) or file) for file in parts]
    lost = role.active.lost_commands
    counts = {"recorded_steps": steps, "lost_steps": max(summary.get("steps", 0) - steps, 0) + lost}
    counts |= {"lost_commands": lost} if lost else {}
    return (
        counts
        | {"recording": files[-1] if files else None}
        | ({"parts": files} if files[1:] else {})
    )


def recover_bags(
    role: RecorderRole, last: str | None, time_left: Callable[[], float]
) -> dict[str, Any]:
    """Return the summary's entries on the bag's files, after recovering those of killed recorders.

    Args:
        role: the recorder's.
        last: the file that the last recorder has finished, None where it could not.
        time_left: see `recover_recordings`; the next run to the same path recovers what stays.
    """
    if not role.mcap:
        return {}
    parts = existing_parts(role.mcap, role.restarts + (0 if last else 1), role.start_time)
    files = [
        *filter(None, (_recover(file, time_left) for file in parts)),
        *([last] if last else []),
    ]
    return {"mcap": files[-1] if files else None} | ({"bag_parts": files} if files[1:] else {})


def _is_part(file: Path) -> bool:
    return file.suffix == ".part"


def _recover(file: Path, time_left: Callable[[], float]) -> str:
    """Return the name of a bag after its recovery; empty where it had no messages."""
    if not _is_part(file):
        return str(file)
    from crane_sim.recording.mcap.file import recover_bag  # needs rosbags and mcap

    if file.stat().st_size > _READ_RATE * time_left():
        return str(file)
    try:
        recovered = recover_bag(file, time_left)
    except OSError:
        return str(file)  # the disk is full or gone, or the time is over: it stays as it is
    return str(recovered or (file if file.exists() else ""))
