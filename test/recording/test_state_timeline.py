"""Timelines of states: what steps, events, metrics say of brakes, ropes, contacts, faults."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from recording_samples import RowWriter, rows_at_rest

import crane_sim
from crane_sim.recording.blocks import StateTimelines, block_of_rollout
from crane_sim.recording.layout import of_rollout
from crane_sim.recording.rerun.writer import RunWriter
from crane_sim.recording.run import RecordedRun
from crane_sim.recording.states import (
    COLORS,
    CONTROLLER,
    TimelineInputs,
    make_event_timelines,
    make_spans,
)
from crane_sim.report.page_data import page_data

CHANGES: dict[str, Any] = {
    "duration": 0.3,
    "faults": {
        "sticky_boom": {"kind": "stuck", "joint": "boom", "at": 0.05, "until": 0.15},
        "dark": {"kind": "sensor_loss", "joint": "swing_tangential", "at": 0.2},
    },
    "actuators.slew.limit_switches": [-1.0, 0.004],
}


@pytest.fixture(scope="module")
def rollout() -> crane_sim.Rollout:
    """Run a crane with two faults, whose slew meets a limit switch."""
    return crane_sim.simulate("knuckle_bench", overrides=CHANGES)


@pytest.fixture(scope="module")
def run(rollout: crane_sim.Rollout, tmp_path_factory: pytest.TempPathFactory) -> RecordedRun:
    """Return the run, recorded and read back."""
    return crane_sim.read_recording(rollout.record(tmp_path_factory.mktemp("states") / "run.rrd"))


def test_faults_and_switches_are_timelines(rollout: crane_sim.Rollout, run: RecordedRun) -> None:
    """A recording has faults at the scene's times, a limit switch from the first step beyond."""
    assert run.states["fault sticky boom"] == [(0.0, "off"), (0.05, "on"), (0.15, "off")]
    assert run.states["fault dark"] == [(0.0, "off"), (0.2, "on")]
    assert set(rollout.summary["overtravel"]) == {"slew"}, (
        "the scene's own metrics must agree that it tripped"
    )
    beyond = rollout.t[np.argmax(rollout.q[:, 0] > 0.004)]
    assert run.states["limit switch of the slew"] == [
        (0.0, "clear"),
        (pytest.approx(beyond, abs=1e-9), "tripped"),
    ]
    assert "brakes" not in run.states and "rope" not in run.states, (
        "what keeps its normal state has no timeline"
    )


def test_a_page_has_the_timelines_as_bands(run: RecordedRun) -> None:
    """The bands of a page cover the run without a gap, each with the colour of its state."""
    rows = page_data(run)["states"]
    assert [row["name"] for row in rows] == list(run.states)
    for row in rows:
        begins, ends = [span[0] for span in row["spans"]], [span[1] for span in row["spans"]]
        assert begins == [0.0, *ends[:-1]] and ends[-1] == pytest.approx(0.3, abs=1e-12), row[
            "name"
        ]
        assert all(COLORS[state] == color for _, _, state, color in row["spans"])


def test_timelines_follow_from_steps(rollout: crane_sim.Rollout) -> None:
    """Brakes act as the plant says; slack ropes have no tension, contacts have a force.

    Limited efforts differ from the demanded ones.

    A lost command (step 21) is no braking. A change at the boundary of two blocks is recorded once,
    and nothing of a timeline that keeps its normal state.
    """
    block, layout = block_of_rollout(rollout), of_rollout(rollout, "states")
    layout = layout._replace(effort_units=layout.command_units)
    demanded, tensions, contact = (
        block.effort.copy(),
        np.full_like(block.tensions, 5.0),
        np.zeros(len(block.step)),
    )
    braked = np.zeros(len(block.step), dtype=bool)
    demanded[10:12], demanded[14, 1], demanded[20], braked[10:12] = np.nan, 1e9, np.nan, True
    tensions[12:18, 0], tensions[18, 0], contact[3:15] = 0.0, -2.0, 1.0
    block = block._replace(demanded=demanded, braked=braked, tensions=tensions, contact=contact)
    timelines, found = (
        StateTimelines(layout._replace(timeline_inputs=TimelineInputs(None, True))),
        dict[str, list[tuple[int, str]]](),
    )
    for rows in (slice(0, 15), slice(15, None)):
        for timeline, steps, states in timelines.find_changes(block.part(rows)):
            found.setdefault(timeline, []).extend(zip(steps.tolist(), states, strict=True))
    assert found == {
        "brakes": [(1, "released"), (11, "acting"), (13, "released")],
        "efforts": [(1, "free"), (15, "limited"), (16, "free")],
        "rope": [(1, "taut"), (13, "slack"), (19, "pushes"), (20, "taut")],
        "contact": [(1, "apart"), (4, "touches"), (16, "apart")],
    }


def test_messages_add_timelines(rollout: crane_sim.Rollout, tmp_path: Path) -> None:
    """What a plant says of its controller is a timeline, in which a repeated state is no change."""
    writer = RunWriter(tmp_path / "run.rrd", of_rollout(rollout, "messages"))
    writer.write(block_of_rollout(rollout))
    for step, state in ((3, "answers"), (8, "silent"), (9, "silent"), (12, "answers")):
        writer.add_timeline_state(CONTROLLER, "answers", step, state)
    states = crane_sim.read_recording(writer.close(rollout.summary)).states[CONTROLLER]
    assert states == [
        (0.0, "answers"),
        (pytest.approx(0.07), "silent"),
        (pytest.approx(0.11), "answers"),
    ]


def test_events_that_change_states_are_timelines() -> None:
    """Friction, drives with play and exchanged payloads have timelines; other events have none."""
    events = [
        (0.5, "the trolley sticks"),
        (0.7, "the trolley slips backwards"),
        (0.8, "drive 2 of the bridge is in its play"),
        (0.9, "payload of 3000 kg let go, 1000 kg hang now"),
        (1.0, "the payload changed"),
        (1.5, "the bridge slips forwards"),
    ]
    assert make_event_timelines(events) == {
        "friction of the trolley": [(0.0, "moves"), (0.5, "sticks"), (0.7, "slips backwards")],
        "friction of the bridge": [(0.0, "sticks"), (1.5, "slips forwards")],
        "drive 2 of the bridge": [(0.0, "meshes"), (0.8, "is in its play")],
        "payload": [(0.0, "as at the start"), (0.9, "1000 kg")],
    }


def test_short_spans_do_not_hide_what_happened() -> None:
    """A short slack stays a span of its own; a normal state too short to be drawn is merged."""
    changes = [
        (0.0, "taut"),
        (1.0, "slack"),
        (1.001, "taut"),
        (1.002, "slack"),
        (1.003, "taut"),
        (2.0, "slack"),
    ]
    assert make_spans(changes, 0.0, 3.0, 0.01) == [
        (0.0, 1.0, "taut"),
        (1.0, 1.003, "slack"),
        (1.003, 2.0, "taut"),
        (2.0, 3.0, "slack"),
    ]
    assert make_spans(changes, 1.5, 3.0, 0.01) == [(1.5, 2.0, "taut"), (2.0, 3.0, "slack")]


def test_states_of_one_instant_are_in_their_order(tmp_path: Path) -> None:
    """Changes at one instant are read back in their recorded order, not in that of names."""
    scene = crane_sim.load_scene("knuckle_setpoint")
    session = RowWriter(scene, tmp_path / "run.rrd")
    session.write_rows(rows_at_rest(scene, 10))
    for name in ("playing", "paused"):
        session.add_timeline_state("simulation", "stopped", 5, name)
    file = session.finish({"scene": scene.name, "steps": 10})["recording"]
    assert [state for _, state in crane_sim.read_recording(file).states["simulation"]][-2:] == [
        "playing",
        "paused",
    ]
