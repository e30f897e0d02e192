"""The end of a run: what the nodes add to its summary, and what is missing."""

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from crane_sim.orchestration.conductor import Conductor
from crane_sim.orchestration.posts import Post
from crane_sim.recording.part_names import part_of

_WIND_UP = 10.0, 0.4  # s for a law to report; where somebody waits for the end
_WRITE = 120.0, 2.0  # s for the recorder to finish the file; where somebody waits
_KILLED = 1.0, 1.0  # s for a process to end that was killed


def told(conductor: Conductor, posts: Sequence[Post]) -> dict[str, Any]:
    """Let the law's processes come to their end; return what they add to the summary."""
    laws = [post.holder for post in posts if post.name in ("controller", "tracker")]
    for child in laws:
        child.order("finish")
    conductor.hear_out([child for child in laws if child.ready], *_WIND_UP)
    return {key: value for child in laws for key, value in (child.summary or {}).items()}


def recorded(conductor: Conductor, post: Post | None, path: str, summary: dict[str, Any]) -> dict[str, Any]:
    """Let the recorder finish its files with the summary, and add what it says to the summary.

    Args:
        conductor: of the run.
        post: the recorder's place, None where nobody records.
        path: of the recording, empty where there is none.
        summary: so far; without steps where the plant could not say how many it took.
    """
    nothing = {"recording": None, "recorded_steps": 0, "lost_steps": 0}
    if post is None:
        return summary | nothing
    recorder = post.holder
    if recorder.ready or not conductor.hurried:
        recorder.order(f"finish {json.dumps(summary)}")
        conductor.hear_out([recorder], *_WRITE)
    else:
        recorder.kill()  # before it makes a file that nobody would finish
        conductor.hear_out([recorder], *_KILLED)
    if recorder.summary is None and path:
        nothing |= _left(post, path, summary)
    merged = summary | nothing | (recorder.summary or {})
    merged.setdefault("steps", max(conductor.plant.step, merged["recorded_steps"]))
    if error := summary.get("error", merged.get("error")):  # what the plant says comes first
        return merged | {"error": error}
    return merged | _missing(recorder.summary, recorder.fault, path, merged)


def _missing(own: dict[str, Any] | None, fault: str, path: str, merged: dict[str, Any]) -> dict[str, str]:
    counts = f"it has {merged['recorded_steps']} of {merged['steps']} steps"
    if own is None:
        told = f"; {merged['recording'] or 'the recording'} is incomplete, {counts}" if path else ""
        return {"error": f"recorder: {fault or 'it did not finish the recording'}{told}"}
    if path and (merged["lost_steps"] or merged["recorded_steps"] != merged["steps"]):
        return {"error": f"recorder: the recording is incomplete, {counts}"}
    return {}


def _left(post: Post, path: str, summary: dict[str, Any]) -> dict[str, Any]:
    """Return what a recorder that could not say so itself has left: an unfinished file, recovered where possible."""
    from crane_sim.recording.repair import repair  # needs Rerun

    parts = [Path(f"{part_of(path, number)}.part") for number in range(1, post.restarts + 2)]
    found, steps = [part for part in parts if part.exists()], post.holder.recorded
    if not (steps or summary.get("steps")):
        for part in found:
            part.unlink()  # the run had not begun
        return {}
    files = [str(repair(part) or part) for part in found]
    counts = {"recorded_steps": steps, "lost_steps": max(summary.get("steps", 0) - steps, 0)}
    return counts | {"recording": files[-1] if files else None} | ({"parts": files} if files[1:] else {})
