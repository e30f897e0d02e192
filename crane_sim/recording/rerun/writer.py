"""Writer of one run to a Rerun file: columns in blocks, checked after each, renamed when complete."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
import rerun as rr

from crane_sim.recording.digest import with_digest
from crane_sim.recording.layout import Block, Layout, Span
from crane_sim.recording.rerun.block_digests import EVENTS, STATES, DigestWriter, is_verified
from crane_sim.recording.rerun.blueprint import blueprint
from crane_sim.recording.rerun.curves import PALETTE, Channel, channels
from crane_sim.recording.rerun.errors import RecordingError
from crane_sim.recording.rerun.part_file import PartFile
from crane_sim.recording.rerun.scene3d import Scene3D
from crane_sim.recording.rerun.summary import summary_properties, summary_table
from crane_sim.recording.rerun.timelines import set_time, times, times_at
from crane_sim.recording.state_timelines import StateTimelines
from crane_sim.recording.states import COLORS, OTHER_COLOR, make_event_timelines, make_fault_timelines

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence
    from pathlib import Path

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Array
    from crane_sim.recording.rerun.live import LiveServer
    from crane_sim.recording.states import Changes

APPLICATION = "crane_sim"
MAX_INDEXED_DURATION = (
    120.0  # s of scene time; the file of a longer run has no index, which needs 0.1 MB of memory a block
)


class RunWriter:
    """A recording that grows block by block in `<path>.part` and becomes `<path>` when it is closed."""

    def __init__(self, path: Path, layout: Layout, live: LiveServer | None = None) -> None:
        """Start the file with the blueprint, the run properties and the crane; recover a killed run's of that name.

        Args:
            path: the complete recording's path; its folder is made when missing.
            layout: names and units of the run.
            live: serves the run to viewers, too.

        Raises:
            RecordingError: the file cannot be written.
        """
        self._layout, self._channels = layout, channels(layout)
        self._strides = {channel.stride for channel in self._channels}
        self._spans: dict[str, Span] = {}
        self._timelines, self._named = StateTimelines(layout, layout.timeline_inputs), dict[str, set[str]]()
        rr.set_strict_mode(True)  # otherwise a bad array is only warned about, and lost
        self._rec = rr.RecordingStream(APPLICATION, recording_id=layout.run_id)
        self._rec.set_log_time_enabled(False)  # wall time in the rows would make equal runs differ
        self._rec.set_log_tick_enabled(False)
        self._digests, self.file = DigestWriter(self._rec, layout), PartFile(path, self._rec)
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
            self._log_styles()
            stage = Scene3D(self._rec, self._layout)
        self.file.check()
        return stage

    def _connect(self, live: LiveServer | None) -> None:
        indexed = self._layout.properties["duration"] <= MAX_INDEXED_DURATION
        served = [] if live is None else [live.sink(APPLICATION, self._layout.run_id)]
        views = blueprint(self._layout, live is not None)
        self.file.connect(views, *served, write_footer=indexed)
        if live is not None:
            self._rec.send_blueprint(views)  # active: the page does not take the default one of a run that it joins

    def write(self, block: Block) -> None:
        """Append a block of steps: first what is read back and its digest, then what is only shown.

        Raises:
            RecordingError: it did not reach the disk, which is full or gone.
        """
        self._write_channels(block, [channel for channel in self._channels if is_verified(channel.entity)])
        for timeline, steps, states in self._timelines.find_changes(block):
            self._log_states(timeline, self._instants(steps), states)
        self._digests.log(int(block.step[0]), int(block.step[-1]))
        self._write_channels(block, [channel for channel in self._channels if not is_verified(channel.entity)])
        self._stage.draw(block)
        self.file.check()

    def _write_channels(self, block: Block, listed: Sequence[Channel]) -> None:
        rows = {stride: np.flatnonzero((block.step - 1) % stride == 0) for stride in self._strides}
        time = {stride: times(self._layout, block.step[those]) for stride, those in rows.items()}
        for channel in listed:
            values, those = channel.values(block), rows[channel.stride]
            if values is None or not those.size:
                continue
            columns = rr.Scalars.columns(scalars=values[those].ravel())
            widths = [values.size // len(block.step)] * len(those)
            self._rec.send_columns(channel.entity, time[channel.stride], columns.partition(widths))
            self._digests.add_rows(channel.entity, block.step[those], values[those])
            self._widen_span(channel.entity, values[np.isfinite(values)])

    def add_note(self, step: int, text: str) -> None:
        """Add a line to the recording's log at the start of a step."""
        self._log(step, "log/recorder", rr.TextLog(text, level="INFO"))

    def add_speed(self, step: int, real_time_factor: float) -> None:
        """Add the simulated seconds per second before the start of a step."""
        self._log(step, "plots/rtf", rr.Scalars(real_time_factor))

    def add_timeline_state(self, timeline: str, normal: str, step: int, state: str) -> None:
        """Add that a timeline, which begins in the state `normal`, has another one from the start of a step on."""
        for _, steps, states in self._timelines.find_change(timeline, normal, step, state):
            self._log_states(timeline, self._instants(steps), states)
            self._digests.log()

    def add_events(self, events: Sequence[tuple[float, str]]) -> None:
        """Add events (s, text), and the timelines of states that follow from them."""
        if events:
            instants, texts = np.array([round(1e9 * t) for t, _ in events]), [text for _, text in events]
            rows = rr.TextLog.columns(text=texts, level=["INFO"] * len(texts))
            self._rec.send_columns(EVENTS, times_at(self._layout, instants), rows)
            self._digests.add_changes(EVENTS, instants, texts)
        self._log_timelines(make_event_timelines(events))

    def close(self, summary: Mapping[str, Any]) -> Path:
        """Write the summary, finish the file and give it its final name.

        Raises:
            RecordingError: the end did not reach the disk; what was written before stays in the `.part` file.
        """
        self._log_timelines(make_fault_timelines(summary))
        self._digests.log()
        framing = self._stage.fit_to_motion() or self._layout.framing
        self._rec.send_blueprint(blueprint(self._layout._replace(framing=framing, spans=self._spans)))
        text = summary_table(self._layout.name, summary, self._layout.path_unit)
        self._rec.log("summary/table", rr.TextDocument(text, media_type=rr.MediaType.MARKDOWN), static=True)
        self._rec.send_property("summary", rr.AnyValues(**with_digest(summary_properties(summary))))
        return self.file.finish()

    def _widen_span(self, entity: str, values: Array) -> None:
        if values.size:
            known = self._spans.get(entity, Span(np.inf, -np.inf))
            self._spans[entity] = Span(min(known.low, values.min()), max(known.high, values.max()))

    def _log_styles(self) -> None:
        for channel in self._channels:
            if channel.colors:  # the others are no curves of a plot
                self._rec.log(channel.entity, _style(channel), static=True)
        speed = rr.SeriesLines(names="simulated s per s", colors=PALETTE[0], widths=1.6)
        self._rec.log("plots/rtf", speed, static=True)

    def _log_timelines(self, timelines: Mapping[str, Changes]) -> None:
        for timeline, changes in timelines.items():
            instants = np.array([round(1e9 * t) for t, _ in changes])
            self._log_states(timeline, instants, [state for _, state in changes])

    def _log_states(self, timeline: str, instants: NDArray[np.int64], states: list[str]) -> None:
        """Log the states of a timeline from instants [ns] on, and the colours of states that are new to it."""
        entity, named = f"{STATES}{timeline.replace(' ', '_')}", self._named.setdefault(timeline, set())
        if not named.issuperset(states):
            named.update(states)
            shown = [int(f"{COLORS.get(state, OTHER_COLOR)[1:]}ff", 16) for state in sorted(named)]
            colors = np.array(shown, np.uint32)  # a list of three would be one colour
            self._rec.log(entity, rr.StateConfiguration(values=sorted(named), colors=colors), static=True)
        self._rec.send_columns(entity, times_at(self._layout, instants), rr.StateChange.columns(state=states))
        self._digests.add_changes(entity, instants, states)

    def _instants(self, steps: NDArray[np.int64]) -> NDArray[np.int64]:
        """Return the instants [ns] at which steps begin."""
        return (steps - 1) * self._layout.period_ns

    def _log(self, step: int, entity: str, what: rr.TextLog | rr.Scalars) -> None:
        set_time(self._rec, self._layout, step)
        self._rec.log(entity, what)


def _style(channel: Channel) -> rr.SeriesLines:
    count = len(channel.names)
    return rr.SeriesLines(
        names=list(channel.names), colors=list(channel.colors[:count]), widths=[channel.width] * count
    )
