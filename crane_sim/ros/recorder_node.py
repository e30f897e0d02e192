"""The node `recorder`: subscribes to a run and writes files; the plant does not depend on it."""

import json
import os
import sys
import time
from contextlib import suppress
from functools import partial
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from crane_sim import load_scene
from crane_sim.ros.common import node_host
from crane_sim.ros.common.node_host import Fault, NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.common.refused_messages import refused_entry
from crane_sim.ros.recorder.decoder import TOPICS
from crane_sim.ros.recorder.outputs import Outputs, ResumeState, read_resume_state
from crane_sim.ros.recorder.replay_buffer import ReplayBuffer
from crane_sim.ros.recorder.subscriptions import NAMES, RecorderSubscriptions
from crane_sim.simulation.hardware import is_sensed

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

PARAMETERS = {
    "scene": Option("knuckle_setpoint", "scene: a name of the catalogue or a path"),
    "path": Option(
        "runs/run.rrd",
        "the Rerun recording, with .part behind its name while it grows; empty: none",
    ),
    "mcap": Option(
        "", "MCAP file of the messages as they came, with .part while it grows; empty: none"
    ),
    "commanded": Option(
        False, "ignore the scene's own law and inputs, as a plant with this parameter does"
    ),
    "live_port": Option(
        0, "serve the recording to viewers on this local port, too; 0: do not", 0, 65535
    ),
    "recording_id": Option("", "identifier of the recording in the viewer; empty: a new one"),
    "standby": Option(
        False, "stand by, and resume, at the request go, where another recorder has failed"
    ),
    "resets": Option(0, "resets of the plant before this recorder stands by", 0, 1_000_000_000),
}

_FINISH_TIMEOUT = 60.0  # s to complete the files without a request that limits it
_WAIT_SHARE = 0.5  # of that time at most, for messages that are still on their way
_PERIOD = 0.01  # s between two polls: bursts cost less than messages one by one


def serve(host: NodeHost, settings: SimpleNamespace) -> None:
    """Record until the request to finish, or until the run is over.

    Raises:
        ValueError: the settings leave nothing to record.
        Fault: a file could not be written.
    """
    check_settings(settings)
    scene = load_scene(settings.scene)
    scene = scene.with_external_commands() if settings.commanded else scene
    if settings.standby:
        subscriptions, outputs = _stand_by(host, scene, settings)
    else:
        outputs = _open_outputs(host, scene, settings, ResumeState())
        subscriptions = RecorderSubscriptions(host.node, outputs.callbacks)
        if settings.live_port:
            host.node.get_logger().info(
                f"watch it live: crane view --live --port {settings.live_port}"
            )
        host.wait(partial(subscriptions.missing, is_sensed(scene)))
        host.report_ready()
    if outputs:
        _record_run(host, scene, subscriptions, outputs)


def check_settings(settings: SimpleNamespace) -> None:
    """Raise a single-line ValueError for settings that contradict each other."""
    if not (settings.path or settings.mcap):
        raise ValueError("parameters path and mcap are both empty: there is nothing to write")
    if settings.live_port and not settings.path:
        raise ValueError("parameter live_port serves a recording; path must not be empty")


def _stand_by(
    host: NodeHost, scene: "Scene", settings: SimpleNamespace
) -> tuple[RecorderSubscriptions, Outputs | None]:
    """Buffer messages until another recorder fails, then resume; no outputs if the run ended."""
    buffer = ReplayBuffer(NAMES if settings.mcap else TOPICS, settings.resets)
    subscriptions = RecorderSubscriptions(host.node, [buffer.callbacks()])
    if settings.path:
        # imports Rerun before the fail-over, not in it
        from crane_sim.recording.rerun.recorder import warm_up

        warm_up(scene)
    host.wait(partial(subscriptions.missing, is_sensed(scene)))
    host.report_ready()
    while not (host.started or host.stop_reason):
        host.spin(_PERIOD)
        subscriptions.dispatch()
    if not host.started:
        return subscriptions, None
    resume = read_resume_state(host.resume_state)
    outputs = _open_outputs(host, scene, settings, resume)
    buffer.replay_to(outputs.callbacks, outputs.resume_after, resume.resets)
    return subscriptions, outputs


def _open_outputs(
    host: NodeHost, scene: "Scene", settings: SimpleNamespace, resume: ResumeState
) -> Outputs:
    outputs = Outputs(host.node, scene, settings, resume)
    outputs.report_resets(lambda: _report_statistics(host, outputs))
    return outputs


def _record_run(
    host: NodeHost, scene: "Scene", subscriptions: RecorderSubscriptions, outputs: Outputs
) -> None:
    _record_until_stopped(host, subscriptions, outputs)
    added = _finish_files(host, subscriptions, outputs, *_final_summary(scene, host.stop_reason))
    added |= refused_entry(subscriptions.refused() + outputs.misfits())
    host.pipes.report("done", summary=added)
    for output in outputs.files:
        if output.write_error:
            raise Fault(output.write_error)
    files = [added[key] for key in ("recording", "mcap") if key in added]
    host.node.get_logger().info(f"wrote {' and '.join(files)}")


def _record_until_stopped(
    host: NodeHost, subscriptions: RecorderSubscriptions, outputs: Outputs
) -> None:
    errors: set[str] = set()
    reported = dict[str, int]()
    while not host.stop_reason and (host.pipes.attached or not subscriptions.over):
        host.spin(_PERIOD)
        subscriptions.dispatch()
        for output in outputs.files:
            output.idle()
            if output.write_error and output.write_error not in errors:
                errors.add(output.write_error)
                host.node.get_logger().error(f"{output.write_error}; the run goes on unrecorded")
        host.notify_refused(subscriptions.refused())
        if (progress := outputs.progress()) != reported:
            reported = progress
            _report_statistics(host, outputs)


def _report_statistics(host: NodeHost, outputs: Outputs) -> None:
    host.pipes.report("progress", **outputs.progress())


def _finish_files(
    host: NodeHost,
    subscriptions: RecorderSubscriptions,
    outputs: Outputs,
    summary: dict[str, Any],
    time_limit: float,
) -> dict[str, Any]:
    """Wait for messages on their way, complete the files, return what they add to the summary."""
    steps, start = summary.get("steps"), time.monotonic()
    deadline = start + _WAIT_SHARE * time_limit
    subscriptions.dispatch()
    for output in outputs.files:
        output.expect_messages()
    while (
        not all(output.has_all(steps) for output in outputs.files) and time.monotonic() < deadline
    ):
        host.spin(_PERIOD)
        subscriptions.dispatch()
    subscriptions.dispatch()  # what the last call left pending
    outputs.save()
    _report_statistics(host, outputs)  # a successor has nothing to write: all is on the disk
    return outputs.finish(summary, start + time_limit)


def _final_summary(scene: "Scene", request: str) -> tuple[dict[str, Any], float]:
    """Return the request's summary, or the recorder's, and the time [s] to complete the files."""
    _, _, document = request.partition(" ")
    if document:
        argument = json.loads(document)
        return argument["summary"], argument["time_limit"]
    entries = {"scene": scene.name, "law": scene.law_name, "seed": scene.seed}
    return entries | (
        {"ended_by": request} if request else {}
    ), 0.0 if request == "interrupted" else _FINISH_TIMEOUT


def _lower_priority() -> None:
    """Set SCHED_BATCH, so that wake-ups preempt neither plant nor controller.

    Threads of Fast DDS inherit it.
    """
    with suppress(PermissionError):  # a sandbox may forbid it, which costs speed alone
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def _return_free_memory() -> None:
    """Have Rerun's allocator return free memory at once; it reads this when it is loaded.

    Otherwise a recorder grows for minutes: the allocator keeps what other threads have freed.
    """
    os.environ.setdefault("MIMALLOC_PURGE_DELAY", "0")  # ms


def main() -> int:
    """Run the node; see `node_host.main` for the exit code."""
    _lower_priority()
    _return_free_memory()
    return node_host.main("recorder", PARAMETERS, serve)


if __name__ == "__main__":
    sys.exit(main())
