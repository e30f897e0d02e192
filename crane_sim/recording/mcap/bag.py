"""Writer of a run's messages, as serialized on the wire, into an MCAP file."""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from crane_sim.recording.files import before_reset, describe_failure
from crane_sim.recording.mcap.file import McapFile
from crane_sim.recording.mcap.topic import Topic, stamp_of

STATES, EFFORTS = "joint_states", "applied_effort"
SAVE_SECONDS = 0.5  # the part of a run that a killed process can lose
_MESSAGE_TIMEOUT = 2.0  # s without a message after which no more are expected
_SHARED_LATCHED = 100  # messages, such as one of each broadcaster of static transforms
_SETTLING_TIME = 0.1  # s without a message after which all sent ones count as received


@dataclass
class _TopicState:
    """State of a topic: number, newest stamp and message."""

    number: int
    topic: Topic
    count: int = 0
    stamp: int = 0  # of the newest message, ns
    latched: dict[bytes, None] = field(default_factory=dict)  # messages that hold, in order; of a
    # latched topic

    def latch(self, data: bytes) -> None:
        """Keep the newest message; of a topic that all nodes share, the newest different ones.

        Each of these may hold.
        """
        self.latched.pop(data, None)
        self.latched[data] = None
        while len(self.latched) > (_SHARED_LATCHED if self.topic.shared else 1):
            del self.latched[next(iter(self.latched))]


class Bag:
    """Writer of serialized messages, each at its stamp, or at the newest state's where it has none.

    Attributes:
        write_error: one line on why the file could not be written, empty while it can; messages are
            then ignored.
        last_step: the newest one of which all states and efforts are on the disk.
        resets: number of resets of the plant.
    """

    def __init__(
        self,
        path: Path,
        topics: Mapping[str, Topic],
        period_ns: int,
        after: int = 0,
        resets: int = 0,
        properties: Mapping[str, str] | None = None,
    ) -> None:
        """Start the file.

        Args:
            path: the complete file.
            topics: by the name that `callbacks` uses; `joint_states` and `applied_effort` are among
                them.
            period_ns: control period; state k carries k times this as its stamp.
            after: last step before the first message.
            resets: number of resets before that.
            properties: of the run, such as its scene.

        Raises:
            OSError: the file cannot be written.
        """
        self._path, self._period_ns, self._properties = path, period_ns, properties
        self._topic_states = {
            name: _TopicState(number, topic) for number, (name, topic) in enumerate(topics.items())
        }
        self._states, self._efforts = self._topic_states[STATES], self._topic_states[EFFORTS]
        self._file = self._new_file()
        self._now, self.resets = (after + 1) * period_ns, resets
        self._last_message = self._saved = time.monotonic()
        self.write_error, self.last_step, self._after = "", after, after
        # steps in a file that could not be written further, from before a reset
        self._steps_before_reset = 0

    def callbacks(self) -> dict[str, Callable[[bytes], None]]:
        """Return one function of a serialized message per topic."""
        return {
            name: partial(self._write_message, track) for name, track in self._topic_states.items()
        }

    def idle(self) -> None:
        """Save buffered messages if they are due; to be called periodically."""
        if time.monotonic() - self._saved > SAVE_SECONDS:
            self.save()

    def save(self) -> None:
        """Save all buffered messages."""
        if not self.write_error:
            self._attempt(self._file.save)
        self._saved = time.monotonic()
        if not self.write_error:
            # a last effort has no step
            complete_stamp = min(self._states.stamp - self._period_ns, self._efforts.stamp)
            self.last_step = max(complete_stamp // self._period_ns, self.last_step)

    def expect_messages(self) -> None:
        """Count the silence of `has_all` from now on."""
        self._last_message = time.monotonic()

    def has_all(self, steps: int | None) -> bool:
        """Whether all messages of `steps` steps (None: unknown) are here, or no more will come."""
        silence = time.monotonic() - self._last_message
        if self.write_error or silence > _MESSAGE_TIMEOUT:
            return True
        if steps is None or silence < _SETTLING_TIME:
            return False
        last = steps * self._period_ns
        return self._states.stamp >= last + self._period_ns and self._efforts.stamp >= last

    def finish(self, summary: Mapping[str, Any]) -> dict[str, Any]:
        """Complete the file; return its entries of the summary.

        They are `mcap`, and `error` if messages are missing.
        """
        self.save()
        steps = summary.get("steps", self.last_step) - self._after
        if not self.write_error:
            self._attempt(self._file.close, _describe_end(summary, steps))
        if self.write_error:
            counts = describe_failure(self.last_step - self._after, steps, self._steps_before_reset)
            return {
                "mcap": str(self._file.part),
                "error": f"recorder: {self.write_error}; {counts}",
            }
        # no effort follows the final state
        written = max(0, min(self._states.count - 1, self._efforts.count))
        if written >= steps:
            return {"mcap": str(self._path)}
        why = f"recorder: {self._path} is incomplete, it has {written} of {steps} steps"
        return {"mcap": str(self._path), "error": why}

    def abandon(self) -> None:
        """Remove the file."""
        self._file.abandon()

    def _write_message(self, track: _TopicState, data: bytes) -> None:
        if not track.topic.shared:
            self._last_message = time.monotonic()
        stamp = stamp_of(data) if track.topic.stamped else 0
        if track is self._states:
            if stamp < self._now:
                self._start_over()
            self._now = stamp
        if self.write_error:
            return
        if track.topic.latched:
            track.latch(data)
        track.count, track.stamp = track.count + 1, stamp
        self._attempt(self._file.write, track.number, stamp if stamp > 0 else self._now, data)

    def _start_over(self) -> None:
        """Keep the run before the plant's reset in its own file, and begin a new one.

        The new file starts with the latched messages.

        A file that could not be written stays as it is, and has no step behind the reset.
        """
        self.save()
        recorded = self.last_step - self._after
        self.resets += 1
        self._now, self.last_step, self._after = self._period_ns, 0, 0
        if not self.write_error:
            self._attempt(self._set_aside, recorded)
        if self.write_error:
            self._steps_before_reset += recorded
            return
        for track in self._topic_states.values():
            track.count = track.stamp = 0
            for data in tuple(track.latched):
                self._write_message(track, data)

    def _set_aside(self, recorded: int) -> None:
        self._file.close(_describe_end({"ended_by": "reset"}, recorded))
        self._path.replace(before_reset(self._path, self.resets))
        self._file = self._new_file()

    def _new_file(self) -> McapFile:
        return McapFile(
            self._path, [track.topic for track in self._topic_states.values()], self._properties
        )

    def _attempt(self, work: Callable[..., None], *arguments: Any) -> None:
        try:
            work(*arguments)
        except OSError as error:
            self.write_error = f"{self._file.part}: {error.strerror}"


def _describe_end(summary: Mapping[str, Any], steps: int) -> dict[str, str]:
    """Return what a file's end says: its number of steps, and how the run ended.

    It says whether the run failed or ended early.
    """
    return {"steps": str(steps)} | {
        key: str(summary[key]) for key in ("ended_by", "error") if key in summary
    }
