"""Recorded runs from blocks of steps, without a file: as they would be read back from their recordings."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from crane_sim.recording.blocks import block_of_rollout
from crane_sim.recording.layout import of_rollout
from crane_sim.recording.run import AnimationFrames, RecordedRun, crane_of
from crane_sim.recording.states import StateTimelines, make_event_timelines, make_fault_timelines
from crane_sim.simulation.flat_summary import plain

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from crane_sim.recording.layout import Block, Layout
    from crane_sim.recording.states import Changes
    from crane_sim.simulation.rollout import Rollout


def run_of_rollout(rollout: Rollout) -> RecordedRun:
    """Return a run of `simulate`.

    Raises:
        ValueError: it has samples at other times than its control periods.
    """
    block, steps = block_of_rollout(rollout), rollout.summary["steps"]
    entries = {"recorded_steps": steps, "lost_steps": 0}
    return run_of_block(of_rollout(rollout, ""), block, rollout.summary | entries, rollout.events)


def run_of_block(
    layout: Layout, block: Block, summary: Mapping[str, Any], events: Sequence[tuple[float, str]] = ()
) -> RecordedRun:
    """Return the run of a block that has all its steps."""
    t = 1e-9 * ((block.step - 1) * layout.period_ns).astype(np.float64)
    measured = np.hsplit(block.measured, 2) if layout.sensed and block.measured is not None else (None, None)
    return RecordedRun(
        path=None,
        crane=crane_of(layout.properties),
        properties={key: value for key, value in layout.properties.items() if key not in ("crane", "urdf")},
        t=t,
        q=block.q,
        v=block.v,
        q_measured=measured[0],
        v_measured=measured[1],
        u=block.effort,
        commands=block.demanded,
        reference=block.reference,
        tip=block.nodes[:, layout.ropes.tip],
        payload=block.nodes[:, -1],
        frames=_frames(layout, block, t),
        states=_states(layout, block, summary, events),
        events=[(round(1e9 * time) / 1e9, text) for time, text in events],
        summary=json.loads(json.dumps(summary, default=plain)),
        **{name: getattr(block, name) for name in ("base", "tensions", "reeved", "swing", "contact")},
        **{name: getattr(block, name) for name in ("kinetic", "potential", "lyapunov")},
    )


def _frames(layout: Layout, block: Block, t: Any) -> AnimationFrames:
    kept = (block.step - 1) % layout.frame_stride == 0
    shown = block.part(kept)
    target = None if shown.target is None else shown.target[:, -1]
    return AnimationFrames(t[kept], shown.nodes, target, layout.fall_ends(shown))


def _states(
    layout: Layout, block: Block, summary: Mapping[str, Any], events: Sequence[tuple[float, str]]
) -> dict[str, Changes]:
    timelines = make_event_timelines(events) | make_fault_timelines(summary)
    for timeline, steps, states in StateTimelines(layout).find_changes(block):
        timelines[timeline] = [*zip(((steps - 1) * layout.period_ns / 1e9).tolist(), states, strict=True)]
    return {name.replace("_", " "): timelines[name] for name in sorted(timelines)}
