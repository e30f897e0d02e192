"""The node `recorder`: listens to a run and writes it to files; whatever happens to it, the plant goes on."""

import json
import os
import shutil
import sys
import time
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

from crane_sim import load_scene
from crane_sim.ros.common import node_host
from crane_sim.ros.common.node_host import Fault, NodeHost
from crane_sim.ros.common.parameters import Option
from crane_sim.ros.recorder.decoder import TOPICS
from crane_sim.ros.recorder.outputs import Outputs, ResumeState, read_resume_state
from crane_sim.ros.recorder.replay_buffer import ReplayBuffer
from crane_sim.ros.recorder.subscriptions import NAMES, RecorderSubscriptions

if TYPE_CHECKING:
    from crane_sim.scenes.scene import Scene

PARAMETERS = {
    "scene": Option("knuckle_setpoint", "scene: a name of the catalogue or a path"),
    "path": Option("runs/run.rrd", "the Rerun recording, with .part behind its name while it grows; empty: none"),
    "mcap": Option("", "MCAP file of the messages as they came, with .part while it grows; empty: none"),
    "live_port": Option(0, "serve the recording to viewers on this local port, too; 0: do not", 0, 65535),
    "recording_id": Option("", "what the viewer knows the recording by; empty: one of its own"),
    "standby": Option(False, "stand by, and at the order go begin where it says that another recorder has ended"),
    "passes": Option(0, "resets of the plant before this recorder stands by", 0, 1_000_000_000),
}

_ALONE = 60.0  # s for the end where nobody says how long it may take
_WAITED = 0.5  # of that time at most, for messages that are still on their way
_PERIOD = 0.01  # s between two looks at what has come: bursts cost less than messages one by one


def serve(host: NodeHost, settings: SimpleNamespace, kept: list[object]) -> None:
    """Record until told to finish, or until the run is over; what must outlive a failure goes into `kept`.

    Raises:
        ValueError: the settings leave nothing to record.
        Fault: a file could not be written.
    """
    check_settings(settings)
    scene = load_scene(settings.scene)
    if settings.standby:
        hearing, outputs = _stood_by(host, scene, settings, kept)
    else:
        outputs = _open_outputs(host, scene, settings, kept, ResumeState())
        hearing = RecorderSubscriptions(host.node, outputs.takers)
        if settings.live_port:
            host.node.get_logger().info(f"watch it live: {viewer_command(settings.live_port)}")
        host.wait(hearing.missing)
        host.pipes.report("ready")
    if outputs:
        _record(host, scene, hearing, outputs)


def check_settings(settings: SimpleNamespace) -> None:
    """Raise ValueError, one line, for settings that make no sense together."""
    if not (settings.path or settings.mcap):
        raise ValueError("parameters path and mcap are both empty: there is nothing to write")
    if settings.live_port and not settings.path:
        raise ValueError("parameter live_port serves a recording; path must not be empty")


def viewer_command(port: int) -> str:
    """Return the command that shows what is served on a port."""
    program = shutil.which("rerun") or Path(sys.executable).with_name("rerun")
    return f"{program} --connect rerun+http://127.0.0.1:{port}/proxy"


def _stood_by(
    host: NodeHost, scene: "Scene", settings: SimpleNamespace, kept: list[object]
) -> tuple[RecorderSubscriptions, Outputs | None]:
    """Listen until another recorder has died, and begin where it ended; None where the run ended before."""
    tail = ReplayBuffer(NAMES if settings.mcap else TOPICS, settings.passes)
    hearing = RecorderSubscriptions(host.node, [tail.takers()])
    if settings.path:
        from crane_sim.recording.rerun.recorder import warm_up  # imports Rerun now, not when every second counts

        warm_up(scene)
    host.wait(hearing.missing)
    host.pipes.report("ready")
    while not (host.started or host.stopping):
        host.spin(_PERIOD)
        hearing.dispatch()
    if not host.started:
        return hearing, None
    before = read_resume_state(host.told)
    outputs = _open_outputs(host, scene, settings, kept, before)
    tail.pass_to(outputs.takers, outputs.behind, before.passes)
    return hearing, outputs


def _open_outputs(
    host: NodeHost, scene: "Scene", settings: SimpleNamespace, kept: list[object], before: ResumeState
) -> Outputs:
    outputs = Outputs(host.node, scene, settings, kept, before)
    outputs.report_resets(lambda: _report(host, outputs))
    return outputs


def _record(host: NodeHost, scene: "Scene", hearing: RecorderSubscriptions, outputs: Outputs) -> None:
    _listen(host, hearing, outputs)
    added = _finish_files(host, hearing, outputs, *_final_summary(scene, host.stopping))
    host.pipes.report("done", summary=added)
    for output in outputs.files:
        if output.broken:
            raise Fault(output.broken)
    files = [added[key] for key in ("recording", "mcap") if key in added]
    host.node.get_logger().info(f"wrote {' and '.join(files)}")


def _listen(host: NodeHost, hearing: RecorderSubscriptions, outputs: Outputs) -> None:
    complaints: set[str] = set()
    told = dict[str, int]()
    while not host.stopping and (host.pipes.attached or not hearing.over):
        host.spin(_PERIOD)
        hearing.dispatch()
        for output in outputs.files:
            output.idle()
            if output.broken and output.broken not in complaints:
                complaints.add(output.broken)
                host.node.get_logger().error(f"{output.broken}; the run goes on unrecorded")
        if (now := outputs.progress()) != told:
            told = now
            _report(host, outputs)


def _report(host: NodeHost, outputs: Outputs) -> None:
    host.pipes.report("progress", **outputs.progress())


def _finish_files(
    host: NodeHost, hearing: RecorderSubscriptions, outputs: Outputs, summary: dict[str, Any], within: float
) -> dict[str, Any]:
    """Wait for what is still on its way, complete the files, return what they add to the summary."""
    steps, began = summary.get("steps"), time.monotonic()
    hearing.dispatch()
    while not all(output.has_all(steps) for output in outputs.files) and time.monotonic() < began + _WAITED * within:
        host.spin(_PERIOD)
        hearing.dispatch()
    hearing.dispatch()  # what the last call held back
    outputs.save()
    _report(host, outputs)  # who has to go on from here is to know that all is on the disk
    return outputs.finish(summary, began + within)


def _final_summary(scene: "Scene", order: str) -> tuple[dict[str, Any], float]:
    """Return the summary that came with the order to finish, or what the recorder itself knows; and s for all of it."""
    _, _, document = order.partition(" ")
    if document:
        told = json.loads(document)
        return told["summary"], told["within"]
    own = {"scene": scene.name, "law": scene.law_name, "seed": scene.seed}
    return own | ({"ended_by": order} if order else {}), 0.0 if order == "interrupted" else _ALONE


def _give_way() -> None:
    """Wake up without taking a core from plant or controller; the threads that Fast DDS starts later inherit it."""
    with suppress(PermissionError):  # a sandbox may forbid it, which costs speed alone
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    kept: list[object] = []
    _give_way()
    code = node_host.main("recorder", PARAMETERS, lambda host, settings: serve(host, settings, kept))
    if code:  # Rerun waits for ever, at interpreter exit and where its stream is freed, for a file it could not write
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
