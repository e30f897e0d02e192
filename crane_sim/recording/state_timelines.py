"""Timelines of states that follow from the steps of a run, block by block."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.recording.states import BRAKES, CONTACT, EFFORTS, MIN_FORCE, TimelineInputs

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Block, Layout


class StateTimelines:
    """The last states of a run's timelines, from which their changes follow."""

    def __init__(self, layout: Layout, inputs: TimelineInputs) -> None:
        """Begin before the first step, all in their normal states."""
        self._layout, self._inputs = layout, inputs
        self._last: dict[str, str] = {}
        self._tripped = np.zeros(len(layout.actuated), dtype=bool)

    def find_changes(self, block: Block) -> Iterator[tuple[str, NDArray[np.int64], list[str]]]:
        """Yield (timeline, steps at which its state changes, the states from then on) of the next block."""
        for timeline, normal, other, where in self._evaluate(block):
            yield from self._compare(timeline, normal, block.step, np.where(where, other, normal))

    def find_change(
        self, timeline: str, normal: str, step: int, state: str
    ) -> Iterator[tuple[str, NDArray[np.int64], list[str]]]:
        """Yield the change of a timeline, which begins in the state `normal`, at one step, as `find_changes` does."""
        yield from self._compare(timeline, normal, np.array([step]), np.array([state]))

    def _compare(self, timeline: str, normal: str, step: NDArray[np.int64], values: Any) -> Any:
        known = timeline in self._last
        before = np.concatenate([[self._last.get(timeline, normal)], values[:-1]])
        rows = np.flatnonzero(values != before)
        if not rows.size:
            return
        self._last[timeline] = str(values[-1])
        steps, states = step[rows], [str(state) for state in values[rows]]
        if not known and steps[0] > 1:
            steps, states = np.concatenate([[1], steps]), [normal, *states]
        yield timeline, steps, states

    def _evaluate(self, block: Block) -> Iterator[tuple[str, str, Any, Any]]:
        """Yield (timeline, normal state, the other one, whether it is in that one (K,)) for the steps of a block."""
        layout = self._layout
        if layout.actuated and layout.commanded:
            yield BRAKES, "released", "acting", block.braked
        if layout.actuated and self._inputs.only_limits_change_efforts and layout.effort_units == layout.command_units:
            yield (
                EFFORTS,
                "free",
                "limited",
                (np.isfinite(block.demanded) & (block.demanded != block.effort)).any(axis=1),
            )
        for name, tension in zip(layout.ropes.tensions, block.tensions.T, strict=True):
            pushing = tension < -MIN_FORCE
            yield _short(name), "taut", np.where(pushing, "pushes", "slack"), tension <= MIN_FORCE
        if block.contact is not None:
            yield CONTACT, "apart", "touches", block.contact > MIN_FORCE
        yield from self._limit_switches(block)

    def _limit_switches(self, block: Block) -> Iterator[tuple[str, str, str, Any]]:
        """Yield the timelines of limit switches; a switch that has tripped stays so."""
        if self._inputs.limit_switches is None:
            return
        q, (low, high) = block.q[:, self._layout.driven], self._inputs.limit_switches
        tripped = np.logical_or.accumulate((q > high) | (q < low), axis=0) | self._tripped
        self._tripped = tripped[-1]
        for name, each in zip(self._layout.actuated, tripped.T, strict=True):
            yield f"limit switch of the {name}", "clear", "tripped", each


def _short(name: str) -> str:
    """Return the name of a link, a fall or the only rope, from that of its tension."""
    return {"rope tension": "rope", "tension of the top link": "link 1", "tension of fall 1": "fall 1"}.get(name, name)
