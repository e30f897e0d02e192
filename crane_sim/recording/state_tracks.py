"""Tracks of states that follow from the steps of a run, block by block."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.recording.states import BRAKES, CONTACT, EFFORTS, ZERO, Rules

if TYPE_CHECKING:
    from collections.abc import Iterator

    from numpy.typing import NDArray

    from crane_sim.recording.layout import Block, Layout


class StateTracks:
    """The states of a run so far, from which only changes are recorded."""

    def __init__(self, layout: Layout, rules: Rules) -> None:
        """Begin before the first step, all calm."""
        self._layout, self._rules = layout, rules
        self._now: dict[str, str] = {}
        self._tripped = np.zeros(len(layout.actuated), dtype=bool)

    def changes(self, block: Block) -> Iterator[tuple[str, NDArray[np.int64], list[str]]]:
        """Yield (track, steps at which its state changes, the states from then on) of the next block."""
        for track, calm, excited, where in self._tracks(block):
            values = np.where(where, excited, calm)
            yield from self._note(track, calm, block.step, values)

    def change(
        self, track: str, calm: str, step: int, state: str
    ) -> Iterator[tuple[str, NDArray[np.int64], list[str]]]:
        """Yield the change of a track at one step, as `changes` does."""
        yield from self._note(track, calm, np.array([step]), np.array([state]))

    def _note(self, track: str, calm: str, step: NDArray[np.int64], values: Any) -> Any:
        known = track in self._now
        before = np.concatenate([[self._now.get(track, calm)], values[:-1]])
        rows = np.flatnonzero(values != before)
        if not rows.size:
            return
        self._now[track] = str(values[-1])
        steps, states = step[rows], [str(state) for state in values[rows]]
        if not known and steps[0] > 1:
            steps, states = np.concatenate([[1], steps]), [calm, *states]
        yield track, steps, states

    def _tracks(self, block: Block) -> Iterator[tuple[str, str, Any, Any]]:
        """Yield (track, calm state, the other one, where that holds (K,)) of what follows from steps."""
        layout = self._layout
        if layout.actuated and layout.commanded:
            yield BRAKES, "released", "acting", block.braked
        if layout.actuated and self._rules.limited and layout.effort_units == layout.command_units:
            yield (
                EFFORTS,
                "free",
                "limited",
                (np.isfinite(block.demanded) & (block.demanded != block.effort)).any(axis=1),
            )
        for name, tension in zip(layout.ropes.tensions, block.tensions.T, strict=True):
            pushing = tension < -ZERO
            yield _short(name), "taut", np.where(pushing, "pushes", "slack"), tension <= ZERO
        if block.contact is not None:
            yield CONTACT, "apart", "touches", block.contact > ZERO
        yield from self._limit_switches(block)

    def _limit_switches(self, block: Block) -> Iterator[tuple[str, str, str, Any]]:
        """Yield the tracks of limit switches: one that has tripped stays so."""
        if self._rules.switches is None:
            return
        q, (low, high) = block.q[:, self._layout.driven], self._rules.switches
        tripped = np.logical_or.accumulate((q > high) | (q < low), axis=0) | self._tripped
        self._tripped = tripped[-1]
        for name, each in zip(self._layout.actuated, tripped.T, strict=True):
            yield f"limit switch of the {name}", "clear", "tripped", each


def _short(name: str) -> str:
    """Return the name of a link, a fall or the only rope, from that of its tension."""
    return {"rope tension": "rope", "tension of the top link": "link 1", "tension of fall 1": "fall 1"}.get(name, name)
