"""The files of a recorder: opened at the start, or to resume after another recorder's failure."""

import json
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any, NamedTuple

from rclpy.node import Node

from crane_sim.recording.files import existing_parts, part_of
from crane_sim.recording.layout import layout_of_scene, text_properties
from crane_sim.ros.common.node_host import Fault
from crane_sim.ros.recorder.decoder import MessageDecoder, source_of
from crane_sim.ros.recorder.subscriptions import topics

if TYPE_CHECKING:
    from crane_sim.recording.mcap.bag import Bag
    from crane_sim.recording.rerun.recorder import Recorder
    from crane_sim.scenes.scene import Scene


class ResumeState(NamedTuple):
    """The state from which a recorder resumes after the failure of another one."""

    after: int = 0  # the last step that the failed one is known to have written
    recorded: int = 0  # steps that it, and those before it, have written
    lost_commands: int = 0  # how many of those lack their command
    last_bag_step: int = 0  # the last step whose messages are known to be in their bags
    resets: int = 0  # resets of the plant that they have recorded
    since: float = 0.0  # s of the system's clock: older files are another run's
    number: int = 1  # of the part that begins here


class Outputs:
    """The Rerun recording and the bag of one run, or one of them.

    Attributes:
        files: those being written.
        callbacks: of a serialized message per topic, for each file.
        resume_after: stamp [ns] after which each file begins.
    """

    def __init__(
        self, node: Node, scene: "Scene", settings: SimpleNamespace, resume: ResumeState
    ) -> None:
        """Open the files; raises Fault where one cannot be written."""
        self._node = node
        self._bag = bag = _open_bag(node, scene, settings, resume)
        self.recorder = _open_recorder(scene, settings, bag, resume)
        self.files: list[Bag | Recorder] = [output for output in (bag, self.recorder) if output]
        self._decoder = (
            MessageDecoder(scene, self.recorder, source_of(node)) if self.recorder else None
        )
        receivers = [bag, self._decoder]
        self.callbacks: list[dict[str, Callable[[bytes], None]]] = [
            each.callbacks() for each in receivers if each
        ]
        steps = [
            step
            for step, output in ((resume.last_bag_step, bag), (resume.after, self.recorder))
            if output
        ]
        self.resume_after = [step * scene.period_ns for step in steps]

    def report_resets(self, report: Callable[[], object]) -> None:
        """Report each reset at once: a successor must not confuse the runs before and after it."""
        if self.recorder:
            self.recorder.on_reset = report

    def progress(self) -> dict[str, int]:
        """Return what is on the disk: last steps of recording and bag, and three counts.

        The counts are of steps, lost commands and resets.
        """
        step, recorded = (
            (self.recorder.last_step, self.recorder.recorded) if self.recorder else (0, 0)
        )
        lost_commands = self.recorder.lost_commands if self.recorder else 0
        last_bag_step, resets = (
            self._bag.last_step if self._bag else 0,
            max(output.resets for output in self.files),
        )
        counts = {"recorded": recorded, "lost_commands": lost_commands, "resets": resets}
        return {"step": step, "last_bag_step": last_bag_step} | counts

    def misfits(self) -> Counter[str]:
        """Return the number of messages that no recording can have, by topic."""
        refused = self._decoder.refused if self._decoder else Counter[str]()
        return Counter(
            {
                f"{self._node.resolve_topic_name(topic)}, malformed": n
                for topic, n in refused.items()
            }
        )

    def save(self) -> None:
        """Write all that is buffered: no more messages are coming."""
        for output in self.files:
            output.save()

    def finish(self, summary: dict[str, Any], until: float) -> dict[str, Any]:
        """Complete the files one after the other, return what they add to the summary together.

        Optional work is left out where it would not be done by `until` [s], an instant of the
        monotonic clock.
        """
        added = self._bag.finish(summary) if self._bag else {}
        if not self.recorder:
            return added
        recorded = self.recorder.finish(summary | added, until - time.monotonic())
        errors = [each["error"] for each in (added, recorded) if "error" in each]
        return recorded | added | ({"error": "; ".join(errors)} if errors else {})


def read_resume_state(document: str) -> ResumeState:
    """Return the resume state in the argument of the request go; empty: no recorder has failed."""
    return ResumeState(**json.loads(document)) if document else ResumeState()


def _open_bag(
    node: Node, scene: "Scene", settings: SimpleNamespace, resume: ResumeState
) -> "Bag | None":
    if not settings.mcap:
        return None
    from crane_sim.recording.mcap.bag import Bag  # needs rosbags, which is optional

    try:
        path, properties = (
            part_of(settings.mcap, resume.number),
            text_properties(layout_of_scene(scene, "")),
        )
        return Bag(
            path, topics(node), scene.period_ns, resume.last_bag_step, resume.resets, properties
        )
    except OSError as error:
        raise Fault(f"{settings.mcap}: {error.strerror}") from error


def _open_recorder(
    scene: "Scene", settings: SimpleNamespace, bag: "Bag | None", resume: ResumeState
) -> "Recorder | None":
    if not settings.path:
        return None
    from crane_sim.recording.rerun.part_file import RecordingError
    from crane_sim.recording.rerun.recorder import Recorder  # needs Rerun
    from crane_sim.recording.rerun.repair import EarlierFiles

    parts = tuple(existing_parts(settings.path, resume.number - 1, resume.since))
    previous = EarlierFiles(
        resume.after, resume.recorded, parts, resume.resets, resume.lost_commands
    )
    complete_file = Path(settings.path) if resume.number > 1 else None
    port = settings.live_port or None
    try:
        return Recorder(
            scene,
            part_of(settings.path, resume.number),
            port,
            settings.recording_id,
            complete_file,
            previous,
        )
    except RecordingError as error:
        if bag:
            bag.abandon()
        raise Fault(str(error)) from error
