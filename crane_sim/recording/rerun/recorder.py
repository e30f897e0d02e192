"""Recorder of a run from its messages' stamps and numbers, independent of ROS.

It writes blocks of steps, and handles resets and failures.
"""

from __future__ import annotations

import time
import uuid
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from crane_sim.recording.blocks import block_of
from crane_sim.recording.files import before_reset, describe_failure, describe_gaps, set_aside
from crane_sim.recording.layout import layout_of_scene
from crane_sim.recording.rerun.live import LiveServer
from crane_sim.recording.rerun.part_file import RecordingError
from crane_sim.recording.rerun.repair import (
    REPAIR_TIMEOUT,
    EarlierFiles,
    Parts,
    compact,
    repair_leftovers,
)
from crane_sim.recording.rerun.writer import RunWriter
from crane_sim.recording.states import SIMULATION
from crane_sim.recording.step_assembler import Row, StepAssembler
from crane_sim.scenes.scene import Scene
from crane_sim.simulation.hardware import is_sensed

BLOCK_STEPS, BLOCK_SECONDS = 2000, 0.5
MAX_BLOCKS = 60  # half a minute of real time: a viewer is slow to open a file with more of them
MESSAGE_TIMEOUT = 2.0  # s without a message after which missing ones count as lost
_SETTLING_TIME = 0.3  # s without one after which a run of unknown length counts as complete


class Recorder:
    """Recorder of messages, in any order between topics, that writes complete steps in blocks.

    Attributes:
        write_error: one line on why the recording could not be written, empty while it can;
            messages are then ignored.
        last_step: the newest one on the disk.
        resets: number of resets of the plant.
        on_reset: called when the steps before a reset have been set aside, and nothing else has
            been done yet.
    """

    def __init__(
        self,
        scene: Scene,
        path: Path,
        live_port: int | None = None,
        run_id: str = "",
        complete_file: Path | None = None,
        previous: EarlierFiles | None = None,
    ) -> None:
        """Start the file, after recovering what earlier, killed recorders left beside it.

        Args:
            scene: what is recorded.
            path: the complete file, or the part of it that this recorder writes.
            live_port: port on which viewers can follow the run, over resets as well.
            run_id: the viewer's recording id, numbered behind a reset; empty: one of its own for
                each file.
            complete_file: path of the joined file, if other recorders wrote parts of it.
            previous: files and counts of earlier recorders.

        Raises:
            RecordingError: the file cannot be written, or the port is taken.
        """
        previous = previous or EarlierFiles()
        self._scene, self._path = scene, complete_file or path
        warm_up(scene)
        self._parts = Parts(self._path, previous)
        self._run_id, self.resets = run_id, previous.resets
        self._live = None if live_port is None else LiveServer(live_port)
        if complete_file is None:
            repair_leftovers(path.parent)
        self._writer = self._new_writer(path)
        self._recorded_before = previous.recorded  # steps in earlier parts
        self._assembler = _new_assembler(scene, previous.last_step)
        self._assembler.lost_commands = previous.lost_commands
        self._simulation_state = ""
        self.last_step, self._last_time = previous.last_step, 0.0  # written, s of wall time
        self._last_message, self._blocks = time.monotonic(), 0
        self.write_error = ""
        # steps in a file that could not be written further, from before a reset
        self._steps_before_reset = 0
        self.on_reset: Callable[[], object] = lambda: None

    def add_state(self, stamp: int, q: Sequence[float], v: Sequence[float]) -> None:
        """Take the joint state (nq,) of a stamp [ns], as measured by sensors."""
        self._last_message = time.monotonic()
        if self._assembler.follows_reset(stamp):
            self._start_over()
        self._last_time = self._last_time or self._last_message
        self._assembler.add_state(stamp, q, v)

    def add_true_state(self, stamp: int, q: Sequence[float], v: Sequence[float]) -> None:
        """Take the true state (nq,) of a stamp, of a scene with sensors."""
        self._assembler.add_true_state(stamp, q, v)

    def add_effort(self, stamp: int, effort: Sequence[float]) -> None:
        """Take the effort (nu,) applied from a stamp on."""
        self._last_message = time.monotonic()
        self._assembler.add_effort(stamp, effort)
        self.idle()

    def add_command(self, stamp: int, effort: Sequence[float]) -> None:
        """Take the effort (nu,) demanded in answer to the state of a stamp."""
        self._assembler.add_command(stamp, effort)

    def add_accepted(self, stamp: int, effort: Sequence[float] | None) -> None:
        """Take the effort (nu,) that the plant accepted for the state of a stamp, or None."""
        self._assembler.add_accepted(stamp, effort)

    def add_reference(self, stamp: int, target: Sequence[float]) -> None:
        """Take the target (nu,) that holds from a stamp on."""
        self._assembler.add_reference(stamp, target)

    def add_simulation_state(self, name: str) -> None:
        """Take the state of the simulation: playing, paused, ..."""
        if name != self._simulation_state and not self.write_error:
            self._writer.add_timeline_state(SIMULATION, "stopped", self._newest_step, name)
        self._simulation_state = name

    def add_timeline_state(self, timeline: str, normal: str, stamp: int, state: str) -> None:
        """Add a new state of a timeline, which begins as `normal`, from a stamp [ns] on."""
        if not self.write_error:
            step = min(max(1, stamp // self._scene.period_ns), self._newest_step)
            self._writer.add_timeline_state(timeline, normal, step, state)

    @property
    def recorded(self) -> int:
        """Steps on the disk, those in earlier parts among them."""
        return self._recorded_before + self._writer.recorded

    @property
    def lost_commands(self) -> int:
        """Steps without their command among those."""
        return self._assembler.lost_commands

    @property
    def _newest_step(self) -> int:
        return self.last_step + self._assembler.waiting + 1

    def idle(self) -> None:
        """Write waiting steps if they are due; to be called periodically."""
        waiting = self._assembler.waiting
        if waiting >= BLOCK_STEPS or (
            waiting and time.monotonic() - self._last_time >= BLOCK_SECONDS
        ):
            self._write(final=False)

    def save(self) -> None:
        """Write all waiting steps, at the end of a run."""
        self._write(final=True)

    def expect_messages(self) -> None:
        """Count the silence of `has_all` from now on."""
        self._last_message = time.monotonic()

    def has_all(self, steps: int | None) -> bool:
        """Whether `steps` steps (None: unknown) were received, or no more messages arrive."""
        limit = _SETTLING_TIME if steps is None else MESSAGE_TIMEOUT
        if self.write_error or time.monotonic() - self._last_message > limit:
            return True
        return steps is not None and self._assembler.has(steps)

    def finish(
        self, summary: Mapping[str, Any], time_limit: float = REPAIR_TIMEOUT
    ) -> dict[str, Any]:
        """Write the rest and the run's summary; return what the recorder adds to the summary.

        That is `recording`, `recorded_steps`, `lost_steps` (those without their command among them:
        `lost_commands`), and `error` where the file could not be written. Parts that could not be
        joined within `time_limit` seconds stay as they are, and are named as `parts`; a file of
        many chunks that was not compacted in that time keeps them.
        """
        start = time.monotonic()
        entries = self._complete(summary, time_limit)
        if self._blocks > MAX_BLOCKS and not {"error", "parts"} & entries.keys():
            compact(Path(entries["recording"]), time_limit - (time.monotonic() - start))
        return entries

    def _complete(self, summary: Mapping[str, Any], time_limit: float) -> dict[str, Any]:
        """Complete the file, or the one that parts are joined into; return what `finish` does."""
        start = time.monotonic()
        self.save()
        steps, lost_commands = summary.get("steps", self.last_step), self.lost_commands
        lost_steps = max(self.last_step, steps) - self.recorded + lost_commands
        entries = {"recorded_steps": self.recorded, "lost_steps": lost_steps}
        entries |= {"lost_commands": lost_commands} if lost_commands else {}
        errors = filter(
            None, (summary.get("error", ""), describe_gaps(self.recorded, steps, lost_commands))
        )
        metrics = {"steps": steps, **summary, "recording": str(self._writer.file.path), **entries}
        metrics |= {"error": error} if (error := "; ".join(errors)) else {}
        file = None if self.write_error else self._attempt(lambda: self._writer.close(metrics))
        if file is None:
            counts = describe_failure(
                self.recorded, self.recorded + lost_steps, self._steps_before_reset
            )
            entries |= {"error": f"recorder: {self.write_error}; {counts}"}
            files = self._parts.all(self._writer.file.part)
        else:
            files = self._parts.join(file, time_limit - (time.monotonic() - start))
        return (
            entries
            | {"recording": str(files[-1])}
            | ({"parts": list(map(str, files))} if files[1:] else {})
        )

    def _write(self, final: bool) -> None:
        rows = self._assembler.pop_rows(final)
        if rows and not self.write_error:
            self._attempt(lambda: self._writer.write(block_of(self._scene, rows)))
        if not rows or self.write_error:
            return
        self._blocks += 1
        step, written_at = rows[-1].step, time.monotonic()
        simulated = (step - self.last_step) * self._scene.period
        self._writer.add_speed(step, simulated / max(written_at - self._last_time, 1e-9))
        self.last_step, self._last_time = step, written_at

    def _attempt(self, work: Callable[[], Any]) -> Any:
        try:
            return work()
        except RecordingError as error:
            self.write_error = str(error)
            return None

    def _new_writer(self, path: Path) -> RunWriter:
        """Return a file's writer; recorders of one file's parts between resets share the id."""
        numbered = f"{self._run_id}-{self.resets}" if self._run_id and self.resets else self._run_id
        run_id = f"{self._scene.name}-{numbered or uuid.uuid4().hex[:12]}"
        return RunWriter(path, layout_of_scene(self._scene, run_id), self._live)

    def _start_over(self) -> None:
        """The plant was reset: keep the steps so far in a file of their own, and begin a new one.

        A file that could not be written stays as it is, and has no step behind the reset.
        """
        finished = self._complete({"scene": self._scene.name, "ended_by": "reset"}, REPAIR_TIMEOUT)
        self._assembler = _new_assembler(self._scene)
        self.last_step, self._last_time, self.resets, self._blocks = 0, 0.0, self.resets + 1, 0
        if self.write_error:
            self._steps_before_reset += self.recorded
            self._recorded_before, self._writer.recorded = 0, 0
            return
        self._recorded_before, self._writer.recorded = 0, 0
        files = [Path(file) for file in finished.get("parts", [finished["recording"]])]
        set_aside(files, before_reset(self._path, self.resets))
        self._parts = Parts(self._path, EarlierFiles())
        self.on_reset()
        self._writer = self._attempt(lambda: self._new_writer(self._path)) or self._writer
        # the plant publishes its state before the first step, and has not changed it where the run
        # was playing before
        state, self._simulation_state = self._simulation_state, ""
        if state:
            self.add_simulation_state(state)


def _new_assembler(scene: Scene, after: int = 0) -> StepAssembler:
    """Return an assembler of a scene's steps behind the step `after`."""
    return StepAssembler(scene.period_ns, scene.reference, scene.sampled, after, is_sensed(scene))


def warm_up(scene: Scene) -> None:
    """Compile the functions that derive the plots, before messages arrive."""
    effort = (0.0,) * len(scene.actuated)
    block_of(scene, [Row(1, scene.initial_q, scene.initial_v, effort, effort, scene.reference)])
