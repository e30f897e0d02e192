"""The files that a recorder writes: opened at the start of a run, or where another recorder died."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from rclpy.node import Node

from crane_sim.recording.files import existing_parts, part_of
from crane_sim.ros.common.node_host import Fault
from crane_sim.ros.recorder.decoder import MessageDecoder
from crane_sim.ros.recorder.subscriptions import topics

if TYPE_CHECKING:
    from crane_sim.recording.mcap.bag import Bag
    from crane_sim.recording.rerun.recorder import Recorder
    from crane_sim.scenes.scene import Scene


class Output(Protocol):
    """A file in the making."""

    broken: str
    passes: int

    def idle(self) -> None:
        """Write what waits, when its time has come."""
        ...

    def save(self) -> None:
        """Write all that waits."""
        ...

    def has_all(self, steps: int | None) -> bool:
        """Whether everything of `steps` steps has come in, or nothing more is coming."""
        ...


class ResumeState(NamedTuple):
    """What a recorder is told that goes on for another one."""

    after: int = 0  # the last step that the other one is known to have written
    recorded: int = 0  # steps that it, and those before it, have written
    bagged: int = 0  # the last step whose messages are known to be in their bags
    passes: int = 0  # resets of the plant that they have taken in
    since: float = 0.0  # s of the system's clock: older files are another run's
    number: int = 1  # of the part that now begins


class Outputs:
    """The Rerun recording and the bag of one run, or one of them.

    Attributes:
        files: those in the making.
        takers: functions of a serialized message per topic, by what takes them.
        behind: stamp [ns] behind which each of them begins.
    """

    def __init__(
        self, node: Node, scene: "Scene", settings: SimpleNamespace, kept: list[object], before: ResumeState
    ) -> None:
        """Open the files; raises Fault where one cannot be written. What must outlive a failure goes into `kept`."""
        self._bag = bag = _opened_bag(node, scene, settings, before)
        self.recorder = _opened_recorder(scene, settings, kept, bag, before)
        self.files: list[Output] = [output for output in (bag, self.recorder) if output]
        readers = [bag, self.recorder and MessageDecoder(scene, self.recorder)]
        self.takers: list[dict[str, Callable[[bytes], None]]] = [reader.takers() for reader in readers if reader]
        steps = [step for step, output in ((before.bagged, bag), (before.after, self.recorder)) if output]
        self.behind = [step * scene.period_ns for step in steps]

    def report_resets(self, report: Callable[[], object]) -> None:
        """Let each reset be reported at once: who goes on from there must not take the next pass for the last one."""
        if self.recorder:
            self.recorder.on_reset = report

    def progress(self) -> dict[str, int]:
        """Return the last step on the disk, how many there are, the last one whose messages are, and resets."""
        step, recorded = (self.recorder.last_step, self.recorder.recorded) if self.recorder else (0, 0)
        passes = max(output.passes for output in self.files)
        return {"step": step, "recorded": recorded, "bagged": self._bag.last_step if self._bag else 0, "passes": passes}

    def save(self) -> None:
        """Write all that waits: nothing more is coming."""
        for output in self.files:
            output.save()

    def finish(self, summary: dict[str, Any], until: float) -> dict[str, Any]:
        """Complete the files one after the other, return what they add to the summary together.

        What can be left undone is, where it would not be done by `until` [s], an instant of the monotonic clock.
        """
        added = self._bag.finish(summary) if self._bag else {}
        if not self.recorder:
            return added
        own = self.recorder.finish(summary | added, until - time.monotonic())
        errors = [each["error"] for each in (added, own) if "error" in each]
        return own | added | ({"error": "; ".join(errors)} if errors else {})


def read_resume_state(told: str) -> ResumeState:
    """Return what the orchestrator tells a recorder that goes on for another one; nothing: there was none."""
    return ResumeState(**json.loads(told)) if told else ResumeState()


def _opened_bag(node: Node, scene: "Scene", settings: SimpleNamespace, before: ResumeState) -> "Bag | None":
    if not settings.mcap:
        return None
    from crane_sim.recording.mcap.bag import Bag  # needs rosbags, which not everyone has

    try:
        return Bag(part_of(settings.mcap, before.number), topics(node), scene.period_ns, before.bagged, before.passes)
    except OSError as error:
        raise Fault(f"{settings.mcap}: {error.strerror}") from error


def _opened_recorder(
    scene: "Scene", settings: SimpleNamespace, kept: list[object], bag: "Bag | None", before: ResumeState
) -> "Recorder | None":
    if not settings.path:
        return None
    from crane_sim.recording.rerun.recorder import Recorder  # needs Rerun
    from crane_sim.recording.rerun.repair import Previous
    from crane_sim.recording.rerun.writer import RecordingError

    parts = tuple(existing_parts(settings.path, before.number - 1, before.since))
    earlier = Previous(before.after, before.recorded, parts, before.passes)
    whole = Path(settings.path) if before.number > 1 else None
    port = settings.live_port or None
    try:
        recorder = Recorder(scene, part_of(settings.path, before.number), port, settings.recording_id, whole, earlier)
    except RecordingError as error:
        kept.append(error)
        if bag:
            bag.abandon()
        raise Fault(str(error)) from error
    kept.append(recorder)
    return recorder
