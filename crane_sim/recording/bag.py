"""Keeps the messages of a run, in the very bytes that came over the wire, for the tools of others: an MCAP file."""

import shutil
import struct
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from crane_sim.recording.mcap_file import Channel, McapFile

STATES, EFFORTS = "joint_states", "applied_effort"
SAVE_SECONDS = 0.5  # at most so much of a run is lost with a killed process
_SILENCE, _QUIET = 2.0, 0.1  # s without a message until nothing is expected any more; until everything seems to be here
_SECOND = 1_000_000_000  # ns


@dataclass
class _Track:
    """A channel and what has come on it."""

    number: int
    channel: Channel
    count: int = 0
    stamp: int = 0  # of the newest message, ns
    newest: bytes = b""  # kept where the channel is latched


class Bag:
    """Takes serialized messages and writes each at its stamp, or at the newest state's where it has none.

    Attributes:
        broken: one line on why the file could not be written, empty while it can; messages are then ignored.
    """

    def __init__(self, path: Path, channels: Mapping[str, Channel], period_ns: int) -> None:
        """Start the file.

        Args:
            path: the complete file.
            channels: by the name that `takers` uses; `joint_states` and `applied_effort` are among them.
            period_ns: control period; state k carries k times this as its stamp.

        Raises:
            OSError: the file cannot be written.
        """
        self._path, self._period_ns = path, period_ns
        self._tracks = {name: _Track(i, channel) for i, (name, channel) in enumerate(channels.items())}
        self._channels = list(channels.values())
        self._file = McapFile(path, self._channels)
        self._now, self._passes = period_ns, 0
        self._heard = self._saved = time.monotonic()
        self.broken = ""

    def takers(self) -> dict[str, Callable[[bytes], None]]:
        """Return one function of a serialized message per channel."""
        return {name: partial(self._take, track) for name, track in self._tracks.items()}

    def idle(self) -> None:
        """Hand over what waits, when its time has come; to be called now and then."""
        if time.monotonic() - self._saved > SAVE_SECONDS and not self.broken:
            self._guarded(self._file.save)
            self._saved = time.monotonic()

    def has_all(self, steps: int | None) -> bool:
        """Whether the messages of `steps` steps (None: an unknown number) are here, or nothing more is coming."""
        silence = time.monotonic() - self._heard
        if self.broken or silence > _SILENCE:
            return True
        if steps is None or silence < _QUIET:
            return False
        states, efforts = self._tracks[STATES].stamp, self._tracks[EFFORTS].stamp
        return states >= (steps + 1) * self._period_ns and efforts >= steps * self._period_ns

    def finish(self, summary: Mapping[str, Any]) -> dict[str, Any]:
        """Complete the file; return what it adds to the run's summary: `mcap`, and `error` where something is missing."""
        if not self.broken:
            self._guarded(self._file.close)
        if self.broken:
            return {"mcap": str(self._file.part), "error": f"recorder: {self.broken}"}
        added = {"mcap": str(self._path)}
        steps = summary.get("steps", 0)
        found = min(self._tracks[STATES].count - 1, self._tracks[EFFORTS].count)  # the final state has no effort
        if found < steps:
            return added | {"error": f"recorder: {self._path} is incomplete, it has {max(found, 0)} of {steps} steps"}
        return added

    def abandon(self) -> None:
        """Remove the file, from which nothing will come."""
        self._file.abandon()

    def _take(self, track: _Track, data: bytes) -> None:
        if self.broken:
            return
        self._heard = time.monotonic()
        stamp = _stamp(data) if track.channel.stamped else 0
        if track.channel is self._tracks[STATES].channel:
            if stamp < self._now:
                self._start_over()
            self._now = stamp
        track.count += 1
        track.stamp = stamp
        if track.channel.latched:
            track.newest = data
        self._guarded(lambda: self._file.write(track.number, stamp if stamp > 0 else self._now, data))

    def _start_over(self) -> None:
        """The plant was reset: keep what was so far in a file of its own, and begin a new one with what still holds."""
        self._passes += 1
        self._guarded(self._begin_anew)
        self._now = self._period_ns
        for track in self._tracks.values():
            track.count, track.stamp = 0, 0
            if track.newest and not self.broken:
                self._take(track, track.newest)

    def _begin_anew(self) -> None:
        self._file.close()
        self._path.replace(self._path.with_name(f"{self._path.stem}.before_reset_{self._passes}.mcap"))
        self._file = McapFile(self._path, self._channels)

    def _guarded(self, work: Callable[[], None]) -> None:
        try:
            work()
        except OSError as error:
            self.broken = f"{self._file.part}: {error.strerror} ({_free(self._path.parent)} MB free on its disk)"


def _stamp(data: bytes) -> int:
    """Return the stamp, ns, of a serialized message that begins with a header."""
    seconds, nanoseconds = struct.unpack_from("<iI" if data[1] & 1 else ">iI", data, 4)
    return seconds * _SECOND + nanoseconds


def _free(folder: Path) -> int:
    return shutil.disk_usage(folder).free // 1_000_000
