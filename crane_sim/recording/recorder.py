"""Records a run from its messages, knowing stamps and numbers but no ROS: pairs, blocks, resets, failures."""

from __future__ import annotations

import time
from pathlib import Path
from typing import TYPE_CHECKING, Any

from crane_sim.recording.pairing import Pairing, Row
from crane_sim.recording.session import Session, block_of
from crane_sim.recording.writer import RecordingError

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from crane_sim.scene import Scene

BLOCK_STEPS, BLOCK_SECONDS = 2000, 0.5
SILENCE = 2.0  # s without a message until what is missing counts as lost


class Recorder:
    """Takes the messages of a run in any order between topics and writes complete steps in blocks.

    Attributes:
        broken: one line on why the recording could not be written, empty while it can; messages are then ignored.
    """

    def __init__(self, scene: Scene, path: Path, live_port: int | None = None) -> None:
        """Start the file.

        Raises:
            RecordingError: the file cannot be written.
        """
        self._scene, self._path = scene, path
        _warm_up(scene)
        self._session = Session(scene, path, live_port)
        self._pairing = Pairing(scene.period_ns, scene.reference, scene.sampled)
        self._mode, self._passes = "", 0
        self._last_step, self._last_time = 0, 0.0  # written, s of wall time
        self._heard = time.monotonic()
        self.broken = ""

    def state(self, stamp: int, q: Sequence[float], v: Sequence[float]) -> None:
        """Take the joint state (nq,) of a stamp [ns]."""
        self._heard = time.monotonic()
        if self._pairing.begins_anew(stamp):
            self._start_over()
        if not self._last_time:
            self._last_time = self._heard
        self._pairing.add_state(stamp, q, v)

    def effort(self, stamp: int, effort: Sequence[float]) -> None:
        """Take the effort (nu,) applied from a stamp on."""
        self._heard = time.monotonic()
        self._pairing.add_effort(stamp, effort)
        self._tend()

    def command(self, stamp: int, effort: Sequence[float]) -> None:
        """Take the effort (nu,) demanded in answer to the state of a stamp."""
        self._pairing.add_command(stamp, effort)

    def reference(self, stamp: int, target: Sequence[float]) -> None:
        """Take the target (nu,) that holds from a stamp on."""
        self._pairing.add_reference(stamp, target)

    def mode(self, name: str) -> None:
        """Take the simulation's mode."""
        if name != self._mode and not self.broken:
            self._session.mode(self._last_step + self._pairing.waiting + 1, name)
        self._mode = name

    def idle(self) -> None:
        """Write what waits, when its time has come; to be called now and then."""
        self._tend()

    def has_all(self, steps: int | None) -> bool:
        """Whether `steps` steps (None: an unknown number) have come in, or nothing more is coming."""
        if self.broken or time.monotonic() - self._heard > SILENCE:
            return True
        return steps is not None and self._session.recorded + self._pairing.complete >= steps

    def finish(self, summary: Mapping[str, Any]) -> dict[str, Any]:
        """Write the rest and the run's summary; return what the recorder adds to the summary.

        That is `recording`, `recorded_steps`, `lost_steps`, and `error` where the file could not be written.
        """
        self._write(final=True)
        lost = max(self._pairing.lost, summary.get("steps", 0) - self._session.recorded)
        closed = None if self.broken else self._guarded(lambda: self._session.close(summary, lost))
        return closed or self._session.broken(self.broken, lost)

    def _tend(self) -> None:
        waiting = self._pairing.waiting
        due = time.monotonic() - self._last_time >= BLOCK_SECONDS
        if waiting >= BLOCK_STEPS or (waiting and due):
            self._write(final=False)

    def _write(self, final: bool) -> None:
        rows = self._pairing.take(final)
        if rows and not self.broken:
            self._guarded(lambda: self._session.write(rows))
        if not rows or self.broken:
            return
        step, now = rows[-1].step, time.monotonic()
        simulated = (step - self._last_step) * self._scene.period
        self._session.pace(step, simulated / max(now - self._last_time, 1e-9))
        self._last_step, self._last_time = step, now

    def _guarded(self, work: Callable[[], Any]) -> Any:
        try:
            return work()
        except RecordingError as error:
            self.broken = str(error)
            return None

    def _start_over(self) -> None:
        """The plant was reset: keep the steps so far in a file of their own, and begin a new one."""
        self._passes += 1
        done = self.finish({"scene": self._scene.name, "ended_by": "reset"})
        self._pairing = Pairing(self._scene.period_ns, self._scene.reference, self._scene.sampled)
        self._last_step, self._last_time = 0, 0.0
        if not self.broken:
            self._path.replace(self._path.with_name(f"{self._path.stem}.before_reset_{self._passes}.rrd"))
            self._session = self._guarded(lambda: Session(self._scene, Path(done["recording"]))) or self._session


def _warm_up(scene: Scene) -> None:
    """Compile what derives the plots now, not while messages pile up."""
    effort = (0.0,) * len(scene.actuated)
    block_of(scene, [Row(1, scene.initial_q, scene.initial_v, effort, effort, scene.reference)])
