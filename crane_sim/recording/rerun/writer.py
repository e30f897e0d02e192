"""Writer of a run to a Rerun file: columns in blocks, checked after each, renamed when complete."""

from __future__ import annotations

from collections import defaultdict
from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr

from crane_sim.recording.blocks import StateTimelines
from crane_sim.recording.digest import Rows, describe_block, digest_changes, with_digest
from crane_sim.recording.layout import Block, Layout, Span
from crane_sim.recording.metric_units import summary_properties, summary_table
from crane_sim.recording.rerun.blueprint import blueprint
from crane_sim.recording.rerun.curves import PALETTE, Channel, channels
from crane_sim.recording.rerun.part_file import PartFile, RecordingError
from crane_sim.recording.rerun.scene3d import Scene3D
from crane_sim.recording.rerun.timelines import set_time, times, times_at
from crane_sim.recording.states import get_color, make_event_timelines, make_fault_timelines

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from crane_sim.recording.rerun.live import LiveServer
    from crane_sim.recording.states import Changes

APPLICATION = "crane_sim"
DIGESTS, EVENTS, STATES = "digests", "log/events", "states/"
"""Entities of digests and events, and beginning of those of timelines of states."""
SPEED = "plots/rtf"
# s of scene time: a longer run has no index, which needs 0.1 MB of memory a block
MAX_INDEXED_DURATION = 120.0


def is_verified(entity: str) -> bool:
    """Whether an entity's curves are read back and have digests; those only shown have none."""
    # speeds are logged beside the blocks
    return entity.startswith(("plots/", "frames/")) and entity != SPEED


class RunWriter:
    """A recording that grows by blocks in `<path>.part`, and becomes `<path>` when closed.

    Attributes:
        recorded: number of steps that reached the disk.
    """

    def __init__(self, path: Path, layout: Layout, live: LiveServer | None = None) -> None:
        """Start the file with blueprint, run properties, crane; recover a killed run's file.

        The recovered file is one of that name.

        Args:
            path: the complete recording's path; its folder is made when missing.
            layout: names and units of the run.
            live: serves the run to viewers, too.

        Raises:
            RecordingError: the file cannot be written.
        """
        self._layout, self._channels, self.recorded = layout, channels(layout), 0
        self._spans: dict[str, Span] = {}
        self._timelines = StateTimelines(layout)
        self._states = defaultdict[str, set[str]](set)  # known so far, by entity
        self._changes = list[str]()  # digests of events and states since the last block
        rr.set_strict_mode(True)  # otherwise a bad array is only warned about, and lost
        self._rec = rr.RecordingStream(APPLICATION, recording_id=layout.run_id)
        self._rec.set_log_time_enabled(False)  # wall time in the rows would make equal runs differ
        self._rec.set_log_tick_enabled(False)
        self.file = PartFile(path, self._rec)
        try:
            self._stage = self._begin(live)
        except RecordingError:
            self.file.discard()  # it has no step
            raise

    def _begin(self, live: LiveServer | None) -> Scene3D:
        with self.file.on_disk():
            self._connect(live)
            self._rec.send_recording_name(self._layout.name)
            self._rec.send_property("run", rr.AnyValues(**with_digest(self._layout.properties)))
            for channel in self._channels:
                if channel.colors:  # the others are no curves of a plot
                    self._rec.log(channel.entity, _style(channel), static=True)
            self._rec.log(
                SPEED,
                rr.SeriesLines(names="simulated s per s", colors=PALETTE[0], widths=1.6),
                static=True,
            )
            stage = Scene3D(self._rec, self._layout)
        self.file.check()
        return stage

    def _connect(self, live: LiveServer | None) -> None:
        indexed = self._layout.properties["duration"] <= MAX_INDEXED_DURATION
        served = [] if live is None else [live.sink(APPLICATION, self._layout.run_id)]
        views = blueprint(self._layout, live is not None)
        self.file.connect(views, *served, write_footer=indexed)
        if live is not None:
            # active: the page does not take the default one of a run that it joins
            self._rec.send_blueprint(views)

    def write(self, block: Block) -> None:
        """Append a block of steps: first what is read back and its digest, then what is only shown.

        Raises:
            RecordingError: it did not reach the disk, which is full or gone.
        """
        first, last = int(block.step[0]), int(block.step[-1])
        verified = [channel for channel in self._channels if is_verified(channel.entity)]
        rows = self._write_channels(block, verified)
        self._log_changes(self._timelines.find_changes(block))
        self._log_digest(first, last, rows)
        self._write_channels(
            block, [channel for channel in self._channels if not is_verified(channel.entity)]
        )
        self._stage.draw(block)
        self.file.check()
        self.recorded += len(block.step)

    def _log_digest(self, first: int, last: int, rows: Iterable[Rows]) -> None:
        """Log the digest of steps and of changes since the last one; `last` < `first`: no steps."""
        text = rr.TextDocument.columns(text=[describe_block(first, last, rows, self._changes)])
        self._rec.send_columns(DIGESTS, times(self._layout, np.array([max(last, 1)])), text)
        self._changes = []

    def _write_channels(self, block: Block, listed: Sequence[Channel]) -> list[Rows]:
        """Write the curves of a block; return their rows."""
        written = list[Rows]()
        for channel in listed:
            kept = np.flatnonzero((block.step - 1) % channel.stride == 0)
            values = channel.values(block)
            if values is None or not kept.size:
                continue
            step, values = block.step[kept], values[kept]
            width = values.size // len(kept)
            columns = rr.Scalars.columns(scalars=values.ravel()).partition([width] * len(kept))
            self._rec.send_columns(channel.entity, times(self._layout, step), columns)
            written.append(Rows(channel.entity, step, (step - 1) * self._layout.period_ns, values))
            self._widen_span(channel.entity, values[np.isfinite(values)])
        return written

    def add_speed(self, step: int, real_time_factor: float) -> None:
        """Add the simulated seconds per second before the start of a step."""
        self._log(step, SPEED, rr.Scalars(real_time_factor))

    def add_timeline_state(self, timeline: str, normal: str, step: int, state: str) -> None:
        """Add a new state of a timeline, which begins as `normal`, from a step's start on."""
        self._log_changes(self._timelines.find_change(timeline, normal, step, state))

    def add_events(self, events: Sequence[tuple[float, str]]) -> None:
        """Add events (s, text), and the timelines of states that follow from them."""
        if events:
            instants, texts = (
                np.array([round(1e9 * t) for t, _ in events]),
                [text for _, text in events],
            )
            rows = rr.TextLog.columns(text=texts, level=["INFO"] * len(texts))
            self._rec.send_columns(EVENTS, times_at(self._layout, instants), rows)
            self._changes += digest_changes(EVENTS, zip(instants.tolist(), texts, strict=True))
        self._log_timelines(make_event_timelines(events))

    def close(self, summary: Mapping[str, Any]) -> Path:
        """Write the summary, finish the file and give it its final name.

        Raises:
            RecordingError: the end did not reach the disk; what was written before stays in the
                `.part` file.
        """
        self._log_timelines(make_fault_timelines(summary))
        self._log_digest(1, 0, ())
        framing = self._stage.fit_to_motion() or self._layout.framing
        self._rec.send_blueprint(
            blueprint(self._layout._replace(framing=framing, spans=self._spans))
        )
        text = summary_table(self._layout.name, summary, self._layout.path_unit)
        self._rec.log(
            "summary/table", rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN), static=True
        )
        self._rec.send_property("summary", rr.AnyValues(**with_digest(summary_properties(summary))))
        return self.file.finish()

    def _widen_span(self, entity: str, values: NDArray[np.float64]) -> None:
        if values.size:
            known = self._spans.get(entity, Span(np.inf, -np.inf))
            self._spans[entity] = Span(min(known.low, values.min()), max(known.high, values.max()))

    def _log_changes(self, changes: Iterable[tuple[str, NDArray[np.int64], list[str]]]) -> None:
        """Log changes of timelines at the starts of steps."""
        for timeline, steps, states in changes:
            self._log_states(timeline, (steps - 1) * self._layout.period_ns, states)

    def _log_timelines(self, timelines: Mapping[str, Changes]) -> None:
        for timeline, changes in timelines.items():
            instants = np.array([round(1e9 * t) for t, _ in changes])
            self._log_states(timeline, instants, [state for _, state in changes])

    def _log_states(self, timeline: str, instants: NDArray[np.int64], states: list[str]) -> None:
        """Log a timeline's states from instants [ns] on, and the colours of its states so far."""
        entity = f"{STATES}{timeline.replace(' ', '_')}"
        self._changes += digest_changes(entity, zip(instants.tolist(), states, strict=True))
        if not self._states[entity].issuperset(states):
            self._states[entity].update(states)
            named = sorted(self._states[entity])
            colors = np.array([int(f"{get_color(state)[1:]}ff", 16) for state in named], np.uint32)
            self._rec.log(entity, rr.StateConfiguration(values=named, colors=colors), static=True)
        self._rec.send_columns(
            entity, times_at(self._layout, instants), rr.StateChange.columns(state=states)
        )

    def _log(self, step: int, entity: str, what: rr.TextLog | rr.Scalars) -> None:
        set_time(self._rec, self._layout, step)
        self._rec.log(entity, what)


def _style(channel: Channel) -> rr.SeriesLines:
    count = len(channel.names)
    colors, widths = list(channel.colors[:count]), [channel.width] * count
    return rr.SeriesLines(names=list(channel.names), colors=colors, widths=widths)
