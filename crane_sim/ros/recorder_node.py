"""The node `recorder`: listens to a run and writes it to files; whatever happens to it, the plant goes on."""

import json
import os
import shutil
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, Protocol

from crane_sim import load_scene
from crane_sim.ros import process
from crane_sim.ros.hearing import Hearing, topics
from crane_sim.ros.process import Fault, Host
from crane_sim.ros.transcript import Transcript

if TYPE_CHECKING:
    from crane_sim.recording.bag import Bag
    from crane_sim.recording.recorder import Recorder
    from crane_sim.scene import Scene

PARAMETERS = {
    "scene": "knuckle_setpoint",  # catalogue name or path
    "path": "runs/run.rrd",  # the Rerun recording; <path>.part while it grows; empty: none
    "mcap": "",  # the messages as they came, for other tools; <mcap>.part while it grows; empty: none
    "live_port": 0,  # serve the Rerun recording to viewers on this local port, too; 0: do not
}


_PERIOD = 0.01  # s between two looks at what has come: bursts cost less than messages one by one


class Output(Protocol):
    """A file in the making."""

    broken: str

    def idle(self) -> None:
        """Write what waits, when its time has come."""

    def has_all(self, steps: int | None) -> bool:
        """Whether everything of `steps` steps has come in, or nothing more is coming."""
        ...

    def finish(self, summary: Mapping[str, Any]) -> dict[str, Any]:
        """Complete the file; return what it adds to the run's summary."""
        ...


def serve(host: Host, settings: SimpleNamespace, kept: list[object]) -> None:
    """Record until told to finish, or until the run is over; what must outlive a failure goes into `kept`.

    Raises:
        ValueError: the settings leave nothing to record.
        Fault: a file could not be written.
    """
    check(settings)
    scene = load_scene(settings.scene)
    bag = _opened_bag(host, scene, settings)
    recorder = _opened_recorder(scene, settings, kept, bag)
    outputs = [output for output in (bag, recorder) if output]
    readers = [bag, recorder and Transcript(scene, recorder)]
    hearing = Hearing(host.node, [reader.takers() for reader in readers if reader])
    if settings.live_port:
        host.node.get_logger().info(f"watch it live: {viewer_command(settings.live_port)}")
    host.wait(hearing.missing)
    host.pipes.report("ready")
    _listen(host, hearing, outputs)
    added = _finish(host, hearing, outputs, _summary(scene, host.stopping))
    host.pipes.report("done", summary=added)
    for output in outputs:
        if output.broken:
            raise Fault(output.broken)
    files = [added[key] for key in ("recording", "mcap") if key in added]
    host.node.get_logger().info(f"wrote {' and '.join(files)}")


def check(settings: SimpleNamespace) -> None:
    """Raise ValueError, one line, for settings that make no sense together."""
    if not (settings.path or settings.mcap):
        raise ValueError("parameters path and mcap are both empty: there is nothing to write")
    if settings.live_port and not settings.path:
        raise ValueError("parameter live_port serves a recording; path must not be empty")


def viewer_command(port: int) -> str:
    """Return the command that shows what is served on a port."""
    program = shutil.which("rerun") or Path(sys.executable).with_name("rerun")
    return f"{program} --connect rerun+http://127.0.0.1:{port}/proxy"


def _opened_bag(host: Host, scene: "Scene", settings: SimpleNamespace) -> "Bag | None":
    if not settings.mcap:
        return None
    from crane_sim.recording.bag import Bag  # needs rosbags, which not everyone has

    try:
        return Bag(Path(settings.mcap), topics(host.node), scene.period_ns)
    except OSError as error:
        raise Fault(f"{settings.mcap}: {error.strerror}") from error


def _opened_recorder(
    scene: "Scene", settings: SimpleNamespace, kept: list[object], bag: "Bag | None"
) -> "Recorder | None":
    if not settings.path:
        return None
    from crane_sim.recording.recorder import Recorder  # needs Rerun
    from crane_sim.recording.writer import RecordingError

    try:
        recorder = Recorder(scene, Path(settings.path), settings.live_port or None)
    except RecordingError as error:
        kept.append(error)
        if bag:
            bag.abandon()
        raise Fault(str(error)) from error
    kept.append(recorder)
    return recorder


def _listen(host: Host, hearing: Hearing, outputs: Sequence[Output]) -> None:
    complaints: set[str] = set()
    while not host.stopping and (host.pipes.attached or not hearing.over):
        host.spin(_PERIOD)
        hearing.pass_on()
        for output in outputs:
            output.idle()
            if output.broken and output.broken not in complaints:
                complaints.add(output.broken)
                host.node.get_logger().error(f"{output.broken}; the run goes on unrecorded")


def _finish(host: Host, hearing: Hearing, outputs: Sequence[Output], summary: dict[str, Any]) -> dict[str, Any]:
    """Wait for what is still on its way, complete the files one after the other, return what they add together."""
    steps = summary.get("steps")
    hearing.pass_on()
    while not host.stopping.startswith("interrupted") and not all(output.has_all(steps) for output in outputs):
        host.spin(_PERIOD)
        hearing.pass_on()
    hearing.pass_on()  # what the last call held back
    added: dict[str, Any] = {}
    for output in outputs:
        added = output.finish(summary | added) | added  # the first error stands
    return added


def _summary(scene: "Scene", order: str) -> dict[str, Any]:
    """Return the summary that came with the order to finish, or what the recorder itself knows."""
    _, _, document = order.partition(" ")
    own = {"scene": scene.name, "law": scene.law_name, "seed": scene.seed}
    return json.loads(document) if document else own | ({"ended_by": order} if order else {})


def _give_way() -> None:
    """Wake up without taking a core from plant or controller; the threads that Fast DDS starts later inherit it."""
    with suppress(PermissionError):  # a sandbox may forbid it, which costs speed alone
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def main() -> int:
    """Run the node; see `process.main` for the exit code."""
    kept: list[object] = []
    _give_way()
    code = process.main("recorder", PARAMETERS, lambda host, settings: serve(host, settings, kept))
    if code:  # Rerun waits for ever, at interpreter exit and where its stream is freed, for a file it could not write
        os._exit(code)
    return code


if __name__ == "__main__":
    sys.exit(main())
