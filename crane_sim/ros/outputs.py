"""The files that a recorder writes: opened at the start of a run, or where another recorder died."""

import json
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

from rclpy.node import Node

from crane_sim.recording.part_names import part_of
from crane_sim.ros.hearing import topics
from crane_sim.ros.process import Fault
from crane_sim.ros.transcript import Transcript

if TYPE_CHECKING:
    from crane_sim.recording.bag import Bag
    from crane_sim.recording.recorder import Recorder
    from crane_sim.scene import Scene


class Output(Protocol):
    """A file in the making."""

    broken: str

    def idle(self) -> None:
        """Write what waits, when its time has come."""

    def has_all(self, steps: int | None) -> bool:
        """Whether everything of `steps` steps has come in, or nothing more is coming."""
        ...


class Handover(NamedTuple):
    """What a recorder is told that goes on for another one."""

    after: int = 0  # the last step that the other one is known to have written
    recorded: int = 0  # steps that it, and those before it, have written
    bagged: int = 0  # the last step whose messages are known to be in their bags
    parts: tuple[str, ...] = ()  # the recording's unfinished files
    number: int = 1  # of the part that now begins


class Outputs:
    """The Rerun recording and the bag of one run, or one of them.

    Attributes:
        files: those in the making.
        takers: functions of a serialized message per topic, by what takes them.
        behind: stamp [ns] behind which each of them begins.
    """

    def __init__(
        self, node: Node, scene: "Scene", settings: SimpleNamespace, kept: list[object], before: Handover
    ) -> None:
        """Open the files; raises Fault where one cannot be written. What must outlive a failure goes into `kept`."""
        self._bag = bag = _opened_bag(node, scene, settings, before)
        self.recorder = _opened_recorder(scene, settings, kept, bag, before)
        self.files: list[Output] = [output for output in (bag, self.recorder) if output]
        readers = [bag, self.recorder and Transcript(scene, self.recorder)]
        self.takers: list[dict[str, Callable[[bytes], None]]] = [reader.takers() for reader in readers if reader]
        steps = [step for step, output in ((before.bagged, bag), (before.after, self.recorder)) if output]
        self.behind = [step * scene.period_ns for step in steps]

    def progress(self) -> dict[str, int]:
        """Return the last step on the disk, how many there are, and the last one whose messages are."""
        step, recorded = (self.recorder.last_step, self.recorder.recorded) if self.recorder else (0, 0)
        return {"step": step, "recorded": recorded, "bagged": self._bag.last_step if self._bag else 0}

    def finish(self, summary: dict[str, Any], until: float) -> dict[str, Any]:
        """Complete the files one after the other, return what they add to the summary together.

        What can be left undone is, where it would not be done by `until` [s], an instant of the monotonic clock.
        """
        added = self._bag.finish(summary) if self._bag else {}
        if self.recorder:
            added = self.recorder.finish(summary | added, until - time.monotonic()) | added  # the first error stands
        return added


def read_handover(path: str) -> Handover:
    """Return what the orchestrator has left for a recorder that goes on for another one."""
    told = json.loads(Path(path).read_text())
    return Handover(**told | {"parts": tuple(told["parts"])})


def _opened_bag(node: Node, scene: "Scene", settings: SimpleNamespace, before: Handover) -> "Bag | None":
    if not settings.mcap:
        return None
    from crane_sim.recording.bag import Bag  # needs rosbags, which not everyone has

    try:
        return Bag(part_of(settings.mcap, before.number), topics(node), scene.period_ns, before.bagged)
    except OSError as error:
        raise Fault(f"{settings.mcap}: {error.strerror}") from error


def _opened_recorder(
    scene: "Scene", settings: SimpleNamespace, kept: list[object], bag: "Bag | None", before: Handover
) -> "Recorder | None":
    if not settings.path:
        return None
    from crane_sim.recording.parts import Before
    from crane_sim.recording.recorder import Recorder  # needs Rerun
    from crane_sim.recording.writer import RecordingError

    earlier = Before(before.after, before.recorded, tuple(map(Path, before.parts)))
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
