"""The end of a run: what the nodes add to its summary, and what is missing."""

import json
import signal
import time
from collections.abc import Callable, Sequence
from typing import Any

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.recovery import recover_bags, recover_recordings
from crane_sim.orchestration.roles import RecorderRole, Role
from crane_sim.orchestration.supervisor import Supervisor
from crane_sim.recording.files import files_before_resets

_WIND_UP = 10.0, 0.3  # s for a law to report; where somebody waits for the end
_WRITE = 120.0  # s for the recorder to finish the file; where somebody waits, what is left
_UNFINISHED = "it did not finish the recording"
_KILLED = 0.2  # s for a process to end that was killed


def collect_controller_summary(conductor: Supervisor, posts: Sequence[Role]) -> dict[str, Any]:
    """Let the law's processes come to their end; return what they add to the summary."""
    laws = [post.active for post in posts if post.name in ("controller", "tracker")]
    for child in laws:
        child.order("finish")
    conductor.drain([child for child in laws if child.ready], *_WIND_UP)
    return {key: value for child in laws for key, value in (child.summary or {}).items()}


def finish_recording(conductor: Supervisor, post: RecorderRole | None, summary: dict[str, Any]) -> dict[str, Any]:
    """Let the recorder finish its files with the summary, and add what it says to the summary.

    Args:
        conductor: of the run.
        post: the recorder's place, None where nobody records.
        summary: so far; without steps where the plant could not say how many it took.
    """
    nothing = {"recording": None, "recorded_steps": 0, "lost_steps": 0}
    if post is None:
        return summary | nothing
    own = _wait_finished(conductor, post, summary)
    if own is None and post.path:
        nothing |= recover_recordings(post, summary, _time_for(conductor))
    merged = summary | nothing | (own or {})
    merged |= recover_bags(post, merged.get("mcap"), _time_for(conductor))
    if earlier := [
        str(file) for path in (post.path, post.mcap) if path for file in files_before_resets(path, post.began)
    ]:
        merged["before_reset"] = earlier
    merged.setdefault("steps", max(conductor.plant.step, merged["recorded_steps"]))
    first, theirs = summary.get("error", ""), (own or {}).get("error", "")  # what the plant says comes first
    if not theirs and (post.failed or not first):
        theirs = _missing(own, post, merged)
    error = "; ".join(filter(None, (first, theirs)))
    return merged | ({"error": error} if error else {})


def _time_for(conductor: Supervisor) -> Callable[[], float]:
    """Return what tells the seconds that are left for files: fewer as soon as somebody waits for the end."""
    until = time.monotonic() + _WRITE
    return lambda: min(until - time.monotonic(), conductor.left)


def _wait_finished(conductor: Supervisor, post: RecorderRole, summary: dict[str, Any]) -> dict[str, Any] | None:
    """Return what the recorder says of its files, None where it cannot, or not in time; if it dies, the next one.

    The summary gets to know of that.
    """
    _order_end(conductor, post.active, summary)
    while _describe_death(post.active) and not conductor.shutting_down and conductor.fail_over(post):
        summary["restarts"] = summary.get("restarts", {}) | {post.name: post.restarts}
        _order_end(conductor, post.active, summary)
    recorder = post.active
    if recorder.summary is None:
        recorder.send_signal(signal.SIGKILL)  # before it makes a file that nobody would finish
        recorder.ended_by(time.monotonic() + _KILLED)
    return recorder.summary


def _order_end(conductor: Supervisor, recorder: Child, summary: dict[str, Any]) -> None:
    if recorder.ready or not conductor.shutting_down:
        within = min(_WRITE, conductor.left)
        recorder.order(f"finish {json.dumps({'within': within, 'summary': summary})}")
        conductor.drain([recorder], _WRITE)


def _describe_death(recorder: Child) -> bool:
    return recorder.gone and recorder.summary is None


def _missing(own: dict[str, Any] | None, post: RecorderRole, merged: dict[str, Any]) -> str:
    """Return one line on what the files lack, empty where that is nothing."""
    counts = f"it has {merged['recorded_steps']} of {merged['steps']} steps"
    if own is None:
        found = f"; {merged['recording'] or 'the recording'} is incomplete, {counts}" if post.path else ""
        found += f"; {merged.get('mcap') or 'the bag'} is incomplete" if post.mcap else ""
        return f"{post.failed or f'recorder: {post.active.fault or _UNFINISHED}'}{found}"
    if post.path and (merged["lost_steps"] or merged["recorded_steps"] != merged["steps"]):
        return f"recorder: the recording is incomplete, {counts}"
    return ""
