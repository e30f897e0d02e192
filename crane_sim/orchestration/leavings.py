"""The files that recorders left who were killed: recovered where that is possible, and named."""

import time
from pathlib import Path
from typing import Any

from crane_sim.orchestration.posts import RecorderPost
from crane_sim.recording.mcap_repair import repair_folder
from crane_sim.recording.part_names import joining, part_of, unfinished

_PACE = 5e7  # bytes/s of a bag that are read again on a slow machine


def recordings(post: RecorderPost, summary: dict[str, Any], until: float) -> dict[str, Any]:
    """Return what the summary says of a recording whose last recorder could not say so itself.

    Args:
        post: the recorder's place.
        summary: of the run, without steps where the plant could not say how many it took.
        until: instant of the monotonic clock [s]; what cannot be recovered by then stays as it is.
    """
    from crane_sim.recording.repair import repair  # needs Rerun

    joining(Path(post.path)).unlink(missing_ok=True)
    found = _left(post, post.path, post.restarts + 1)
    steps = post.holder.recorded
    if not (steps or summary.get("steps")):
        for part in found:
            part.unlink()  # the run had not begun
        return {}
    files = [str(_is_part(file) and repair(file, until - time.monotonic()) or file) for file in found]
    counts = {"recorded_steps": steps, "lost_steps": max(summary.get("steps", 0) - steps, 0)}
    return counts | {"recording": files[-1] if files else None} | ({"parts": files} if files[1:] else {})


def bags(post: RecorderPost, last: str | None, until: float) -> dict[str, Any]:
    """Return what the summary says of the bag's files, after recovering those of recorders that were killed.

    Args:
        post: the recorder's place.
        last: what the last recorder has finished, None where it could not.
        until: as of `recordings`; the next run to the same path recovers what stays.
    """
    if not post.mcap:
        return {}
    found = _left(post, post.mcap, post.restarts + (0 if last else 1))
    files = [*filter(None, (_recovered(file, until) for file in found)), *([last] if last else [])]
    return {"mcap": files[-1] if files else None} | ({"bag_parts": files} if files[1:] else {})


def _left(post: RecorderPost, path: str, count: int) -> list[Path]:
    """Return the first `count` parts of a file that are there, and of this run, not of an earlier one."""
    wholes = [part_of(path, number) for number in range(1, count + 1)]
    candidates = [file for whole in wholes for file in (unfinished(whole), whole)]
    return [file for file in candidates if file.exists() and file.stat().st_mtime >= post.began]


def _is_part(file: Path) -> bool:
    return file.suffix == ".part"


def _recovered(file: Path, until: float) -> str:
    """Return what has become of a bag; nothing where nothing was saved in it."""
    if not _is_part(file):
        return str(file)
    size = sum(grown.stat().st_size for grown in file.iterdir())
    if size > _PACE * (until - time.monotonic()):
        return str(file)
    try:
        recovered = repair_folder(file)
    except OSError:
        return str(file)  # the disk is full or gone: it stays as it is
    return str(recovered or (file if file.exists() else ""))
