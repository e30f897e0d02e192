"""The files that recorders left who were killed: recovered where that is possible, and named."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

from crane_sim.orchestration.roles import RecorderRole
from crane_sim.recording.files import existing_parts, temporary_name
from crane_sim.recording.mcap.repair import repair_folder

_PACE = 5e7  # bytes/s of a bag that are read again on a slow machine


def recover_recordings(post: RecorderRole, summary: dict[str, Any], left: Callable[[], float]) -> dict[str, Any]:
    """Return what the summary says of a recording whose last recorder could not say so itself.

    Args:
        post: the recorder's place.
        summary: of the run, without steps where the plant could not say how many it took.
        left: returns the seconds that are left; what is not recovered when there are none stays as it is.
    """
    from crane_sim.recording.rerun.repair import repair  # needs Rerun

    temporary_name(Path(post.path)).unlink(missing_ok=True)
    parts = existing_parts(post.path, post.restarts + 1, post.began)
    steps = post.active.recorded
    if not (steps or summary.get("steps")):
        for part in parts:
            part.unlink()  # the run had not begun
        return {}
    files = [str(_is_part(file) and repair(file, left) or file) for file in parts]
    counts = {"recorded_steps": steps, "lost_steps": max(summary.get("steps", 0) - steps, 0)}
    return counts | {"recording": files[-1] if files else None} | ({"parts": files} if files[1:] else {})


def recover_bags(post: RecorderRole, last: str | None, left: Callable[[], float]) -> dict[str, Any]:
    """Return what the summary says of the bag's files, after recovering those of recorders that were killed.

    Args:
        post: the recorder's place.
        last: what the last recorder has finished, None where it could not.
        left: as of `recover_recordings`; the next run to the same path recovers what stays.
    """
    if not post.mcap:
        return {}
    parts = existing_parts(post.mcap, post.restarts + (0 if last else 1), post.began)
    files = [*filter(None, (_recover(file, left) for file in parts)), *([last] if last else [])]
    return {"mcap": files[-1] if files else None} | ({"bag_parts": files} if files[1:] else {})


def _is_part(file: Path) -> bool:
    return file.suffix == ".part"


def _recover(file: Path, left: Callable[[], float]) -> str:
    """Return what has become of a bag; nothing where nothing was saved in it."""
    if not _is_part(file):
        return str(file)
    size = sum(grown.stat().st_size for grown in file.iterdir())
    if size > _PACE * left():
        return str(file)
    try:
        recovered = repair_folder(file, left)
    except OSError:
        return str(file)  # the disk is full or gone, or somebody waits for the end: it stays as it is
    return str(recovered or (file if file.exists() else ""))
