"""Shutdown of a run: one summary of its nodes' reports, which says what is missing in the files."""

import json
import signal
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from crane_sim.orchestration.child import Child
from crane_sim.orchestration.recovery import recover_bags, recover_recordings
from crane_sim.orchestration.roles import RecorderRole, Role
from crane_sim.orchestration.supervisor import Supervisor
from crane_sim.recording.files import describe_gaps, files_before_resets
from crane_sim.ros.common.refused_messages import REFUSED, refused_entry

_SUMMARY_TIMEOUT = 10.0  # s for a controller to report its summary
_SHUTDOWN_SUMMARY_TIMEOUT = 0.3  # s for that once a shutdown is requested
# s to finish files, to join recordings, and to join bags; in a shutdown, the time that is left
_FILES_TIMEOUT = 120.0
_UNFINISHED = "it did not finish the recording"
_KILL_TIMEOUT = 0.2  # s for a killed process to exit


def collect_controller_summary(supervisor: Supervisor, roles: Sequence[Role]) -> dict[str, Any]:
    """Order the controllers' processes to finish; return what they add to the summary."""
    controllers = [
        role.active for role in roles if role.name in ("controller", "tracker", "operator")
    ]
    for child in controllers:
        child.send("finish")
    ready = [child for child in controllers if child.ready]
    supervisor.drain(ready, _SUMMARY_TIMEOUT, _SHUTDOWN_SUMMARY_TIMEOUT)
    return merge_summaries(*(child.summary or {} for child in controllers))


def merge_summaries(*parts: Mapping[str, Any]) -> dict[str, Any]:
    """Return one summary of several nodes that refuse the same messages: the largest counts."""
    merged = {key: value for part in parts for key, value in part.items()}
    refused = [part.get(REFUSED, {}) for part in parts]
    counts = {key: max(each.get(key, 0) for each in refused) for each in refused for key in each}
    return merged | refused_entry(dict(sorted(counts.items())))


def finish_recording(
    supervisor: Supervisor, role: RecorderRole | None, summary: dict[str, Any]
) -> dict[str, Any]:
    """Let the recorder finish its files with the summary; return it with the recorder's report.

    Args:
        supervisor: of the run.
        role: the recorder's, None where nothing is recorded.
        summary: so far; without steps where the plant could not report how many it took.
    """
    entries: dict[str, Any] = {"recording": None, "recorded_steps": 0, "lost_steps": 0}
    if role is None:
        return summary | entries
    report = _finish_or_kill(supervisor, role, summary)
    if report is None and role.path:
        entries |= recover_recordings(role, summary, _time_for_files(supervisor))
    merged = merge_summaries(summary, entries, report or {})
    merged |= recover_bags(role, merged.get("mcap"), _time_for_files(supervisor))
    paths = [path for path in (role.path, role.mcap) if path]
    if before_resets := [
        str(file) for path in paths for file in files_before_resets(path, role.start_time)
    ]:
        merged["before_reset"] = before_resets
    merged.setdefault("steps", max(supervisor.plant.step, merged["recorded_steps"]))
    run_error, recorder_error = summary.get("error", ""), (report or {}).get("error", "")
    if not recorder_error and (role.failure or not run_error):
        recorder_error = _describe_missing(report, role, merged)
    error = "; ".join(filter(None, (run_error, recorder_error)))
    return merged | ({"error": error} if error else {})


def _time_for_files(supervisor: Supervisor) -> Callable[[], float]:
    """Return a function for the seconds left for files, fewer once a shutdown is requested."""
    deadline = time.monotonic() + _FILES_TIMEOUT
    return lambda: min(deadline - time.monotonic(), supervisor.time_left)


def _finish_or_kill(
    supervisor: Supervisor, role: RecorderRole, summary: dict[str, Any]
) -> dict[str, Any] | None:
    """Return the recorder's report, None without one in time; a dead recorder is replaced.

    The summary's number of restarts is updated.
    """
    _request_finish(supervisor, role.active, summary)
    while _has_died(role.active) and not supervisor.shutting_down and supervisor.fail_over(role):
        summary["restarts"] = summary.get("restarts", {}) | {role.name: role.restarts}
        _request_finish(supervisor, role.active, summary)
    recorder = role.active
    if recorder.summary is None:
        recorder.send_signal(signal.SIGKILL)  # before it creates a file that would stay unfinished
        recorder.wait_for_exit(time.monotonic() + _KILL_TIMEOUT)
    return recorder.summary


def _request_finish(supervisor: Supervisor, recorder: Child, summary: dict[str, Any]) -> None:
    if recorder.ready or not supervisor.shutting_down:
        time_limit = min(_FILES_TIMEOUT, supervisor.time_left)
        recorder.send(f"finish {json.dumps({'time_limit': time_limit, 'summary': summary})}")
        supervisor.drain([recorder], _FILES_TIMEOUT)


def _has_died(recorder: Child) -> bool:
    return recorder.exited and recorder.summary is None


def _describe_missing(
    report: dict[str, Any] | None, role: RecorderRole, merged: dict[str, Any]
) -> str:
    """Return one line on the steps that are missing in the files, empty where none are."""
    progress = f"it has {merged['recorded_steps']} of {merged['steps']} steps"
    if report is None:
        files = (
            f"; {merged['recording'] or 'the recording'} is incomplete, {progress}"
            if role.path
            else ""
        )
        files += f"; {merged.get('mcap') or 'the bag'} is incomplete" if role.mcap else ""
        return f"{role.failure or f'recorder: {role.active.fault or _UNFINISHED}'}{files}"
    lost_commands = merged.get("lost_commands", 0)
    return (
        describe_gaps(merged["recorded_steps"], merged["steps"], lost_commands) if role.path else ""
    )
